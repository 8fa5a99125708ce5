// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/published/frame.h"

#include "bytes/byte_writer.h"
#include "bytes/checksum.h"
#include "codec/frame_failures.h"
#include "codec/frame_limits.h"
#include "codec/published/entropy_coder.h"
#include "codec/published/tree_serialization.h"

#include <algorithm>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

namespace {

/** \brief CRC-32 of a frame's symbols, and of an I-frame's grid; the layout has no
 * checksum to distinguish frames of the same number.
 * \param[in] grid null for a P-frame
 */
std::uint32_t
checksumOf(const VoxelGrid* grid,
           const std::vector<std::uint8_t>& occupancy,
           const std::vector<std::uint8_t>& intensities)
{
  std::vector<std::uint8_t> grid_bytes;
  if (grid != nullptr) {
    ByteWriter writer(grid_bytes);
    writer.f64(grid->resolution);
    for (const double coordinate : grid->origin)
      writer.f64(coordinate);
  }
  std::uint32_t checksum = chainedChecksum(0, grid_bytes.data(), grid_bytes.size());
  checksum = chainedChecksum(checksum, occupancy.data(), occupancy.size());
  return chainedChecksum(checksum, intensities.data(), intensities.size());
}

/** \brief The most branches that a frame of so many voxels may have: those of its
 * voxels, and some without voxels. */
std::size_t
mostBranches(std::uint64_t voxels, unsigned int depth)
{
  constexpr std::size_t without_voxels = 4096;
  return maxBranchNodes(voxels, depth) + without_voxels;
}

/** \brief Appends a count and as many range coded symbols. */
void
writeSymbols(const std::vector<std::uint8_t>& symbols, std::vector<std::uint8_t>& bytes)
{
  ByteWriter(bytes).u64(symbols.size());
  encodeStaticRange(symbols, bytes);
}

/** \brief Reads a count and as many range coded symbols. */
CompressionStatus
readSymbols(ByteSource& source,
            std::size_t max_count,
            const std::string& what,
            std::vector<std::uint8_t>& symbols)
{
  const std::uint64_t count = source.u64();
  if (source.failure() == ByteSource::Failure::None && count > max_count)
    return {CompressionCode::LimitExceeded,
            std::to_string(count) + " " + what + " exceed the limit on voxels"};
  if (decodeStaticRange(source, static_cast<std::size_t>(count), symbols))
    return {};
  return source.failure() != ByteSource::Failure::None
             ? failedRead(source, "the " + what)
             : corruptFrame("invalid " + what);
}

/** \brief Replaces the history with a completely coded frame. Does not throw, so that a
 * frame that fails leaves the history unchanged. */
void
replaceHistory(std::uint32_t frame_number,
               const VoxelGrid& grid,
               OccupancyTree&& tree,
               History& history) noexcept
{
  static_assert(std::is_nothrow_copy_assignable_v<VoxelGrid> &&
                    std::is_nothrow_move_assignable_v<OccupancyTree>,
                "a history is replaced completely or not at all");
  history.has_frame = true;
  history.frame_number = frame_number;
  history.grid = grid;
  history.tree = std::move(tree);
}

} // namespace

void
encodeFrame(const VoxelFrame& frame,
            bool is_i_frame,
            History& history,
            std::vector<std::uint8_t>& bytes,
            CodedFrameStatistics& statistics)
{
  OccupancyTree tree;
  tree.build(frame.keys, frame.grid.depth);
  std::vector<std::uint8_t> symbols;
  serializeTree(tree, is_i_frame ? nullptr : &history.tree, symbols);

  const std::size_t begin = bytes.size();
  statistics.frame_number = history.frame_number + 1;
  writeFrameHeader({statistics.frame_number, is_i_frame, frame.size(), frame.grid},
                   bytes);
  statistics.header_bytes = bytes.size() - begin;
  writeSymbols(symbols, bytes);
  statistics.occupancy_bytes = bytes.size() - begin - statistics.header_bytes;

  symbols.resize(frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i)
    symbols[i] = static_cast<std::uint8_t>(frame.intensities[i]);
  writeSymbols(symbols, bytes);
  statistics.bytes = bytes.size() - begin;
  statistics.intensity_bytes =
      statistics.bytes - statistics.header_bytes - statistics.occupancy_bytes;
  replaceHistory(statistics.frame_number, frame.grid, std::move(tree), history);
}

CompressionStatus
decodeFrame(ByteSource& source,
            const DecoderLimits& limits,
            History& history,
            FrameOrder& order,
            VoxelFrame& frame,
            CodedFrameStatistics& statistics)
{
  FrameHeader header;
  const std::size_t most_voxels = frameLimits(limits, 0).max_voxels;
  if (CompressionStatus status = readFrameHeader(source, limits, header); !status.ok())
    return status;
  const bool is_i_frame = header.is_i_frame;
  const bool has_reference =
      is_i_frame ||
      (history.has_frame && history.frame_number + 1 == header.frame_number);
  frame.grid = is_i_frame ? header.grid : history.grid;
  statistics.frame_number = header.frame_number;
  statistics.is_i_frame = is_i_frame;
  statistics.header_bytes = magic_size + source.consumed();

  std::vector<std::uint8_t> occupancy;
  const unsigned int depth = has_reference ? frame.grid.depth : max_grid_depth;
  const std::uint64_t max_voxels = is_i_frame ? header.voxel_count : most_voxels;
  if (CompressionStatus status = readSymbols(
          source,
          std::min(maxBranchNodes(most_voxels, depth), mostBranches(max_voxels, depth)),
          "occupancy bytes",
          occupancy);
      !status.ok())
    return status;
  statistics.occupancy_bytes = magic_size + source.consumed() - statistics.header_bytes;
  std::vector<std::uint8_t> intensities;
  if (CompressionStatus status =
          readSymbols(source, most_voxels, "intensities", intensities);
      !status.ok())
    return status;
  statistics.intensity_bytes = magic_size + source.consumed() -
                               statistics.header_bytes - statistics.occupancy_bytes;
  // A frame is refused only when all of it was read, so that the next call continues
  // after it.
  const std::uint32_t checksum =
      checksumOf(is_i_frame ? &frame.grid : nullptr, occupancy, intensities);
  if (!is_i_frame && order.isOld(header.frame_number, checksum, false))
    return oldFrame(header.frame_number);
  if (!has_reference)
    return missingReference(header.frame_number,
                            history.has_frame ? std::optional(history.frame_number)
                                              : std::nullopt);

  if (is_i_frame && header.voxel_count != intensities.size())
    return corruptFrame("its counts of voxels differ");
  if (occupancy.size() > mostBranches(intensities.size(), depth))
    return corruptFrame("more branch nodes than its voxels can have");
  OccupancyTree tree;
  tree.reset(frame.grid.depth);
  if (!deserializeTree(occupancy,
                       is_i_frame ? nullptr : &history.tree,
                       intensities.size(),
                       tree,
                       frame.keys))
    return corruptFrame("the occupancy bytes are not an octree of " +
                        std::to_string(intensities.size()) + " voxels");
  if (is_i_frame && order.isOld(header.frame_number, checksum, true))
    return oldFrame(header.frame_number);
  frame.intensities.assign(intensities.begin(), intensities.end());
  frame.intensity_scale = IntensityScale();
  frame.depth_model.reset();
  frame.colour_bits = 0;
  frame.colours.clear();
  frame.has_point_counts = false;
  frame.point_counts.clear();
  frame.fields.clear();
  frame.viewpoint = {};
  frame.points = FramePoints();
  if (!isConsistent(frame))
    return corruptFrame("invalid voxels");

  replaceHistory(header.frame_number, frame.grid, std::move(tree), history);
  order.decoded(header.frame_number, checksum, !frame.keys.empty());
  return {};
}

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

#include "codec/published/frame.h"

#include "bytes/byte_writer.h"
#include "bytes/checksum.h"
#include "codec/published/entropy_coder.h"
#include "voxels/child_masks.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

namespace pcl_ext {
namespace io {
namespace published {

namespace {

// "minValue" in PCL's box arithmetic; a box is not enlarged by less.
constexpr double box_tolerance = 1.1920928955078125e-7;

/** \brief Writes the tree depth first, as PCL serializes it: for each branch node its
 * occupancy byte, XOR-ed with that of the same node in the reference. */
class DepthFirstWriter {
public:
  DepthFirstWriter(const OccupancyTree& tree,
                   const OccupancyTree* reference,
                   std::vector<std::uint8_t>& symbols)
  : tree_(tree), symbols_(symbols)
  {
    if (reference != nullptr)
      for (unsigned int level = 0; level < tree.depth(); ++level)
        reference_[level] = OccupancyCursor(reference->level(level));
  }

  void
  write(unsigned int level)
  {
    // Depth first visits the nodes of one level in ascending order.
    const std::size_t index = next_[level]++;
    const std::uint64_t node = tree_.level(level).nodes[index];
    const std::uint8_t occupancy = tree_.level(level).occupancy[index];
    symbols_.push_back(
        static_cast<std::uint8_t>(occupancy ^ reference_[level].occupancyOf(node)));
    if (level + 1 == tree_.depth())
      return;
    for (unsigned int child = child_masks.count[occupancy]; child > 0; --child)
      write(level + 1);
  }

private:
  const OccupancyTree& tree_;
  std::vector<std::uint8_t>& symbols_;
  std::array<OccupancyCursor, max_grid_depth> reference_;
  std::array<std::size_t, max_grid_depth> next_{};
};

/** \brief Counterpart of DepthFirstWriter: fills a tree and the keys of its voxels. */
class DepthFirstReader {
public:
  DepthFirstReader(const std::vector<std::uint8_t>& symbols,
                   const OccupancyTree* reference,
                   std::size_t voxel_count,
                   OccupancyTree& tree,
                   std::vector<std::uint64_t>& keys)
  : symbols_(symbols), voxel_count_(voxel_count), tree_(tree), keys_(keys)
  {
    if (reference != nullptr)
      for (unsigned int level = 0; level < tree.depth(); ++level)
        reference_[level] = OccupancyCursor(reference->level(level));
  }

  /** \brief Reads a node and all below it; false if the symbols are not a tree or its
   * voxels too many.
   *
   * A branch may have no children: where PCL enlarges an octree that has no voxel of the
   * frame yet, the old root stays below the new one. Such a branch is not kept, as to the
   * next frame it is the same as one that is not there.
   */
  bool
  read(unsigned int level, std::uint64_t node)
  {
    if (position_ == symbols_.size())
      return false;
    const auto occupancy = static_cast<std::uint8_t>(
        symbols_[position_++] ^ reference_[level].occupancyOf(node));
    if (occupancy == 0)
      return true;
    tree_.level(level).push(node, occupancy);
    if (level + 1 == tree_.depth())
      return addVoxels(node, occupancy);
    for (unsigned int i = 0; i < child_masks.count[occupancy]; ++i)
      if (!read(level + 1, node << 3 | child_masks.children[occupancy][i]))
        return false;
    return true;
  }

  /** \brief True if all symbols were read and all voxels found. */
  bool
  isComplete() const
  {
    return position_ == symbols_.size() && keys_.size() == voxel_count_;
  }

private:
  bool
  addVoxels(std::uint64_t branch, std::uint8_t occupancy)
  {
    const unsigned int count = child_masks.count[occupancy];
    if (keys_.size() + count > voxel_count_)
      return false;
    for (unsigned int i = 0; i < count; ++i)
      keys_.push_back(branch << 3 | child_masks.children[occupancy][i]);
    return true;
  }

  const std::vector<std::uint8_t>& symbols_;
  std::size_t voxel_count_;
  OccupancyTree& tree_;
  std::vector<std::uint64_t>& keys_;
  std::array<OccupancyCursor, max_grid_depth> reference_;
  std::size_t position_ = 0;
};

CompressionStatus
corrupt(const std::string& what)
{
  return {CompressionCode::Corrupt, "published frame: " + what};
}

CompressionStatus
oldFrame(std::uint32_t number)
{
  return {CompressionCode::OldFrame,
          "published frame " + std::to_string(number) +
              " came late, or twice; it was dropped"};
}

/** \brief Tells a frame from another one of its number: CRC-32 of its symbols, and of an
 * I-frame's grid.
 * \param[in] grid null for a P-frame
 */
std::uint32_t
checksumOf(const VoxelGrid* grid,
           const std::vector<std::uint8_t>& occupancy,
           const std::vector<std::uint8_t>& intensities)
{
  std::vector<std::uint8_t> place;
  if (grid != nullptr) {
    ByteWriter writer(place);
    writer.f64(grid->resolution);
    for (const double coordinate : grid->anchor)
      writer.f64(coordinate);
  }
  std::uint32_t checksum = chainedChecksum(0, place.data(), place.size());
  checksum = chainedChecksum(checksum, occupancy.data(), occupancy.size());
  return chainedChecksum(checksum, intensities.data(), intensities.size());
}

CompressionStatus
readFailure(const ByteSource& source, const std::string& what)
{
  switch (source.failure()) {
  case ByteSource::Failure::EndOfInput:
    return {CompressionCode::Truncated,
            "published frame: the stream ends in its " + what};
  case ByteSource::Failure::LimitExceeded:
    return {CompressionCode::LimitExceeded,
            "published frame: larger than the limit on bytes"};
  case ByteSource::Failure::None:
    break;
  }
  return corrupt("invalid " + what);
}

/** \brief Reads the octree box of an I-frame and makes the grid of it. */
CompressionStatus
readGrid(ByteSource& source, VoxelGrid& grid)
{
  grid.resolution = source.f64();
  std::array<double, 3> max;
  for (double& corner : grid.anchor)
    corner = source.f64();
  for (double& corner : max)
    corner = source.f64();
  if (source.failure() != ByteSource::Failure::None)
    return readFailure(source, "header");

  // The end of the lattice at the largest resolution.
  constexpr double largest_coordinate =
      largest_resolution * static_cast<double>(std::int64_t{1} << max_grid_depth);
  if (!(grid.resolution >= smallest_resolution &&
        grid.resolution <= largest_resolution))
    return corrupt("the resolution is not within 1e-6 to 1e6 m");
  const double side = max[0] - grid.anchor[0];
  const double depth = std::round(std::log2(side / grid.resolution));
  if (!(depth >= 1.0 && depth <= static_cast<double>(max_grid_depth)))
    return corrupt("the box does not fit an octree of 1 to 21 levels");
  grid.depth = static_cast<unsigned int>(depth);
  grid.first_index = {0, 0, 0};
  // PCL keeps a box that is within its tolerance of the octree's cube at both ends; to
  // that adds the rounding of doubles of the box's size.
  const double cube = static_cast<double>(grid.size()) * grid.resolution;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double magnitude = std::max(std::abs(max[axis]), std::abs(grid.anchor[axis]));
    if (!(magnitude < largest_coordinate) ||
        !(std::abs(max[axis] - grid.anchor[axis] - cube) <=
          2.0 * box_tolerance + 1e-12 * magnitude))
      return corrupt("the box is not the octree's cube");
  }
  return {};
}

/** \brief The most branches that a frame of so many voxels may have: those of its voxels,
 * and some without voxels. */
std::size_t
mostBranches(std::uint64_t voxels, unsigned int depth)
{
  constexpr std::size_t without_voxels = 4096;
  return maxBranchNodes(voxels, depth) + without_voxels;
}

/** \brief Reads a frame's header.
 * \param[out] grid of an I-frame
 * \param[in,out] voxel_count of an I-frame
 */
CompressionStatus
readHeader(ByteSource& source,
           const DecoderLimits& limits,
           VoxelGrid& grid,
           std::uint64_t& voxel_count,
           CodedFrameStatistics& statistics)
{
  statistics.frame_number = source.u32();
  const std::uint8_t frame_type = source.u8();
  if (source.failure() == ByteSource::Failure::None && frame_type > 1)
    return corrupt("neither I-frame nor P-frame");
  statistics.is_i_frame = frame_type == 1;
  if (!statistics.is_i_frame)
    return {};
  voxel_count = source.u64();
  if (const CompressionStatus status = readGrid(source, grid); !status.ok())
    return status;
  if (voxel_count > limits.max_voxels)
    return {CompressionCode::LimitExceeded,
            "published frame: " + std::to_string(voxel_count) +
                " voxels are more than the limit of " +
                std::to_string(limits.max_voxels)};
  return {};
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
            "published frame: " + std::to_string(count) + " " + what +
                " are more than the limit on voxels allows"};
  return decodeStaticRange(source, static_cast<std::size_t>(count), symbols)
             ? CompressionStatus()
             : readFailure(source, what);
}

/** \brief Makes the octree and its voxels of a frame's occupancy bytes; false if these are
 * not an octree of that many voxels. */
bool
readTree(const std::vector<std::uint8_t>& symbols,
         const OccupancyTree* reference,
         std::size_t voxel_count,
         VoxelFrame& frame,
         OccupancyTree& tree)
{
  tree.reset(frame.grid.depth);
  frame.keys.clear();
  DepthFirstReader reader(symbols, reference, voxel_count, tree, frame.keys);
  return reader.read(0, 0) && reader.isComplete();
}

/** \brief Replaces the history with a frame that was coded whole. Nothing throws from here
 * on, so that a frame that fails leaves the history as it was. */
void
remember(std::uint32_t frame_number,
         const VoxelGrid& grid,
         OccupancyTree&& tree,
         History& history) noexcept
{
  static_assert(std::is_nothrow_copy_assignable_v<VoxelGrid> &&
                    std::is_nothrow_move_assignable_v<OccupancyTree>,
                "a history is replaced whole or not at all");
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
  if (frame.keys.empty())
    symbols.push_back(0); // the root of an empty tree
  else
    DepthFirstWriter(tree, is_i_frame ? nullptr : &history.tree, symbols).write(0);

  const std::size_t begin = bytes.size();
  statistics.frame_number = history.frame_number + 1;
  ByteWriter writer(bytes);
  writer.raw(magic, magic_size);
  writer.u32(statistics.frame_number);
  writer.u8(is_i_frame ? 1 : 0);
  if (is_i_frame) {
    writer.u64(frame.size());
    writer.f64(frame.grid.resolution);
    for (std::size_t axis = 0; axis < 3; ++axis)
      writer.f64(frame.grid.lowerCorner(axis));
    for (std::size_t axis = 0; axis < 3; ++axis)
      writer.f64(frame.grid.lowerCorner(axis) +
                 static_cast<double>(frame.grid.size()) * frame.grid.resolution);
  }
  statistics.header_bytes = bytes.size() - begin;
  writer.u64(symbols.size());
  encodeStaticRange(symbols, bytes);
  statistics.occupancy_bytes = bytes.size() - begin - statistics.header_bytes;

  symbols.resize(frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i)
    symbols[i] = static_cast<std::uint8_t>(frame.intensities[i]);
  writer.u64(symbols.size());
  encodeStaticRange(symbols, bytes);
  statistics.bytes = bytes.size() - begin;
  statistics.intensity_bytes =
      statistics.bytes - statistics.header_bytes - statistics.occupancy_bytes;
  remember(statistics.frame_number, frame.grid, std::move(tree), history);
}

CompressionStatus
decodeFrame(ByteSource& source,
            const DecoderLimits& limits,
            History& history,
            FrameOrder& order,
            VoxelFrame& frame,
            CodedFrameStatistics& statistics)
{
  std::uint64_t voxel_count = limits.max_voxels;
  if (const CompressionStatus status =
          readHeader(source, limits, frame.grid, voxel_count, statistics);
      !status.ok())
    return status;
  const bool has_reference =
      statistics.is_i_frame ||
      (history.has_frame && history.frame_number + 1 == statistics.frame_number);
  if (!statistics.is_i_frame)
    frame.grid = history.grid;

  statistics.header_bytes = magic_size + source.consumed();
  std::vector<std::uint8_t> occupancy;
  const unsigned int depth = has_reference ? frame.grid.depth : max_grid_depth;
  if (CompressionStatus status =
          readSymbols(source,
                      std::min(maxBranchNodes(limits.max_voxels, depth),
                               mostBranches(voxel_count, depth)),
                      "occupancy bytes",
                      occupancy);
      !status.ok())
    return status;
  statistics.occupancy_bytes = magic_size + source.consumed() - statistics.header_bytes;
  std::vector<std::uint8_t> intensities;
  if (CompressionStatus status =
          readSymbols(source, limits.max_voxels, "intensities", intensities);
      !status.ok())
    return status;
  statistics.intensity_bytes = magic_size + source.consumed() -
                               statistics.header_bytes - statistics.occupancy_bytes;
  // Only now, so that the next call finds the source behind the frame.
  const std::uint32_t checksum =
      checksumOf(statistics.is_i_frame ? &frame.grid : nullptr, occupancy, intensities);
  if (!statistics.is_i_frame && order.isOld(statistics.frame_number, checksum, false))
    return oldFrame(statistics.frame_number);
  if (!has_reference)
    return {CompressionCode::MissingReference,
            "published P-frame " + std::to_string(statistics.frame_number) +
                " depends on the frame before it, which was not decoded"};

  if (statistics.is_i_frame && voxel_count != intensities.size())
    return corrupt("two different counts of voxels");
  if (occupancy.size() > mostBranches(intensities.size(), depth))
    return corrupt("more branch nodes than its voxels can have");
  OccupancyTree tree;
  if (!readTree(occupancy,
                statistics.is_i_frame ? nullptr : &history.tree,
                intensities.size(),
                frame,
                tree))
    return corrupt("the occupancy bytes are not a tree of its " +
                   std::to_string(intensities.size()) + " voxels");
  if (statistics.is_i_frame && order.isOld(statistics.frame_number, checksum, true))
    return oldFrame(statistics.frame_number);
  frame.intensities.assign(intensities.begin(), intensities.end());
  frame.intensity_scale = IntensityScale();
  frame.depth_model.reset();
  if (!isConsistent(frame))
    return corrupt("inconsistent voxels");

  remember(statistics.frame_number, frame.grid, std::move(tree), history);
  order.decoded(statistics.frame_number, checksum, !frame.keys.empty());
  return {};
}

} // namespace published
} // namespace io
} // namespace pcl_ext

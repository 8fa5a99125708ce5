// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Decoding of changes as targets that read streams check it: added up they are
 * the frames that another decoder decodes from the same bytes.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_changes.h>

#include "checked_decoding.h"
#include "codec/published/frame.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace pcl_ext {
namespace fuzz {

/** \brief Symbols and colours by key. */
using VoxelMap = std::map<std::uint64_t, std::pair<std::uint32_t, std::uint32_t>>;

inline VoxelMap
voxelMapOf(const io::VoxelFrame& frame)
{
  VoxelMap voxels;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelColour colour =
        frame.colour_bits > 0 ? frame.colours[i] : io::VoxelColour();
    voxels[frame.keys[i]] = {frame.hasIntensities() ? frame.intensities[i] : 0u,
                             std::uint32_t{colour.r} << 16 |
                                 std::uint32_t{colour.g} << 8 | colour.b};
  }
  return voxels;
}

/** \brief Applies changes, and requires that they are what differs. */
inline void
applyChanges(const io::VoxelChanges& changes, VoxelMap& voxels)
{
  requireWhole(changes.gone);
  requireWhole(changes.came);
  if (changes.is_from_nothing) {
    require(changes.gone.keys.empty());
    voxels.clear();
  }
  const VoxelMap gone = voxelMapOf(changes.gone);
  for (const auto& [key, value] : gone) {
    const auto found = voxels.find(key);
    require(found != voxels.end() && found->second == value);
    voxels.erase(found);
  }
  const bool are_comparable =
      changes.areOfOneGrid() && changes.gone.depth_model == changes.came.depth_model;
  require(are_comparable || voxels.empty());
  for (const auto& [key, value] : voxelMapOf(changes.came)) {
    const auto was = gone.find(key);
    require(!are_comparable || was == gone.end() || was->second != value);
    require(voxels.emplace(key, value).second);
  }
}

/** \brief Where the next frame may begin after a byte. */
inline std::size_t
nextMagic(const std::uint8_t* data, std::size_t size, std::size_t begin)
{
  const auto find = [&](const char* magic, std::size_t magic_size) {
    const auto* const found = std::search(
        data + begin, data + size, magic, magic + magic_size, [](auto byte, char c) {
          return byte == static_cast<std::uint8_t>(c);
        });
    return static_cast<std::size_t>(found - data);
  };
  return std::min(find(io::version1_magic, io::version1_magic_size),
                  find(io::published::magic, io::published::magic_size));
}

/** \brief Decodes a stream as whole frames and as changes, which have to agree. */
inline void
requireSameChanges(const std::uint8_t* data, std::size_t size)
{
  io::FrameDecoder whole(smallLimits());
  io::FrameDecoder changing(smallLimits());
  io::VoxelFrame frame;
  io::VoxelFrame latest;
  io::VoxelChanges changes;
  VoxelMap voxels;
  bool has_frame = false;
  for (std::size_t begin = 0; begin < size;) {
    const io::CompressionStatus status =
        whole.decode(data + begin, size - begin, frame);
    require(changing.decode(data + begin, size - begin, changes).code() ==
            status.code());
    if (status.ok()) {
      require(changes.is_from_nothing == !has_frame);
      has_frame = true;
      applyChanges(changes, voxels);
      require(voxels == voxelMapOf(frame));
      require(changes.came.grid == frame.grid);
      begin += whole.statistics().skipped_bytes + whole.statistics().bytes;
    }
    else {
      require(changes.gone.keys.empty() && changes.came.keys.empty());
      const std::size_t failed = nextMagic(data, size, begin);
      begin = nextMagic(data, size, std::min(failed + 1, size));
    }
    require(changing.latestVoxels(latest) == has_frame);
    require(voxelMapOf(latest) == voxels);
  }
}

} // namespace fuzz
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Streams in which most voxels stay as they are from frame to frame. Integers
 * only, so that every machine makes the same.
 */
#pragma once

#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <cstdint>
#include <iterator>
#include <map>
#include <random>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief A wall, of whose voxels and those about it some change with each frame. */
class ChangingFrames {
public:
  static constexpr unsigned int depth = 7;

  /** \param[in] bits of a symbol, 0: no intensities
   * \param[in] has_depth_model of intensities
   * \param[in] is_fine one voxel in each 4 x 4 x 4, so that I-frames have a refinement
   */
  explicit ChangingFrames(unsigned int bits,
                          bool has_depth_model = false,
                          bool is_fine = false)
  : frame_(emptyFrame(is_fine ? depth + 2 : depth, bits))
  , end_(std::uint64_t{1} << bits)
  , is_fine_(is_fine)
  {
    if (is_fine)
      frame_.grid.resolution = 0.001;
    if (has_depth_model)
      frame_.depth_model = roomDepthModel(depth, bits, 1);
    for (std::uint32_t x = 0; x < 36; ++x)
      for (std::uint32_t y = 0; y < 36; ++y)
        voxels_[mortonKey({x, y, 40 + x / 9})] = symbol();
  }

  const VoxelFrame&
  next(unsigned int changes)
  {
    for (unsigned int i = 0; i < changes; ++i) {
      const auto near = std::next(
          voxels_.begin(), static_cast<std::ptrdiff_t>(below(random_, voxels_.size())));
      switch (below(random_, 4)) {
      case 0:
        voxels_.erase(near);
        break;
      case 1:
        near->second = symbol();
        break;
      case 2:
        voxels_[near->first ^ (std::uint64_t{1} << below(random_, 6))] = symbol();
        break;
      default:
        // In a corner that others come to as well.
        voxels_[(std::uint64_t{3} << (3 * depth - 3)) + below(random_, 4096)] =
            symbol();
      }
    }
    clearVoxels(frame_);
    for (const auto& [key, value] : voxels_) {
      frame_.keys.push_back(is_fine_ ? key << 6 | key * 37 % 64 : key);
      if (frame_.hasIntensities())
        frame_.intensities.push_back(value);
    }
    return frame_;
  }

private:
  std::uint16_t
  symbol()
  {
    return static_cast<std::uint16_t>(
        below(random_, below(random_, 8) == 0 || end_ < 8 ? end_ : 8));
  }

  VoxelFrame frame_;
  std::uint64_t end_;
  bool is_fine_;
  std::mt19937_64 random_{43};
  std::map<std::uint64_t, std::uint16_t> voxels_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::test

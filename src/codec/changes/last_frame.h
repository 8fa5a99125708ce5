// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

/** \brief A block of the last frame, or one whose voxels vanished lately. */
struct Block {
  std::uint64_t key;              ///< Morton key of the block
  std::uint64_t cells;            ///< occupied in the last frame
  std::uint64_t recently_changed; ///< cells that appeared or vanished lately
  std::uint8_t change_history;    ///< a bit for each of the last frames, the last one
                                  ///< lowest: 1 where the block changed
  std::uint8_t voxels;            ///< number of occupied cells
};

/** \brief What a frame of changes refers to (doc/bitstream_changes.md, "Last frame").
 */
struct LastFrame {
  std::vector<Block> blocks;          ///< ascending
  std::vector<std::uint16_t> symbols; ///< of the voxels; empty without intensities
  std::size_t voxel_count = 0;
};

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io

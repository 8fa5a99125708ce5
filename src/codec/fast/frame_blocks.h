// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "codec/fast/history.h"
#include "voxels/octant_list.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief A frame while it is coded; passed from stage to stage. */
struct FrameBlocks {
  bool is_apart = false;  ///< coded without the history, as an I-frame is
  unsigned int depth = 0; ///< of the grid
  std::size_t voxel_count = 0;
  std::size_t max_blocks = 0;       ///< decoder only: most new blocks
  bool has_too_many_blocks = false; ///< decoding failed since there are more

  /** \brief Occupied cells by block number of the history. An encoder sets it in
   * matchHistory(), a decoder as voxels are decoded. */
  std::vector<std::uint64_t> occupied;

  /** \brief Voxels decoded so far. */
  std::size_t found_voxels = 0;

  // Blocks that are not in the history, ascending.
  std::vector<std::uint64_t> new_keys;
  std::vector<std::uint64_t> new_masks;

  // Set by NewVoxels. Vectors with a count are in use up to it.
  std::vector<std::uint8_t> octant_symbols; ///< by tracked block; 0 without new voxels
  std::size_t renewed_count = 0;
  std::vector<std::uint32_t>
      renewed_blocks; ///< indices of tracked blocks with new voxels

  // Set by HistoryUpdate: the blocks of the frame, ascending.
  std::size_t block_count = 0;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint64_t> masks;
  std::vector<std::uint32_t> numbers;  ///< block numbers in the history
  OctantList octants;                  ///< of the blocks
  std::vector<CellIndex> cell_indices; ///< of the voxels, in Morton order

  /** \brief Makes room for blocks. */
  void
  ensureBlocks(std::size_t count)
  {
    ensureSize(keys, count);
    ensureSize(masks, count);
    ensureSize(numbers, count);
  }
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

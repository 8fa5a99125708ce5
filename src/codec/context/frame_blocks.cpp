// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/frame_blocks.h"

#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/block_division.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

void
FrameBlocks::begin(const History& history)
{
  const std::vector<HistoryBlock>& tracked = history.blocks();
  new_keys.clear();
  target_keys.clear();
  target_masks.clear();
  reserveAhead(target_cells, tracked.size());
  target_cells.assign(tracked.size(), 0);
  blocks.clear(tracked.size() + tracked.size() / 8);
  for (const HistoryBlock& block : tracked)
    blocks.append(block.key);
}

std::size_t
FrameBlocks::match(const History& history, const BlockList& coded)
{
  begin(history);
  const std::vector<HistoryBlock>& tracked = history.blocks();
  std::size_t tracked_voxels = 0;
  const auto set_cells = [&](std::size_t i, std::uint64_t cells, std::size_t) {
    target_cells[i] = cells;
    tracked_voxels += bitCount(cells & tracked[i].tracked);
  };
  divideBlocks(tracked,
               coded.keys.data(),
               coded.masks.data(),
               coded.size(),
               set_cells,
               target_keys,
               target_masks);
  return tracked_voxels;
}

void
FrameBlocks::collect(const History& history, BlockList& coded) const
{
  coded.clear();
  const std::vector<HistoryBlock>& tracked = history.blocks();
  std::uint32_t voxels = 0;
  const auto append = [&](std::uint64_t key, std::uint64_t mask) {
    if (mask == 0)
      return;
    coded.append(key, mask, voxels);
    voxels += bitCount(mask);
  };
  walkSideBySide(
      tracked,
      new_keys,
      [&](std::size_t old) { append(tracked[old].key, blocks[old].present); },
      [&](std::size_t added, std::size_t) {
        append(new_keys[added], blocks[tracked.size() + added].present);
        return true;
      });
}

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

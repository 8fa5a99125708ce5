// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/frame_blocks.h"

#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"

namespace pcl_ext {
namespace io {
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
  AscendingLookup<HistoryBlock> lookup(tracked);
  std::size_t tracked_voxels = 0;
  for (std::size_t i = 0; i < coded.size(); ++i) {
    const std::size_t old = lookup.find(coded.keys[i]);
    if (old != not_in_list) {
      target_cells[old] = coded.masks[i];
      tracked_voxels += bitCount(coded.masks[i] & tracked[old].tracked);
    }
    else {
      target_keys.push_back(coded.keys[i]);
      target_masks.push_back(coded.masks[i]);
    }
  }
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
} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * How an encoder's frame differs from the last one.
 */
#include "codec/changes/change_coder.h"
#include "codec/fast/payload.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/block_division.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

namespace {

/** \brief Key of the block of a voxel; above all others behind the last voxel. */
std::uint64_t
blockKeyAt(const VoxelFrame& frame, std::size_t voxel)
{
  return voxel < frame.size() ? frame.keys[voxel] >> block_key_bits : ~std::uint64_t{0};
}

/** \brief The cells of a block from a voxel on, which is set to the one behind them. */
std::uint64_t
takeCells(const VoxelFrame& frame, std::uint64_t block_key, std::size_t& voxel)
{
  std::uint64_t cells = 0;
  for (; blockKeyAt(frame, voxel) == block_key; ++voxel)
    cells |= std::uint64_t{1} << frame.keys[voxel] % block_cells;
  return cells;
}

/** \brief Appends the change of a block.
 * \param[in] changed cells
 * \param[in] cells in the frame
 */
void
addChange(const LastFrame& last,
          std::size_t index,
          std::uint64_t changed,
          std::uint64_t cells,
          std::vector<ChangedBlock>& blocks)
{
  ChangedBlock& block = blocks.emplace_back();
  last.beginChange(index, block);
  block.changed = changed;
  block.cells = cells;
}

} // namespace

bool
ChangeCoder::hasOtherVoxels(const VoxelFrame& frame) const
{
  constexpr std::size_t samples = 64;
  if (last_keys_.empty())
    return false;
  std::size_t others = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const std::size_t voxel = i * frame.size() / samples;
    const auto last =
        std::lower_bound(last_keys_.begin(), last_keys_.end(), frame.keys[voxel]);
    const bool is_same =
        last != last_keys_.end() && *last == frame.keys[voxel] &&
        (!frame.hasIntensities() ||
         last_.symbols[static_cast<std::size_t>(last - last_keys_.begin())] ==
             frame.intensities[voxel]);
    others += is_same ? 0 : 1;
  }
  return 2 * others > samples;
}

std::size_t
ChangeCoder::countChanges(CodingWorkspace& memory, const VoxelFrame& frame)
{
  fast::FrameBlocks& blocks = memory.fast().frame;
  voxel_count_ = frame.size();
  is_taken_ = false;
  collectBlocks();
  now_.assign(frame.keys);
  changes_ = &memory.changes();
  changes_->blocks.clear();
  std::size_t changes = 0;
  std::size_t before = 0; // voxels of the last frame
  const auto compare = [&](std::size_t i, std::uint64_t cells, std::size_t now) {
    const std::uint64_t was = last_.blocks[i].cells;
    std::uint64_t changed = was ^ cells;
    const std::size_t voxels = last_.voxels[i];
    const bool has_symbols = frame.hasIntensities() && (was & cells) != 0;
    const std::uint16_t* old_symbol = has_symbols ? &last_.symbols[before] : nullptr;
    const std::uint16_t* symbol =
        has_symbols ? &frame.intensities[now_.first_voxels[now]] : nullptr;
    before += voxels;
    if (has_symbols &&
        !(was == cells && std::equal(symbol, symbol + voxels, old_symbol)))
      for (std::uint64_t left = was | cells; left != 0; left &= left - 1) {
        const std::uint64_t cell = left & (~left + 1);
        if ((was & cells & cell) != 0 && *symbol != *old_symbol)
          changed |= cell;
        symbol += (cells & cell) != 0 ? 1 : 0;
        old_symbol += (was & cell) != 0 ? 1 : 0;
      }
    if (changed == 0)
      return;
    changes += bitCount(changed);
    addChange(last_, i, changed, cells, changes_->blocks);
  };
  divideBlocks(last_.blocks,
               now_.keys.data(),
               now_.masks.data(),
               now_.size(),
               compare,
               blocks.new_keys,
               blocks.new_masks);
  for (const std::uint64_t cells : blocks.new_masks)
    changes += bitCount(cells);
  return changes;
}

std::optional<ChangeCoder::ChangedFrame>
ChangeCoder::takeChanges(CodingWorkspace& memory, const VoxelChanges& changes)
{
  const VoxelFrame& gone = changes.gone;
  const VoxelFrame& came = changes.came;
  fast::FrameBlocks& blocks = memory.fast().frame;
  blocks.new_keys.clear();
  blocks.new_masks.clear();
  collectBlocks();
  changes_ = &memory.changes();
  changes_->blocks.clear();
  ChangedFrame frame;
  std::size_t occupied = 0; // blocks of the last frame, with those that came
  AscendingLookup<Block> known(last_.blocks);
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < gone.size() || j < came.size()) {
    const std::uint64_t key = std::min(blockKeyAt(gone, i), blockKeyAt(came, j));
    const std::uint64_t cells_gone = takeCells(gone, key, i);
    const std::uint64_t cells_came = takeCells(came, key, j);
    frame.changes += bitCount(cells_gone | cells_came);
    const std::size_t block = known.find(key);
    const std::uint64_t cells = block == not_in_list ? 0 : last_.blocks[block].cells;
    const bool has_what_went = (cells_gone & ~cells) == 0;
    const bool has_room = (cells_came & cells & ~cells_gone) == 0;
    const bool has_symbols = gone.hasIntensities() || (cells_came & cells_gone) == 0;
    if (!has_what_went || !has_room || !has_symbols)
      return std::nullopt;
    const std::uint64_t cells_now = (cells & ~cells_gone) | cells_came;
    if (block == not_in_list) {
      blocks.new_keys.push_back(key);
      blocks.new_masks.push_back(cells_came);
    }
    else {
      addChange(last_, block, cells_gone | cells_came, cells_now, changes_->blocks);
    }
    frame.blocks += cells_now != 0 ? 1 : 0;
    occupied += cells != 0 ? 1 : 0;
  }
  frame.blocks += last_.occupied_blocks - occupied;
  frame.voxels = last_.voxel_count + came.size() - gone.size();
  voxel_count_ = frame.voxels;
  is_taken_ = true;
  return frame;
}

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io

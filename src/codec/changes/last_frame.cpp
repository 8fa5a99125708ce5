// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/changes/last_frame.h"

#include "bytes/reserve_ahead.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

namespace {

/** \brief Lists the blocks of the last frame that stay, as runs. */
class BlockRuns {
public:
  /** \param[in] is_kept by block: 0 if it is removed */
  BlockRuns(const std::vector<std::uint8_t>& is_kept, std::vector<Run>& runs)
  : is_kept_(is_kept), runs_(runs), removed_(findRemoved(0))
  {
    runs_.clear();
  }

  /** \brief Number of blocks of the next frame before one of the last frame. */
  std::uint32_t
  countBefore(std::uint32_t block)
  {
    for (; removed_ < block; removed_ = findRemoved(begin_)) {
      endRun(removed_);
      ++begin_;
    }
    return next_ + (block - begin_);
  }

  /** \brief Inserts a new block before one of the last frame. */
  void
  insertBefore(std::uint32_t block)
  {
    endRun(block);
    ++next_;
  }

  /** \brief Ends the list. \return number of blocks of the next frame */
  std::size_t
  finish()
  {
    const auto count = static_cast<std::uint32_t>(is_kept_.size());
    countBefore(count);
    endRun(count);
    return next_;
  }

private:
  std::uint32_t
  findRemoved(std::uint32_t from) const
  {
    const std::uint8_t* const first = is_kept_.data();
    const void* const found = from < is_kept_.size()
                                  ? std::memchr(first + from, 0, is_kept_.size() - from)
                                  : nullptr;
    return static_cast<std::uint32_t>(
        found != nullptr
            ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - first)
            : is_kept_.size());
  }

  void
  endRun(std::uint32_t end)
  {
    if (begin_ < end)
      runs_.push_back({begin_, end, next_});
    next_ += end - begin_;
    begin_ = end;
  }

  const std::vector<std::uint8_t>& is_kept_;
  std::vector<Run>& runs_;
  std::uint32_t begin_ = 0; // of the current run
  std::uint32_t next_ = 0;  // its first block in the next frame
  std::uint32_t removed_;   // the next one that is removed
};

/** \brief Moves the elements of runs to where they will be. Those that move down are
 * moved first, from the first one, then the others, from the last one, so that none is
 * overwritten before it was moved.
 * \param[in,out] elements with room for `next_count`
 */
template <class Element>
void
moveRuns(const std::vector<Run>& runs,
         std::vector<Element>& elements,
         std::size_t next_count)
{
  elements.resize(std::max(elements.size(), next_count));
  Element* const first = elements.data();
  for (const Run& run : runs)
    if (run.next_begin < run.begin)
      std::copy(first + run.begin, first + run.end, first + run.next_begin);
  for (auto run = runs.rbegin(); run != runs.rend(); ++run)
    if (run->next_begin > run->begin)
      std::copy_backward(first + run->begin,
                         first + run->end,
                         first + run->next_begin + (run->end - run->begin));
  elements.resize(next_count);
}

} // namespace

void
LastFrame::resizeBlocks(std::size_t count)
{
  reserveAhead(blocks, count);
  reserveAhead(change_histories, count);
  reserveAhead(voxels, count);
  blocks.resize(count);
  change_histories.resize(count);
  voxels.resize(count);
}

void
LastFrame::prepare(FrameChanges& changes)
{
  const std::size_t count = blocks.size();
  std::vector<std::uint8_t>& is_kept = changes.is_kept;
  reserveAhead(is_kept, count);
  is_kept.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    is_kept[i] = static_cast<std::uint8_t>(change_histories[i] << 1 | voxels[i]);
  for (const ChangedBlock& block : changes.blocks)
    if (!block.is_new)
      is_kept[block.index] = 1;
  BlockRuns runs(is_kept, changes.block_runs);
  for (ChangedBlock& block : changes.blocks) {
    block.next_index = runs.countBefore(block.index);
    if (block.is_new)
      runs.insertBefore(block.index);
  }
  changes.block_count = runs.finish();
  reserveAhead(blocks, changes.block_count);
  reserveAhead(change_histories, changes.block_count);
  reserveAhead(voxels, changes.block_count);
  reserveAhead(symbols, changes.symbol_count);
}

void
LastFrame::apply(const FrameChanges& changes) noexcept
{
  for (std::uint8_t& history : change_histories)
    history = static_cast<std::uint8_t>(history << 1);
  moveRuns(changes.block_runs, blocks, changes.block_count);
  moveRuns(changes.block_runs, change_histories, changes.block_count);
  moveRuns(changes.block_runs, voxels, changes.block_count);
  for (const ChangedBlock& block : changes.blocks) {
    const std::uint64_t recently_changed =
        block.recently_changed | (block.cells ^ block.cells_before);
    blocks[block.next_index] = {block.key, block.cells, recently_changed};
    change_histories[block.next_index] = block.change_history;
    voxels[block.next_index] = static_cast<std::uint8_t>(bitCount(block.cells));
  }
  occupied_blocks = changes.occupied_blocks;
  moveRuns(changes.symbol_runs, symbols, changes.symbol_count);
  for (const NewSymbol& symbol : changes.symbols)
    symbols[symbol.voxel] = symbol.symbol;
  voxel_count = changes.voxel_count;
}

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io

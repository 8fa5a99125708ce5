// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/history.h"

#include "bytes/reserve_ahead.h"
#include "codec/fast/frame_blocks.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/voxel_block.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

namespace {

/** \brief Builds the block lists of a frame and of the history after it. */
class BlockLists {
public:
  /** \param[in] max_blocks upper bound of the number of blocks */
  BlockLists(std::size_t max_blocks, History& after, FrameBlocks& frame)
  {
    frame.ensureBlocks(max_blocks);
    reserveAhead(after.keys, max_blocks);
    reserveAhead(after.numbers, max_blocks);
    reserveAhead(after.activity, max_blocks);
    after.keys.resize(max_blocks);
    after.numbers.resize(max_blocks);
    after.activity.resize(max_blocks);
    frame_keys_ = frame.keys.data();
    frame_masks_ = frame.masks.data();
    frame_numbers_ = frame.numbers.data();
    kept_keys_ = after.keys.data();
    kept_numbers_ = after.numbers.data();
    kept_activity_ = after.activity.data();
  }

  /** \brief Appends a block. Without branches: elements that are not counted are
   * overwritten.
   * \param[in] occupied cells of the frame; if 0 the block is not in the frame
   * \param[in] is_kept 1 if the block is in the history after the frame, else 0
   */
  void
  append(std::uint64_t key,
         std::uint32_t number,
         std::uint64_t occupied,
         unsigned int activity,
         std::size_t is_kept)
  {
    frame_keys_[in_frame_] = key;
    frame_masks_[in_frame_] = occupied;
    frame_numbers_[in_frame_] = number;
    in_frame_ += isNotZero(occupied);
    kept_keys_[kept_] = key;
    kept_numbers_[kept_] = number;
    kept_activity_[kept_] = static_cast<std::uint8_t>(activity);
    kept_ += is_kept;
  }

  void
  finish(History& after, FrameBlocks& frame) const
  {
    frame.block_count = in_frame_;
    after.keys.resize(kept_);
    after.numbers.resize(kept_);
    after.activity.resize(kept_);
  }

private:
  std::uint64_t* frame_keys_;
  std::uint64_t* frame_masks_;
  std::uint32_t* frame_numbers_;
  std::uint64_t* kept_keys_;
  std::uint32_t* kept_numbers_;
  std::uint8_t* kept_activity_;
  std::size_t in_frame_ = 0;
  std::size_t kept_ = 0;
};

} // namespace

std::uint32_t
voxel_past::firstProbability(unsigned int past)
{
  const unsigned int frames = highestBit(past);
  std::int32_t probability = 26000;
  for (unsigned int i = 0; i < frames; ++i) {
    const std::int32_t goal = (past >> (frames - 1 - i) & 1) != 0 ? 0xffff : 0;
    const unsigned int shift = i < 2 ? 1 : 2;
    probability += (goal - probability) >> shift;
  }
  return static_cast<std::uint32_t>(probability);
}

void
History::reserveFor(const History& other)
{
  reserveAhead(tracked, other.tracked.size());
  reserveAhead(spare_numbers, other.spare_numbers.size());
  reserveAhead(keys, other.keys.size());
  reserveAhead(numbers, other.numbers.size());
  reserveAhead(activity, other.activity.size());
  ensureSize(cell_indices, other.voxelCount() + spare_indices);
}

void
History::assign(History& other, bool with_statistics) noexcept
{
  tracked = other.tracked;
  spare_numbers = other.spare_numbers;
  keys = other.keys;
  numbers = other.numbers;
  activity = other.activity;
  size = other.size;
  CellIndex* index = cell_indices.data();
  for (std::size_t past = 0; past < voxel_past::count; ++past) {
    first[past] = static_cast<std::uint32_t>(index - cell_indices.data());
    index =
        std::copy_n(other.cell_indices.data() + other.first[past], size[past], index);
  }
  if (with_statistics) {
    statistics.swap(other.statistics);
    point_statistics.swap(other.point_statistics);
  }
}

void
History::clear() noexcept
{
  tracked.clear();
  spare_numbers.clear();
  keys.clear();
  numbers.clear();
  activity.clear();
  first.fill(0);
  size.fill(0);
}

void
History::releaseMemory()
{
  cell_indices.resize(voxelCount() + spare_indices);
  statistics.resize(tracked.size() * block_cells);
  point_statistics.resize(std::min(point_statistics.size(), statistics.size()));
  tracked.shrink_to_fit();
  statistics.shrink_to_fit();
  point_statistics.shrink_to_fit();
  spare_numbers.shrink_to_fit();
  keys.shrink_to_fit();
  numbers.shrink_to_fit();
  activity.shrink_to_fit();
  cell_indices.shrink_to_fit();
}

bool
HistoryUpdate::run(const History& before,
                   History& after,
                   StatisticsTable& statistics,
                   FrameBlocks& frame)
{
  removeForgotten(after);
  numberNewBlocks(before, frame);
  reserveNew(before, after, statistics, frame);
  addNewVoxels(before, after, statistics, frame);
  return mergeBlocks(before, after, frame);
}

void
HistoryUpdate::removeForgotten(History& after)
{
  for (unsigned int past = 1; past < voxel_past::count; ++past) {
    if (!voxel_past::isForgotten(past))
      continue;
    const CellIndex* const cell_indices = after.cell_indices.data() + after.first[past];
    for (std::uint32_t i = 0; i < after.size[past]; ++i)
      after.tracked[cell_indices[i] / block_cells] &=
          ~(std::uint64_t{1} << (cell_indices[i] % block_cells));
    after.size[past] = 0;
  }
}

/** \brief Assigns free numbers to new blocks, the last freed ones first, then further
 * ones. */
void
HistoryUpdate::numberNewBlocks(const History& before, const FrameBlocks& frame)
{
  const std::size_t spare = before.spare_numbers.size();
  auto next = static_cast<std::uint32_t>(before.tracked.size());
  new_numbers_.resize(frame.new_keys.size());
  for (std::size_t i = 0; i < new_numbers_.size(); ++i)
    new_numbers_[i] = i < spare ? before.spare_numbers[spare - 1 - i] : next++;
}

/** \brief Allocates memory for new blocks and new voxels. */
void
HistoryUpdate::reserveNew(const History& before,
                          History& after,
                          StatisticsTable& statistics,
                          const FrameBlocks& frame)
{
  const std::size_t spare =
      std::min(before.spare_numbers.size(), frame.new_keys.size());
  after.spare_numbers.assign(before.spare_numbers.begin(),
                             before.spare_numbers.end() -
                                 static_cast<std::ptrdiff_t>(spare));
  after.tracked.resize(before.tracked.size() + frame.new_keys.size() - spare, 0);
  ensureSize(statistics, after.tracked.size() * block_cells);
  // The bucket of new voxels has no others, and is placed after all buckets.
  std::uint32_t end = 0;
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    end = std::max(end, after.first[past] + after.size[past]);
  ensureSize(after.cell_indices, end + frame.voxel_count + 2);
  after.first[voxel_past::first(frame.is_apart)] = end;
}

void
HistoryUpdate::addNewVoxels(const History& before,
                            History& after,
                            StatisticsTable& statistics,
                            const FrameBlocks& frame)
{
  const unsigned int past = voxel_past::first(frame.is_apart);
  CellIndex* index = after.cell_indices.data() + after.first[past];
  std::uint64_t* const tracked = after.tracked.data();
  std::uint16_t* const all_statistics = statistics.data();
  const auto add = [&](std::uint32_t number, std::uint64_t cells) {
    tracked[number] |= cells;
    const std::uint32_t first = number * block_cells;
    const unsigned int count = bitCount(cells);
    // Two at a time, the highest one twice if the count is odd: such a loop is
    // predicted better (doc/implementation_notes.md, "Branches").
    for (unsigned int done = 0; done < count; done += 2)
      for (unsigned int k = 0; k < 2; ++k) {
        const CellIndex added = first + lowestBit(cells);
        index[done + k] = added;
        all_statistics[added] = History::no_statistics;
        const std::uint64_t others = cells & (cells - 1);
        cells = others != 0 ? others : cells;
      }
    index += count;
  };
  for (std::size_t i = 0; i < frame.renewed_count; ++i) {
    const std::uint32_t number = before.numbers[frame.renewed_blocks[i]];
    add(number, frame.occupied[number] & ~before.tracked[number]);
  }
  for (std::size_t i = 0; i < new_numbers_.size(); ++i)
    add(new_numbers_[i], frame.new_masks[i]);
  after.size[past] =
      static_cast<std::uint32_t>(index - after.cell_indices.data()) - after.first[past];
}

/** \brief Merges tracked and new blocks to the ascending blocks of the frame and of the
 * history after it.
 * \return false if a new block is in the history
 */
bool
HistoryUpdate::mergeBlocks(const History& before, History& after, FrameBlocks& frame)
{
  const std::size_t count = before.keys.size();
  BlockLists lists(count + frame.new_keys.size(), after, frame);
  ensureSize(freed_numbers_, count + 1);
  std::uint32_t* const freed = freed_numbers_.data();
  std::size_t freed_count = 0;
  // Local pointers (doc/implementation_notes.md, "Pointers in local variables").
  const std::uint64_t* const tracked = after.tracked.data();
  const std::uint64_t* const all_occupied = frame.occupied.data();
  const std::uint64_t* const old_keys = before.keys.data();
  const std::uint32_t* const old_numbers = before.numbers.data();
  const std::uint8_t* const old_activity = before.activity.data();
  const std::uint8_t* const symbols = frame.octant_symbols.data();
  const std::uint64_t* const new_keys = frame.new_keys.data();
  const std::uint64_t* const new_masks = frame.new_masks.data();
  const std::uint32_t* const new_numbers = new_numbers_.data();
  const unsigned int new_activity = 1;
  const auto append_old = [&](std::size_t i) {
    const std::uint32_t number = old_numbers[i];
    const unsigned int activity =
        (old_activity[i] * 2u + (symbols[i] != 0 ? 1 : 0)) % 16;
    const std::size_t is_kept = isNotZero(tracked[number]);
    freed[freed_count] = number;
    freed_count += 1 - is_kept;
    lists.append(old_keys[i], number, all_occupied[number], activity, is_kept);
  };
  const auto append_new = [&](std::size_t i, std::size_t old) {
    lists.append(new_keys[i], new_numbers[i], new_masks[i], new_activity, 1);
    return old == not_in_list;
  };
  if (!walkSideBySide(before.keys, frame.new_keys, append_old, append_new))
    return false;
  lists.finish(after, frame);
  reserveAhead(after.spare_numbers, after.spare_numbers.size() + freed_count);
  after.spare_numbers.insert(after.spare_numbers.end(), freed, freed + freed_count);
  return true;
}

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/tracked_voxels.h"

#include "bytes/reserve_ahead.h"
#include "codec/rans/entropy_coder.h"
#include "simd/bit_operations.h"
#include "voxels/block_division.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

namespace {

/** \brief Distance of prefetching, voxels. */
constexpr std::ptrdiff_t prefetched_voxels = 512;

/** \brief End of a bucket, where voxels are appended. */
CellIndex*
endOf(History& history, unsigned int past)
{
  return history.cell_indices.data() + history.first[past] + history.size[past];
}

/** \brief The probability of a past after a frame; the previous one counts as `weight`
 * voxels. */
std::uint16_t
nextProbability(std::uint16_t probability, std::uint32_t occupied, std::uint32_t count)
{
  constexpr std::uint64_t weight = 32;
  return static_cast<std::uint16_t>(
      (weight * probability + std::uint64_t{0xffff} * occupied) / (weight + count));
}

/** \brief How to split eight voxels in empty and occupied ones, as four pairs. */
struct SplitRule {
  static constexpr unsigned int pairs = 4;

  // By pair: index of its first empty voxel among the eight, or of the other voxel if
  // there is none; the same for occupied ones.
  std::array<std::uint8_t, pairs> first_empty{};
  std::array<std::uint8_t, pairs> first_occupied{};
  // By pair: number of voxels up to the end of the pair.
  std::array<std::uint8_t, pairs> empty{};
  std::array<std::uint8_t, pairs> occupied{};
};

/** \brief Rules by occupancy, the first voxel's bit lowest. */
constexpr std::array<SplitRule, 256>
makeSplitRules()
{
  std::array<SplitRule, 256> rules{};
  for (unsigned int byte = 0; byte < rules.size(); ++byte)
    for (unsigned int pair = 0; pair < SplitRule::pairs; ++pair) {
      const unsigned int first = 2 * pair;
      const unsigned int is_occupied = byte >> first & 1;
      const unsigned int occupied = bitCount(byte & ((4u << first) - 1));
      rules[byte].first_empty[pair] = static_cast<std::uint8_t>(first + is_occupied);
      rules[byte].first_occupied[pair] =
          static_cast<std::uint8_t>(first + 1 - is_occupied);
      rules[byte].empty[pair] = static_cast<std::uint8_t>(first + 2 - occupied);
      rules[byte].occupied[pair] = static_cast<std::uint8_t>(occupied);
    }
  return rules;
}

constexpr auto split_rules = makeSplitRules();

/** \brief Splits a bucket in two, eight voxels at a time. */
struct BucketSplit {
  const CellIndex* from;  ///< the next voxels; there is another one after the bucket
  std::ptrdiff_t ahead;   ///< distance of prefetching
  CellIndex* if_empty;    ///< where to store the next empty voxel; two are written
  CellIndex* if_occupied; ///< the same for the next occupied voxel

  /** \param[in] byte occupancy of the eight voxels, the first one lowest */
  void
  operator()(unsigned int byte)
  {
    prefetch(from + ahead);
    const SplitRule& rule = split_rules[byte];
    // Two voxels are copied to both buckets, from the first one that belongs there on;
    // what does not is overwritten later.
    copyTwo(from + rule.first_empty[0], if_empty);
    copyTwo(from + rule.first_occupied[0], if_occupied);
    for (unsigned int pair = 1; pair < SplitRule::pairs; ++pair) {
      copyTwo(from + rule.first_empty[pair], if_empty + rule.empty[pair - 1]);
      copyTwo(from + rule.first_occupied[pair], if_occupied + rule.occupied[pair - 1]);
    }
    from += 8;
    if_empty += rule.empty.back();
    if_occupied += rule.occupied.back();
  }

private:
  static void
  copyTwo(const CellIndex* source, CellIndex* target)
  {
    std::uint64_t both;
    std::memcpy(&both, source, sizeof(both));
    std::memcpy(target, &both, sizeof(both));
  }
};

} // namespace

void
matchHistory(const History& history,
             const std::vector<std::uint64_t>& keys,
             FrameBlocks& frame)
{
  frame.ensureBlocks(keys.size());
  const std::size_t count = collectBlocks(keys, frame.keys.data(), frame.masks.data());
  frame.occupied.resize(history.tracked.size());
  const auto set_cells = [occupied = frame.occupied.data(),
                          numbers = history.numbers.data()](
                             std::size_t i, std::uint64_t cells, std::size_t) {
    occupied[numbers[i]] = cells;
  };
  divideBlocks(history.keys,
               frame.keys.data(),
               frame.masks.data(),
               count,
               set_cells,
               frame.new_keys,
               frame.new_masks);
}

std::size_t
trackedVoxelCount(const History& history, const FrameBlocks& frame)
{
  std::size_t count = 0;
  for (const std::uint32_t number : history.numbers)
    count += bitCount(frame.occupied[number] & history.tracked[number]);
  return count;
}

template <class Coder>
bool
TrackedVoxels::code(Coder& coder,
                    Models& models,
                    const History& before,
                    History& after,
                    FrameBlocks& frame)
{
  // Each bucket is filled from up to two others.
  std::array<std::uint32_t, voxel_past::count> room{};
  std::size_t tracked = 0;
  for (unsigned int past = 1; past < voxel_past::count; ++past) {
    room[voxel_past::next(past, 0)] += before.size[past];
    room[voxel_past::next(past, 1)] += before.size[past];
    tracked += before.size[past];
  }
  std::uint32_t first = 0;
  for (std::size_t past = 0; past < voxel_past::count; ++past) {
    after.first[past] = first;
    first += room[past];
  }
  after.size.fill(0);
  // Two more, as BucketSplit writes two at a time.
  ensureSize(after.cell_indices, first + 2);
  coder.reserve(tracked / 8 + 7 * voxel_past::count);
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    if (before.size[past] != 0 &&
        !splitBucket(coder, models, past, before, after, frame))
      return false;
  return true;
}

template <class Coder>
bool
TrackedVoxels::splitBucket(Coder& coder,
                           Models& models,
                           unsigned int past,
                           const History& before,
                           History& after,
                           FrameBlocks& frame)
{
  std::uint64_t* const occupied = frame.occupied.data();
  const auto isOccupied = [&](CellIndex index) {
    return static_cast<unsigned int>(occupied[index / block_cells] >>
                                     (index % block_cells)) &
           1;
  };
  const CellIndex* from = before.cell_indices.data() + before.first[past];
  const std::size_t count = before.size[past];
  ensureSize(occupancies_, count / 8);
  std::uint8_t* const bytes = occupancies_.data();
  if (!Coder::is_decoder)
    for (std::size_t i = 0; i < count / 8; ++i) {
      unsigned int byte = 0;
      for (unsigned int k = 0; k < 8; ++k)
        byte |= isOccupied(from[8 * i + k]) << k;
      bytes[i] = static_cast<std::uint8_t>(byte);
    }
  const unsigned int past_if_empty = voxel_past::next(past, 0);
  const unsigned int past_if_occupied = voxel_past::next(past, 1);
  CellIndex* const first_occupied = endOf(after, past_if_occupied);
  const CellIndex* const indices_end =
      before.cell_indices.data() + before.cell_indices.size();
  BucketSplit split = {
      from,
      // Buckets are contiguous in memory.
      std::min(prefetched_voxels,
               indices_end - from - static_cast<std::ptrdiff_t>(count)),
      endOf(after, past_if_empty),
      first_occupied};
  if (!coder.codeRow(rans::occupancyTable(models.tracked_probability[past]),
                     bytes,
                     count / 8,
                     split))
    return false;
  from = split.from;
  CellIndex* if_empty = split.if_empty;
  CellIndex* if_occupied = split.if_occupied;
  rans::BitModel last_model(models.tracked_probability[past]);
  for (std::size_t i = 0; i < count % 8; ++i, ++from) {
    const unsigned int bit =
        coder.code(last_model, Coder::is_decoder ? 0 : isOccupied(*from));
    *if_empty = *from;
    *if_occupied = *from;
    if_empty += 1 - bit;
    if_occupied += bit;
  }
  if (Coder::is_decoder)
    for (const CellIndex* index = first_occupied; index != if_occupied; ++index)
      occupied[*index / block_cells] |= std::uint64_t{1} << (*index % block_cells);
  const auto occupied_count = static_cast<std::uint32_t>(if_occupied - first_occupied);
  frame.found_voxels += occupied_count;
  after.size[past_if_empty] += before.size[past] - occupied_count;
  after.size[past_if_occupied] += occupied_count;
  models.tracked_probability[past] = nextProbability(
      models.tracked_probability[past], occupied_count, before.size[past]);
  return !coder.isOverrun();
}

template bool
TrackedVoxels::code(
    rans::NibbleEncoder&, Models&, const History&, History&, FrameBlocks&);
template bool
TrackedVoxels::code(rans::SymbolSink&, Models&, const History&, History&, FrameBlocks&);
template bool
TrackedVoxels::code(
    rans::NibbleDecoder&, Models&, const History&, History&, FrameBlocks&);

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

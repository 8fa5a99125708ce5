// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/new_voxels.h"

#include "codec/fast/child_rank.h"
#include "codec/rans/entropy_coder.h"
#include "simd/bit_operations.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

namespace {

// Symbols for several octants or cells; lower symbols are the rank of a single one.
constexpr unsigned int several_octants = 9;
constexpr unsigned int several_cells = 8;

/** \brief Context of new cells in an octant, by the number of near and of open cells.
 *
 *     near               0  1  2  3 or more
 *     open: all eight    0  3  6  9
 *           5 to 7       1  4  7  10
 *           fewer        2  5  8  11
 */
constexpr std::array<std::array<std::uint8_t, 9>, 9>
makeCellContexts()
{
  std::array<std::array<std::uint8_t, 9>, 9> contexts{};
  for (unsigned int near = 0; near < 9; ++near)
    for (unsigned int open = 0; open < 9; ++open) {
      const unsigned int row = open == 8 ? 0 : open > 4 ? 1 : 2;
      contexts[near][open] = static_cast<std::uint8_t>(std::min(near, 3u) * 3 + row);
    }
  return contexts;
}

constexpr auto cell_contexts = makeCellContexts();

/** \brief The two cache lines with the statistics of a block. A line without occupied
 * cells is replaced by that of the first block, without branches. */
inline std::array<const void*, 2>
statisticsLines(const std::uint16_t* statistics,
                std::uint32_t number,
                std::uint64_t cells)
{
  constexpr std::size_t half = block_cells / 2;
  const std::size_t block = std::size_t{number} * block_cells;
  const std::size_t has_low = static_cast<std::uint32_t>(cells) != 0 ? 1 : 0;
  const std::size_t has_high = cells >> half != 0 ? 1 : 0;
  return {statistics + (block & (0 - has_low)),
          statistics + ((block + half) & (0 - has_high))};
}

} // namespace

template <class Coder>
bool
NewVoxels::code(Coder& coder,
                Models& models,
                const History& before,
                const StatisticsTable& statistics,
                FrameBlocks& frame)
{
  return codeOctants(coder, models, before, statistics, frame) &&
         codeOctantMasks(coder, models, before, frame) &&
         codeCells(coder, models, before, statistics, frame);
}

template <class Coder>
bool
NewVoxels::codeOctants(Coder& coder,
                       Models& models,
                       const History& before,
                       const StatisticsTable& statistics,
                       FrameBlocks& frame)
{
  const std::size_t count = before.keys.size();
  coder.reserve(count);
  ensureSize(contexts_, count);
  if constexpr (Coder::is_decoder) {
    ensureSize(frame.octant_symbols, count);
    ensureSize(frame.renewed_blocks, count + 1);
  }
  else
    findRenewedBlocks(before, frame);
  // Local pointers (doc/implementation_notes.md, "Pointers in local variables").
  const std::uint32_t* const numbers = before.numbers.data();
  const std::uint8_t* const activity = before.activity.data();
  const std::uint64_t* const all_tracked = before.tracked.data();
  const std::uint64_t* const occupied = frame.occupied.data();
  std::uint8_t* const contexts = contexts_.data();
  std::uint8_t* const symbols = frame.octant_symbols.data();
  const std::uint16_t* const all_statistics = statistics.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t number = numbers[i];
    const std::uint64_t tracked_occupied =
        Coder::is_decoder ? occupied[number] : occupied[number] & all_tracked[number];
    contexts[i] =
        static_cast<std::uint8_t>(activity[i] * 2u + 1 - isNotZero(tracked_occupied));
  }
  // Prefetches the statistics that the intensities need (doc/implementation_notes.md,
  // "Prefetching").
  if (!coder.codeRow(
          models.octant.data(), contexts, symbols, count, [=](std::size_t i) {
            return statisticsLines(all_statistics, numbers[i], occupied[numbers[i]]);
          }))
    return false;
  if (Coder::is_decoder)
    collectRenewedBlocks(before, frame);
  return true;
}

void
NewVoxels::findRenewedBlocks(const History& before, FrameBlocks& frame)
{
  const std::size_t count = before.keys.size();
  ensureSize(frame.octant_symbols, count);
  ensureSize(frame.renewed_blocks, count + 1);
  const std::uint32_t* const numbers = before.numbers.data();
  const std::uint64_t* const tracked = before.tracked.data();
  const std::uint64_t* const occupied = frame.occupied.data();
  std::uint8_t* const symbols = frame.octant_symbols.data();
  std::uint32_t* const renewed = frame.renewed_blocks.data();
  std::size_t renewed_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    renewed[renewed_count] = static_cast<std::uint32_t>(i);
    renewed_count += isNotZero(occupied[numbers[i]] & ~tracked[numbers[i]]);
  }
  std::fill_n(symbols, count, std::uint8_t{0});
  for (std::size_t i = 0; i < renewed_count; ++i) {
    const std::uint32_t number = numbers[renewed[i]];
    const unsigned int octants = occupiedOctants(occupied[number] & ~tracked[number]);
    const unsigned int is_single = (octants & (octants - 1)) == 0 ? 1 : 0;
    const unsigned int rank =
        rankOf(occupiedOctants(occupied[number] & tracked[number]), 0xff, octants);
    symbols[renewed[i]] = static_cast<std::uint8_t>(
        ((1 + rank) & (0 - is_single)) | (several_octants & (is_single - 1)));
  }
  frame.renewed_count = renewed_count;
}

/** \brief For a decoder: lists the blocks with new voxels. */
void
NewVoxels::collectRenewedBlocks(const History& before, FrameBlocks& frame)
{
  const std::size_t count = before.keys.size();
  const std::uint8_t* const symbols = frame.octant_symbols.data();
  std::uint32_t* block = frame.renewed_blocks.data();
  for (std::size_t i = 0; i < count; ++i) {
    *block = static_cast<std::uint32_t>(i);
    block += symbols[i] != 0 ? 1 : 0;
  }
  frame.renewed_count = static_cast<std::size_t>(block - frame.renewed_blocks.data());
}

template <class Coder>
bool
NewVoxels::codeOctantMasks(Coder& coder_now,
                           Models& models,
                           const History& before,
                           FrameBlocks& frame)
{
  const std::size_t count = frame.renewed_count;
  coder_now.reserve(2 * count);
  Coder coder = coder_now;
  ensureSize(octants_, 8 * count + 1);
  ensureSize(several_, count + 1);
  CellIndex* octant = octants_.data();
  const std::uint32_t* const blocks = frame.renewed_blocks.data();
  const std::uint8_t* const symbols = frame.octant_symbols.data();
  const std::uint32_t* const numbers = before.numbers.data();
  const std::uint64_t* const occupied = frame.occupied.data();
  const std::uint64_t* const tracked = before.tracked.data();
  std::uint32_t* const several = several_.data();
  std::size_t several_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t number = numbers[blocks[i]];
    const unsigned int symbol = symbols[blocks[i]];
    const unsigned int octants = occupiedOctants(occupied[number] & tracked[number]);
    // Without a branch: written to both lists, and counted in one.
    const unsigned int is_single = (symbol - several_octants) >> 31;
    *octant = number * block_cells + 8 * childOfRank(octants, 0xff, (symbol - 1) % 8);
    octant += is_single;
    several[several_count] = number;
    several_count += 1 - is_single;
    if (Coder::is_decoder && symbol > several_octants)
      return false;
  }
  for (std::size_t i = 0; i < several_count; ++i) {
    const std::uint32_t number = several[i];
    const unsigned int likely = occupiedOctants(occupied[number] & tracked[number]);
    unsigned int mask =
        Coder::is_decoder ? 0 : occupiedOctants(occupied[number] & ~tracked[number]);
    mask = codeMask(coder, models.several, likely, mask);
    if (Coder::is_decoder && (child_masks.count[mask] < 2 || coder.isOverrun()))
      return false;
    for (; mask != 0; mask &= mask - 1)
      *octant++ = number * block_cells + 8 * lowestBit(mask);
  }
  octant_count_ = static_cast<std::size_t>(octant - octants_.data());
  coder_now = coder;
  return true;
}

template <class Coder>
bool
NewVoxels::codeCells(Coder& coder,
                     Models& models,
                     const History& before,
                     const StatisticsTable& statistics,
                     FrameBlocks& frame)
{
  const std::size_t count = octant_count_;
  coder.reserve(3 * count);
  ensureSize(several_, count + 1);
  ensureSize(contexts_, count);
  ensureSize(cell_symbols_, count);
  ensureSize(surroundings_, count);
  const CellIndex* const octants = octants_.data();
  const std::uint64_t* const all_tracked = before.tracked.data();
  // Octants outside of the grid have no open cells, so that all their symbols are
  // invalid.
  const std::uint64_t in_grid = cellsInGrid(frame.depth);
  std::uint64_t* const all_occupied = frame.occupied.data();
  std::uint8_t* const contexts = contexts_.data();
  std::uint8_t* const symbols = cell_symbols_.data();
  Surroundings* const surroundings = surroundings_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t number = octants[i] / block_cells;
    const unsigned int shift = octants[i] % block_cells;
    const std::uint64_t tracked = all_tracked[number];
    const std::uint64_t occupied = all_occupied[number];
    const auto open = static_cast<unsigned int>((in_grid & ~tracked) >> shift & 0xff);
    const unsigned int near =
        static_cast<unsigned int>(cellsBeside(occupied & tracked) >> shift) & open;
    const unsigned int near_count = child_masks.count[near];
    // Without branches, which would be mispredicted.
    if (!Coder::is_decoder) {
      const unsigned int cells = static_cast<unsigned int>(occupied >> shift) & open;
      const unsigned int is_single = all_ones * ((cells & (cells - 1)) == 0 ? 1 : 0);
      const unsigned int rank = rankOf(near, open, cells);
      symbols[i] =
          static_cast<std::uint8_t>((rank & is_single) | (several_cells & ~is_single));
    }
    contexts[i] = cell_contexts[near_count][child_masks.count[open]];
    surroundings[i] = {static_cast<std::uint8_t>(near),
                       static_cast<std::uint8_t>(open)};
  }
  const auto prefetched = [=, all_statistics = statistics.data()](std::size_t i) {
    return std::array<const void*, 1>{all_statistics + octants[i]};
  };
  if (!coder.codeRow(models.cell.data(), contexts, symbols, count, prefetched))
    return false;
  std::size_t several_count = 0;
  if (!setSingleCells<Coder::is_decoder>(frame, several_count))
    return false;
  frame.found_voxels += count - several_count;
  return codeSeveralCells(coder, models, several_count, before, frame);
}

/** \brief Lists the octants with several new voxels and, in a decoder, sets the cells
 * of single new voxels. \return false if a symbol is invalid */
template <bool is_decoder>
bool
NewVoxels::setSingleCells(FrameBlocks& frame, std::size_t& several_count)
{
  const std::size_t count = octant_count_;
  const CellIndex* const octants = octants_.data();
  const std::uint8_t* const symbols = cell_symbols_.data();
  const Surroundings* const surroundings = surroundings_.data();
  std::uint64_t* const all_occupied = frame.occupied.data();
  CellIndex* several = several_.data();
  unsigned int is_wrong = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned int rank = symbols[i];
    const unsigned int is_single = (rank - several_cells) >> 31;
    *several = octants[i];
    several += 1 - is_single;
    if (is_decoder) {
      const unsigned int open = surroundings[i].open;
      const unsigned int end =
          child_masks.count[open] + several_cells * (1 - is_single);
      is_wrong |= (end - 1 - rank) | (several_cells - rank);
      const unsigned int cell = childOfRank(surroundings[i].near, open, rank);
      all_occupied[octants[i] / block_cells] |= std::uint64_t{is_single}
                                                << (octants[i] % block_cells + cell);
    }
  }
  several_count = static_cast<std::size_t>(several - several_.data());
  return is_wrong >> 31 == 0;
}

/** \brief Codes the cells of octants with several new voxels. */
template <class Coder>
bool
NewVoxels::codeSeveralCells(Coder& coder,
                            Models& models,
                            std::size_t count,
                            const History& before,
                            FrameBlocks& frame)
{
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t number = several_[i] / block_cells;
    const unsigned int shift = several_[i] % block_cells;
    const std::uint64_t closed = before.tracked[number];
    const std::uint64_t occupied = frame.occupied[number];
    const auto near = static_cast<unsigned int>(
        (cellsBeside(occupied & closed) & ~closed) >> shift & 0xff);
    unsigned int cells = 0;
    if (!Coder::is_decoder)
      cells = static_cast<unsigned int>((occupied & ~closed) >> shift & 0xff);
    cells = codeMask(coder, models.several, near, cells);
    if (!Coder::is_decoder)
      continue;
    if (child_masks.count[cells] < 2 || (cells & closed >> shift) != 0 ||
        coder.isOverrun())
      return false;
    frame.occupied[number] |= std::uint64_t{cells} << shift;
    frame.found_voxels += child_masks.count[cells];
  }
  return !Coder::is_decoder || frame.found_voxels <= frame.voxel_count;
}

template bool
NewVoxels::code(rans::NibbleEncoder&,
                Models&,
                const History&,
                const StatisticsTable&,
                FrameBlocks&);
template bool
NewVoxels::code(rans::NibbleDecoder&,
                Models&,
                const History&,
                const StatisticsTable&,
                FrameBlocks&);

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

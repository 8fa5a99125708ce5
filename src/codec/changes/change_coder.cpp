// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/changes/change_coder.h"

#include "bytes/reserve_ahead.h"
#include "codec/changes/changed_symbols.h"
#include "codec/fast/child_rank.h"
#include "codec/fast/payload.h"
#include "codec/rans/entropy_coder.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/block_division.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

namespace {

// Symbols for several octants or cells; lower ones are for a single one, by its rank.
constexpr unsigned int several_octants = 9;
constexpr unsigned int several_cells = 8;

/** \brief Context of a block: which of the last two frames changed it, and how many of
 * the six before. */
constexpr std::uint8_t
changeHistoryContext(unsigned int change_history)
{
  const unsigned int before = child_masks.count[change_history >> 2];
  return static_cast<std::uint8_t>(4 * (before < 3 ? before : 3) +
                                   (change_history & 3));
}

constexpr unsigned int
octantOf(std::uint64_t cells, unsigned int octant)
{
  return static_cast<unsigned int>(cells >> (8 * octant)) & 0xff;
}

/** \brief The octants in which a block is likely to change. */
constexpr unsigned int
likelyOctants(const Block& block)
{
  return occupiedOctants(block.cells | block.recently_changed);
}

/** \brief The cells of an octant that are likely to change. */
constexpr unsigned int
likelyCells(const Block& block, unsigned int octant)
{
  const unsigned int recently_changed = octantOf(block.recently_changed, octant);
  return recently_changed != 0 ? recently_changed : octantOf(block.cells, octant);
}

/** \brief The block after a frame that does not change it. */
constexpr Block
sameBlock(const Block& block)
{
  const auto change_history = static_cast<std::uint8_t>(block.change_history << 1);
  return {block.key,
          block.cells,
          change_history == 0 ? 0 : block.recently_changed,
          change_history,
          block.voxels};
}

/** \brief The block after a frame that changes it. */
inline Block
changedBlock(const Block& block, std::uint64_t cells)
{
  return {block.key,
          cells,
          block.recently_changed | (cells ^ block.cells),
          static_cast<std::uint8_t>(block.change_history << 1 | 1),
          static_cast<std::uint8_t>(bitCount(cells))};
}

/** \brief Lists the voxels of a frame that is known by its blocks. */
void
expand(const LastFrame& last, OctantList& octants, VoxelFrame& frame)
{
  const auto cells_of = [blocks = last.blocks.data()](std::size_t i) {
    return blocks[i].cells;
  };
  const auto key_of = [blocks = last.blocks.data()](std::size_t i) {
    return blocks[i].key;
  };
  reserveAhead(frame.intensities, last.symbols.size());
  frame.intensities.assign(last.symbols.begin(), last.symbols.end());
  octants.assign(last.blocks.size(), last.voxel_count, cells_of);
  octants.listKeys(last.voxel_count, cells_of, key_of, frame.keys);
}

/** \brief Appends some voxels of a block to those of a frame.
 * \param[in] some of the block's cells that are occupied
 * \param[in] cells all of them
 * \param[in] symbols of all voxels; empty if the frame has none
 * \param[in] first the block's first voxel
 */
void
appendCells(std::uint64_t key,
            std::uint64_t some,
            std::uint64_t cells,
            const std::vector<std::uint16_t>& symbols,
            std::size_t first,
            VoxelFrame& frame)
{
  for (; some != 0; some &= some - 1) {
    const std::uint64_t cell = some & (~some + 1);
    frame.keys.push_back((key << block_key_bits) + lowestBit(some));
    if (frame.hasIntensities())
      frame.intensities.push_back(symbols[first + bitCount(cells & (cell - 1))]);
  }
}

} // namespace

void
ChangeCoder::prepare(const VoxelFrame& frame)
{
  reserveAhead(next_keys_, frame.size());
  reserveAhead(next_.symbols, frame.intensities.size());
  next_keys_.assign(frame.keys.begin(), frame.keys.end());
  next_.symbols.assign(frame.intensities.begin(), frame.intensities.end());
}

void
ChangeCoder::learnWhole(bool is_i_frame) noexcept
{
  if (is_i_frame)
    *models_ = Models();
  last_keys_.swap(next_keys_);
  last_.symbols.swap(next_.symbols);
  last_.voxel_count = last_keys_.size();
  last_.blocks.clear();
  has_last_frame_ = true;
}

/** \brief Collects the blocks of a last frame that was copied. */
void
ChangeCoder::collectBlocks()
{
  if (last_keys_.empty())
    return;
  now_.assign(last_keys_);
  last_.blocks.clear();
  reserveAhead(last_.blocks, now_.size());
  for (std::size_t i = 0; i < now_.size(); ++i)
    last_.blocks.push_back({now_.keys[i],
                            now_.masks[i],
                            0,
                            0,
                            static_cast<std::uint8_t>(bitCount(now_.masks[i]))});
  last_keys_.clear();
}

std::size_t
ChangeCoder::countChanges(CodingWorkspace& memory, const VoxelFrame& frame)
{
  fast::FrameBlocks& blocks = memory.fast().frame;
  collectBlocks();
  now_.assign(frame.keys);
  const std::size_t count = last_.blocks.size();
  reserveAhead(changed_, count);
  reserveAhead(gone_, count);
  changed_.assign(count, 0);
  gone_.assign(count, 0);
  std::size_t changes = 0;
  std::size_t before = 0; // voxels of the last frame
  const auto compare = [&](std::size_t i, std::uint64_t cells, std::size_t now) {
    const std::uint64_t was = last_.blocks[i].cells;
    changed_[i] = was ^ cells;
    gone_[i] = was & ~cells;
    const std::size_t voxels = last_.blocks[i].voxels;
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
          changed_[i] |= cell;
        symbol += (cells & cell) != 0 ? 1 : 0;
        old_symbol += (was & cell) != 0 ? 1 : 0;
      }
    changes += changed_[i] != 0 ? bitCount(changed_[i]) : 0;
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

void
ChangeCoder::encode(CodingWorkspace& memory,
                    const VoxelFrame& frame,
                    std::vector<std::uint8_t>& payload)
{
  fast::Workspace& work = memory.fast();
  highest_symbol_ = frame.hasIntensities()
                        ? static_cast<std::int32_t>(frame.intensity_scale.maxSymbol())
                        : 0;
  work.frame.depth = frame.grid.depth;
  work.frame.voxel_count = frame.size();
  rans::NibbleEncoder coder(work.ranges);
  code(coder, work, frame.intensities.data());
  coder.finish(rans::Interleaving::One, work.words, payload);
  learn();
}

bool
ChangeCoder::decode(CodingWorkspace& memory,
                    const CodedPayload& payload,
                    const VoxelFrame& frame)
{
  fast::Workspace& work = memory.fast();
  highest_symbol_ = frame.hasIntensities()
                        ? static_cast<std::int32_t>(frame.intensity_scale.maxSymbol())
                        : 0;
  work.frame.depth = frame.grid.depth;
  work.frame.voxel_count = payload.voxel_count;
  work.frame.max_blocks = payload.max_blocks;
  collectBlocks();
  reserveAhead(changed_, last_.blocks.size());
  changed_.assign(last_.blocks.size(), 0);
  rans::NibbleDecoder coder(
      payload.begin, payload.end, rans::Interleaving::One, work.bytes);
  return !coder.isOverrun() && code(coder, work, nullptr) && coder.isAtEnd();
}

void
ChangeCoder::listVoxels(CodingWorkspace& memory, VoxelFrame& frame) const
{
  expand(next_, memory.fast().frame.octants, frame);
}

void
ChangeCoder::listChanges(VoxelFrame& gone, VoxelFrame& came) const
{
  gone.clearVoxels();
  came.clearVoxels();
  for (const ChangedBlock& block : changed_blocks_) {
    appendCells(block.key,
                block.changed & block.cells_before,
                block.cells_before,
                last_.symbols,
                block.first_before,
                gone);
    appendCells(block.key,
                block.changed & block.cells,
                block.cells,
                next_.symbols,
                block.first,
                came);
  }
}

void
ChangeCoder::listLastVoxels(VoxelFrame& frame) const
{
  if (last_.blocks.empty()) {
    frame.keys = last_keys_;
    frame.intensities = last_.symbols;
    return;
  }
  OctantList octants;
  expand(last_, octants, frame);
}

/** \brief Codes a frame: next_ from last_.
 * \param[in] targets symbols of the frame; encoder only
 * \return false if the bytes are invalid
 */
template <class Coder>
bool
ChangeCoder::code(Coder& coder, fast::Workspace& work, const std::uint16_t* targets)
{
  *next_models_ = *models_;
  work.frame.found_voxels = 0;
  return codeOctants(coder) && codeCells(coder, cellsInGrid(work.frame.depth)) &&
         work.new_blocks.code(coder, next_models_->node, work.frame) &&
         codeSymbols(coder, work.frame, targets);
}

/** \brief Codes for each block whether it changes, and if it changes in one octant, in
 * which. */
template <class Coder>
bool
ChangeCoder::codeOctants(Coder& coder)
{
  const std::size_t count = last_.blocks.size();
  reserveAhead(octant_contexts_, count);
  reserveAhead(octant_symbols_, count);
  octant_contexts_.resize(count);
  octant_symbols_.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    octant_contexts_[i] = changeHistoryContext(last_.blocks[i].change_history);
  for (std::size_t i = 0; !Coder::is_decoder && i < count; ++i) {
    const unsigned int octants = occupiedOctants(changed_[i]);
    const unsigned int rank =
        fast::rankOf(likelyOctants(last_.blocks[i]), 0xff, octants);
    octant_symbols_[i] =
        static_cast<std::uint8_t>(octants == 0                     ? 0
                                  : (octants & (octants - 1)) == 0 ? 1 + rank
                                                                   : several_octants);
  }
  coder.reserve(count);
  return coder.codeRow(next_models_->octant.data(),
                       octant_contexts_.data(),
                       octant_symbols_.data(),
                       count);
}

/** \brief Codes which cells of the blocks change: their occupancy, or their symbol. */
template <class Coder>
bool
ChangeCoder::codeCells(Coder& coder_now, std::uint64_t cells_in_grid)
{
  Coder coder = coder_now; // in registers
  Models& models = *next_models_;
  for (std::size_t i = 0; i < last_.blocks.size(); ++i) {
    const unsigned int symbol = octant_symbols_[i];
    if (symbol == 0)
      continue;
    const Block& block = last_.blocks[i];
    const unsigned int likely = likelyOctants(block);
    coder.reserve(26);
    unsigned int octants = occupiedOctants(changed_[i]);
    if (symbol < several_octants)
      octants = 1u << fast::childOfRank(likely, 0xff, symbol - 1);
    else
      octants = fast::codeMask(coder, models.several, likely, octants);
    if (symbol > several_octants ||
        (symbol == several_octants && child_masks.count[octants] < 2))
      return false;
    std::uint64_t changed = 0;
    for (; octants != 0; octants &= octants - 1) {
      const unsigned int octant = lowestBit(octants);
      const unsigned int near = likelyCells(block, octant);
      unsigned int cells = octantOf(changed_[i], octant);
      unsigned int rank = child_masks.count[cells] == 1
                              ? fast::rankOf(near, 0xff, cells)
                              : several_cells;
      rank = coder.code(models.cell[child_masks.count[near]], rank);
      if (rank < several_cells)
        cells = 1u << fast::childOfRank(near, 0xff, rank);
      else
        cells = fast::codeMask(coder, models.several, near, cells);
      if (rank > several_cells ||
          (rank == several_cells && child_masks.count[cells] < 2))
        return false;
      changed |= std::uint64_t{cells} << (8 * octant);
    }
    if ((changed & ~cells_in_grid) != 0 || coder.isOverrun())
      return false;
    changed_[i] = changed;
  }
  coder_now = coder;
  return true;
}

/** \brief Codes what the changed cells become, and those of new blocks. */
template <class Coder>
bool
ChangeCoder::codeSymbols(Coder& coder,
                         const fast::FrameBlocks& blocks,
                         const std::uint16_t* targets)
{
  next_.voxel_count = blocks.voxel_count;
  reserveAhead(next_.symbols, next_.voxel_count);
  reserveAhead(next_.blocks, last_.blocks.size() + blocks.new_keys.size());
  next_.symbols.resize(highest_symbol_ > 0 ? next_.voxel_count : 0);
  next_.blocks.resize(last_.blocks.size() + blocks.new_keys.size());
  ChangedSymbols<Coder> symbols(coder,
                                *next_models_,
                                targets,
                                highest_symbol_,
                                last_.symbols,
                                next_.symbols,
                                next_.voxel_count);
  changed_blocks_.clear();
  bool is_valid = true;
  std::size_t before = 0; // voxels of the last frame
  Block* next = next_.blocks.data();
  const auto code_block = [&](const Block& block,
                              std::uint64_t changed,
                              std::uint64_t gone) {
    std::uint64_t cells = block.cells ^ changed;
    const std::size_t first = symbols.voxelOf(before);
    for (std::uint64_t left = changed; left != 0; left &= left - 1) {
      const std::uint64_t cell = left & (~left + 1);
      is_valid &= symbols.copyUntil(before + bitCount(block.cells & (cell - 1)));
      if (!is_valid)
        return;
      if ((block.cells & cell) == 0)
        is_valid = symbols.codeAppeared();
      else {
        bool is_gone = (gone & cell) != 0;
        is_valid = symbols.codeChanged((block.recently_changed & cell) != 0, is_gone);
        cells |= is_gone ? 0 : cell;
      }
      if (!is_valid)
        return;
    }
    if (Coder::is_decoder)
      changed_blocks_.push_back(
          {block.key, block.cells, cells, changed, before, first});
    before += block.voxels;
    *next++ = changedBlock(block, cells);
  };
  const auto code_old = [&](std::size_t i) {
    const Block& block = last_.blocks[i];
    if (changed_[i] == 0) {
      before += block.voxels;
      *next = sameBlock(block);
      next += isNotZero(next->cells | next->change_history);
    }
    else if (is_valid)
      code_block(block, changed_[i], Coder::is_decoder ? 0 : gone_[i]);
  };
  const auto code_new = [&](std::size_t j, std::size_t i) {
    if (i != not_in_list || !is_valid)
      return false;
    code_block({blocks.new_keys[j], 0, 0, 0, 0}, blocks.new_masks[j], 0);
    return is_valid;
  };
  if (!walkSideBySide(last_.blocks, blocks.new_keys, code_old, code_new) || !is_valid ||
      !symbols.copyUntil(last_.voxel_count) ||
      symbols.voxelCount() != next_.voxel_count)
    return false;
  next_.blocks.resize(static_cast<std::size_t>(next - next_.blocks.data()));
  coder = symbols.coder();
  return true;
}

void
ChangeCoder::learn() noexcept
{
  std::swap(last_, next_);
  models_.swap(next_models_);
}

void
ChangeCoder::releaseMemory()
{
  next_ = LastFrame();
  next_keys_ = std::vector<std::uint64_t>();
  last_keys_.shrink_to_fit();
  now_ = BlockList();
  changed_ = std::vector<std::uint64_t>();
  gone_ = std::vector<std::uint64_t>();
  octant_contexts_ = std::vector<std::uint8_t>();
  octant_symbols_ = std::vector<std::uint8_t>();
  changed_blocks_ = std::vector<ChangedBlock>();
  last_.blocks.shrink_to_fit();
  last_.symbols.shrink_to_fit();
}

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io

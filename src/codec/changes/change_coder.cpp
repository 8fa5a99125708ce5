// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/changes/change_coder.h"

#include "bytes/reserve_ahead.h"
#include "codec/changes/changed_symbols.h"
#include "codec/fast/child_rank.h"
#include "codec/fast/payload.h"
#include "codec/rans/entropy_coder.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace changes {

namespace {

// Symbols for several octants or cells; lower ones are for a single one, by its rank.
constexpr unsigned int several_octants = 9;
constexpr unsigned int several_cells = 8;

/** \brief Contexts of blocks by their change histories: which of the last two frames
 * changed a block, and how many of the six before. */
constexpr std::array<std::uint8_t, 256>
makeChangeHistoryContexts()
{
  std::array<std::uint8_t, 256> contexts{};
  for (unsigned int history = 0; history < 256; ++history) {
    const unsigned int before = child_masks.count[history >> 2];
    contexts[history] =
        static_cast<std::uint8_t>(4 * (before < 3 ? before : 3) + (history & 3));
  }
  return contexts;
}

constexpr std::array<std::uint8_t, 256> change_history_contexts =
    makeChangeHistoryContexts();

constexpr unsigned int
octantOf(std::uint64_t cells, unsigned int octant)
{
  return static_cast<unsigned int>(cells >> (8 * octant)) & 0xff;
}

/** \brief The octants in which a block is likely to change. */
constexpr unsigned int
likelyOctants(std::uint64_t cells, std::uint64_t recently_changed)
{
  return occupiedOctants(cells | recently_changed);
}

/** \brief What is coded of the octants of a block that changes. */
std::uint8_t
octantSymbolOf(const ChangedBlock& block)
{
  const unsigned int octants = occupiedOctants(block.changed);
  const unsigned int likely = likelyOctants(block.cells_before, block.recently_changed);
  return static_cast<std::uint8_t>((octants & (octants - 1)) == 0
                                       ? 1 + fast::rankOf(likely, 0xff, octants)
                                       : several_octants);
}

/** \brief The cells of an octant that are likely to change. */
constexpr unsigned int
likelyCells(std::uint64_t cells, std::uint64_t recently_changed, unsigned int octant)
{
  const unsigned int recent = octantOf(recently_changed, octant);
  return recent != 0 ? recent : octantOf(cells, octant);
}

/** \brief Lists the voxels of a frame that is known by its blocks. */
void
expand(const Block* blocks,
       std::size_t block_count,
       std::size_t voxel_count,
       OctantList& octants,
       VoxelFrame& frame)
{
  const auto cells_of = [blocks](std::size_t i) { return blocks[i].cells; };
  const auto key_of = [blocks](std::size_t i) { return blocks[i].key; };
  octants.assign(block_count, voxel_count, cells_of);
  octants.listKeys(voxel_count, cells_of, key_of, frame.keys);
}

/** \brief Copies the elements of runs to where they are in the frame.
 * \param[out] next elements of the frame
 */
template <class Element>
void
copyRuns(const std::vector<Run>& runs, const std::vector<Element>& last, Element* next)
{
  for (const Run& run : runs)
    std::copy(last.data() + run.begin, last.data() + run.end, next + run.next_begin);
}

} // namespace

void
ChangeCoder::prepare(const VoxelFrame& frame)
{
  reserveAhead(next_keys_, frame.size());
  reserveAhead(next_symbols_, frame.intensities.size());
  next_keys_.assign(frame.keys.begin(), frame.keys.end());
  next_symbols_.assign(frame.intensities.begin(), frame.intensities.end());
}

void
ChangeCoder::learnWhole(bool is_i_frame) noexcept
{
  if (is_i_frame)
    *models_ = Models();
  last_keys_.swap(next_keys_);
  last_.symbols.swap(next_symbols_);
  last_.voxel_count = last_keys_.size();
  last_.blocks.clear();
  last_.change_histories.clear();
  last_.voxels.clear();
  last_.occupied_blocks = 0;
  has_last_frame_ = true;
}

/** \brief Collects the blocks of a last frame that was copied. */
void
ChangeCoder::collectBlocks()
{
  if (last_keys_.empty())
    return;
  now_.assign(last_keys_);
  last_.resizeBlocks(now_.size());
  for (std::size_t i = 0; i < now_.size(); ++i) {
    last_.blocks[i] = {now_.keys[i], now_.masks[i], 0};
    last_.voxels[i] = static_cast<std::uint8_t>(bitCount(now_.masks[i]));
  }
  last_.occupied_blocks = now_.size();
  last_keys_.clear();
}

bool
ChangeCoder::encode(CodingWorkspace& memory,
                    const VoxelFrame& frame,
                    std::vector<std::uint8_t>& payload)
{
  fast::Workspace& work = memory.fast();
  highest_symbol_ = frame.hasIntensities()
                        ? static_cast<std::int32_t>(frame.intensity_scale.maxSymbol())
                        : 0;
  work.frame.depth = frame.grid.depth;
  work.frame.voxel_count = voxel_count_;
  rans::NibbleEncoder coder(work.ranges);
  if (!code(coder, work, frame.intensities.data()))
    return false;
  coder.finish(rans::Interleaving::One, work.words, payload);
  learn();
  return true;
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
  changes_ = &memory.changes();
  changes_->blocks.clear();
  rans::NibbleDecoder coder(
      payload.begin, payload.end, rans::Interleaving::One, work.bytes);
  return !coder.isOverrun() && code(coder, work, nullptr) && coder.isAtEnd();
}

void
ChangeCoder::listVoxels(CodingWorkspace& memory, VoxelFrame& frame) const
{
  FrameChanges& changes = *changes_;
  std::vector<Block>& blocks = changes.all_blocks;
  reserveAhead(blocks, changes.block_count);
  blocks.resize(changes.block_count);
  copyRuns(changes.block_runs, last_.blocks, blocks.data());
  for (const ChangedBlock& block : changes.blocks)
    blocks[block.next_index] = {block.key, block.cells, 0};
  expand(blocks.data(),
         blocks.size(),
         changes.voxel_count,
         memory.fast().frame.octants,
         frame);
  reserveAhead(frame.intensities, changes.symbol_count);
  frame.intensities.resize(changes.symbol_count);
  copyRuns(changes.symbol_runs, last_.symbols, frame.intensities.data());
  for (const NewSymbol& symbol : changes.symbols)
    frame.intensities[symbol.voxel] = symbol.symbol;
}

void
ChangeCoder::listChanges(VoxelFrame& gone, VoxelFrame& came) const
{
  gone.clearVoxels();
  came.clearVoxels();
  std::size_t gone_count = 0;
  std::size_t came_count = 0;
  for (const ChangedBlock& block : changes_->blocks) {
    gone_count += bitCount(block.changed & block.cells_before);
    came_count += bitCount(block.changed & block.cells);
  }
  const bool has_symbols = gone.hasIntensities();
  reserveAhead(gone.keys, gone_count);
  reserveAhead(came.keys, came_count);
  gone.keys.resize(gone_count);
  came.keys.resize(came_count);
  gone.intensities.resize(has_symbols ? gone_count : 0);
  std::uint64_t* gone_key = gone.keys.data();
  std::uint64_t* came_key = came.keys.data();
  std::uint16_t* gone_symbol = gone.intensities.data();
  for (const ChangedBlock& block : changes_->blocks) {
    const std::uint64_t before = block.cells_before;
    const std::uint64_t first_cell = block.key << block_key_bits;
    const std::uint16_t* const symbols =
        has_symbols ? last_.symbols.data() + block.first_before : nullptr;
    for (std::uint64_t left = block.changed & before; left != 0; left &= left - 1) {
      *gone_key++ = first_cell + lowestBit(left);
      if (has_symbols)
        *gone_symbol++ = symbols[bitCount(before & (~left & (left - 1)))];
    }
    for (std::uint64_t left = block.changed & block.cells; left != 0; left &= left - 1)
      *came_key++ = first_cell + lowestBit(left);
  }
  for (const NewSymbol& symbol : changes_->symbols)
    came.intensities.push_back(symbol.symbol);
}

void
ChangeCoder::listLastVoxels(VoxelFrame& frame) const
{
  frame.intensities.assign(last_.symbols.begin(), last_.symbols.end());
  if (last_.blocks.empty()) {
    frame.keys = last_keys_;
    return;
  }
  OctantList octants;
  expand(last_.blocks.data(), last_.blocks.size(), last_.voxel_count, octants, frame);
}

/** \brief Codes a frame, and prepares the last frame for it.
 * \param[in] targets symbols of the frame; encoder only
 * \return false if the bytes, or the changes of an encoder, are invalid
 */
template <class Coder>
bool
ChangeCoder::code(Coder& coder, fast::Workspace& work, const std::uint16_t* targets)
{
  *changes_->models = *models_;
  work.frame.found_voxels = 0;
  if (!codeOctants(coder) || !codeCells(coder, cellsInGrid(work.frame.depth)) ||
      !work.new_blocks.code(coder, changes_->models->node, work.frame) ||
      !insertNewBlocks(work.frame) ||
      !codeSymbols(coder, work.frame.voxel_count, targets))
    return false;
  last_.prepare(*changes_);
  return true;
}

/** \brief Codes for each block whether it changes, and if it changes in one octant, in
 * which. A decoder lists the blocks that change. */
template <class Coder>
bool
ChangeCoder::codeOctants(Coder& coder_now)
{
  const std::size_t count = last_.blocks.size();
  const std::uint8_t* const histories = last_.change_histories.data();
  rans::NibbleModel* const models = changes_->models->octant.data();
  std::vector<ChangedBlock>& blocks = changes_->blocks;
  const auto model_of = [=](std::size_t i) -> rans::NibbleModel& {
    return models[change_history_contexts[histories[i]]];
  };
  coder_now.reserve(count);
  Coder coder = coder_now; // in registers
  if constexpr (Coder::is_decoder) {
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned int symbol = coder.decodeMostlyZero(model_of(i));
      if (coder.isOverrun())
        return false;
      if (symbol == 0)
        continue;
      prefetch(&last_.blocks[i]);
      ChangedBlock& block = blocks.emplace_back();
      block.index = static_cast<std::uint32_t>(i);
      block.octant_symbol = static_cast<std::uint8_t>(symbol);
    }
    for (ChangedBlock& block : blocks)
      last_.beginChange(block.index, block);
  }
  else {
    std::size_t i = 0;
    for (ChangedBlock& block : blocks) {
      block.octant_symbol = octantSymbolOf(block);
      for (; i < block.index; ++i)
        coder.code(model_of(i), 0);
      coder.code(model_of(i++), block.octant_symbol);
    }
    for (; i < count; ++i)
      coder.code(model_of(i), 0);
  }
  coder_now = coder;
  return true;
}

/** \brief Codes which cells of the blocks change: their occupancy, or their symbol. */
template <class Coder>
bool
ChangeCoder::codeCells(Coder& coder_now, std::uint64_t cells_in_grid)
{
  Coder coder = coder_now; // in registers
  Models& models = *changes_->models;
  for (ChangedBlock& block : changes_->blocks) {
    const unsigned int symbol = block.octant_symbol;
    const unsigned int likely =
        likelyOctants(block.cells_before, block.recently_changed);
    coder.reserve(26);
    unsigned int octants = occupiedOctants(block.changed);
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
      const unsigned int near =
          likelyCells(block.cells_before, block.recently_changed, octant);
      unsigned int cells = octantOf(block.changed, octant);
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
    block.changed = changed;
  }
  coder_now = coder;
  return true;
}

/** \brief Inserts the new blocks of a frame among those that it changes.
 * \return false if one of them is not new
 */
bool
ChangeCoder::insertNewBlocks(const fast::FrameBlocks& new_blocks)
{
  std::vector<ChangedBlock>& blocks = changes_->blocks;
  const Block* const last = last_.blocks.data();
  std::size_t old_end = blocks.size();
  std::size_t end = old_end + new_blocks.new_keys.size();
  blocks.resize(end);
  std::size_t above = last_.blocks.size(); // from here on there are larger keys
  for (std::size_t j = new_blocks.new_keys.size(); j-- > 0;) {
    ChangedBlock block{};
    block.key = new_blocks.new_keys[j];
    for (; old_end > 0 && blocks[old_end - 1].key > block.key; --old_end) {
      blocks[--end] = blocks[old_end - 1];
      above = blocks[end].index;
    }
    const std::size_t first = old_end > 0 ? blocks[old_end - 1].index : 0;
    const Block* const behind = std::lower_bound(
        last + first,
        last + above,
        block.key,
        [](const Block& known, std::uint64_t key) { return known.key < key; });
    above = static_cast<std::size_t>(behind - last);
    if (above < last_.blocks.size() && behind->key == block.key)
      return false;
    block.changed = new_blocks.new_masks[j];
    block.cells = block.changed;
    block.index = static_cast<std::uint32_t>(above);
    block.is_new = true;
    block.change_history = 1;
    blocks[--end] = block;
  }
  return true;
}

/** \brief Sets the first voxels of the blocks that change.
 * \return number of their cells that change
 */
std::size_t
ChangeCoder::findFirstVoxels()
{
  std::size_t changed_cells = 0;
  std::uint32_t first = 0;
  std::size_t i = 0;
  for (ChangedBlock& block : changes_->blocks) {
    for (; i < block.index; ++i)
      first += last_.voxels[i];
    block.first_before = first;
    if (highest_symbol_ > 0)
      prefetch(last_.symbols.data() + first);
    changed_cells += bitCount(block.changed);
  }
  return changed_cells;
}

/** \brief Codes what the changed cells become, and those of new blocks. */
template <class Coder>
bool
ChangeCoder::codeSymbols(Coder& coder,
                         std::size_t voxel_count,
                         const std::uint16_t* targets)
{
  const std::size_t changed_cells = findFirstVoxels();
  // Those that are occupied in the one frame and in the other.
  if (changed_cells > last_.voxel_count + voxel_count)
    return false;
  ChangedSymbols<Coder> symbols(coder,
                                *changes_->models,
                                {targets, is_taken_},
                                highest_symbol_,
                                last_.symbols,
                                voxel_count,
                                changed_cells,
                                *changes_);
  std::size_t occupied_blocks = last_.occupied_blocks;
  for (ChangedBlock& block : changes_->blocks) {
    const std::uint64_t before = block.cells_before;
    std::uint64_t cells = before ^ block.changed;
    for (std::uint64_t left = block.changed; left != 0; left &= left - 1) {
      const std::uint64_t cell = left & (~left + 1);
      if (!symbols.keepUntil(block.first_before + bitCount(before & (cell - 1))))
        return false;
      if ((before & cell) == 0) {
        if (!symbols.codeAppeared())
          return false;
        continue;
      }
      bool is_gone = (block.cells & cell) == 0;
      if (!symbols.codeChanged((block.recently_changed & cell) != 0, is_gone))
        return false;
      cells |= is_gone ? 0 : cell;
    }
    block.cells = cells;
    occupied_blocks += isNotZero(cells);
    occupied_blocks -= isNotZero(before);
  }
  changes_->occupied_blocks = occupied_blocks;
  return symbols.finish(last_.voxel_count, coder, *changes_);
}

void
ChangeCoder::learn() noexcept
{
  last_.apply(*changes_);
  models_.swap(changes_->models);
}

void
ChangeCoder::releaseMemory()
{
  next_symbols_ = std::vector<std::uint16_t>();
  next_keys_ = std::vector<std::uint64_t>();
  last_keys_.shrink_to_fit();
  now_ = BlockList();
  last_.blocks.shrink_to_fit();
  last_.change_histories.shrink_to_fit();
  last_.voxels.shrink_to_fit();
  last_.symbols.shrink_to_fit();
}

} // namespace changes
} // namespace pcl_ext::PCL_EXT_ABI::io

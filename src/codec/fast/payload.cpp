// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/payload.h"

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "bytes/reserve_ahead.h"
#include "codec/fast/excess.h"
#include "codec/point_symbols.h"
#include "codec/rans/entropy_coder.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

namespace {

const History no_history;

/** \brief Lists the indices of the voxels of the frame's blocks and, for a decoder,
 * their keys. */
template <bool with_keys>
void
listVoxels(FrameBlocks& frame, std::vector<std::uint64_t>* keys)
{
  const auto cells_of = [masks = frame.masks.data()](std::size_t i) {
    return masks[i];
  };
  frame.octants.assign(frame.block_count, frame.voxel_count, cells_of);
  ensureSize(frame.cell_indices, frame.voxel_count + OctantList::excess);
  CellIndex* index = frame.cell_indices.data();
  std::uint64_t* key = nullptr;
  if constexpr (with_keys) {
    keys->resize(frame.voxel_count + OctantList::excess);
    key = keys->data();
  }
  const auto append =
      [=, block_keys = frame.keys.data(), numbers = frame.numbers.data()](
          std::size_t block, std::uint32_t first_cell, unsigned int cells) mutable {
        index = OctantList::appendCells(
            cells, numbers[block] * block_cells + first_cell, index);
        if constexpr (with_keys)
          key = OctantList::appendCells(
              cells, (block_keys[block] << block_key_bits) + first_cell, key);
      };
  frame.octants.visit(cells_of, append);
  if constexpr (with_keys)
    keys->resize(frame.voxel_count);
}

template <class Coder>
HistoryPart
codePart(Coder& coder, HistoryPart part)
{
  coder.reserve(2);
  return codeHistoryPart([&](bool bit) { return coder.codeBits(1, bit ? 1 : 0) != 0; },
                         part);
}

} // namespace

std::size_t
Payload::match(CodingWorkspace& memory, const VoxelFrame& frame)
{
  if (frame.keys.empty())
    return 0;
  FrameBlocks& matched = memory.fast().frame;
  matchHistory(history_, frame.keys, matched);
  return trackedVoxelCount(history_, matched);
}

PayloadSizes
Payload::encode(CodingWorkspace& memory,
                const VoxelFrame& frame,
                bool is_i_frame,
                std::vector<std::uint8_t>& payload)
{
  has_points_ = hasPointsBesideIntensities(frame);
  if (is_i_frame)
    history_use_.addIFrame();
  if (frame.keys.empty()) {
    if (is_i_frame)
      forget();
    return {};
  }
  const std::size_t begin = payload.size();
  beginFrame(memory, frame, frame.size(), is_i_frame);
  if (frame.has_point_counts)
    pointSymbolsOf(frame.point_counts, work_->point_symbols);
  if (!frame.depth_model) {
    encodeVoxels(frame, is_i_frame, firstSymbols(frame), payload);
    return {payload.size() - begin, 0};
  }
  base_payload_.clear();
  encodeVoxels(frame, is_i_frame, residuals_.baseSymbolsOf(frame), base_payload_);
  ByteWriter writer(payload);
  writer.varint(base_payload_.size());
  writer.raw(base_payload_.data(), base_payload_.size());
  const std::size_t residuals_begin = payload.size();
  residuals_.encode(frame, is_i_frame, payload);
  return {residuals_begin - begin, payload.size() - residuals_begin};
}

/** \brief Appends the voxels of the current frame, with or without the history,
 * whichever is smaller, and learns from them. */
void
Payload::encodeVoxels(const VoxelFrame& frame,
                      bool is_i_frame,
                      const std::vector<std::uint16_t>& symbols,
                      std::vector<std::uint8_t>& payload)
{
  const std::size_t begin = payload.size();
  if (is_i_frame) {
    *models_ = firstModels(has_points_);
    history_use_.measureIFrame(
        frame.size(),
        appendVoxels(*models_, HistoryPart::Replaced, frame, symbols, payload));
    learnHistory(HistoryPart::Replaced);
    return;
  }
  std::size_t bytes = 0; // with the history
  const auto encode = [&](HistoryPart part) {
    if (part == HistoryPart::Used) {
      *work_->models = *models_;
      bytes = appendVoxels(*work_->models, part, frame, symbols, payload);
      learnHistory(part);
      return bytes;
    }
    if (part == HistoryPart::Kept && bytes > 0)
      models_->tracked_probability = work_->models->tracked_probability;
    else if (part == HistoryPart::Kept) {
      followVoxels(frame, *models_, symbols);
      learnHistory(part);
    }
    return appendVoxels(*models_, part, frame, symbols, payload);
  };
  const HistoryPart part = history_use_.choose(frame.size(), encode);
  if (part == HistoryPart::Used) {
    models_.swap(work_->models);
    payload.resize(begin + bytes);
    return;
  }
  if (part == HistoryPart::Replaced)
    learnHistory(part);
  const auto at = payload.begin() + static_cast<std::ptrdiff_t>(begin);
  payload.erase(at, at + static_cast<std::ptrdiff_t>(bytes));
}

/** \brief Appends the voxels of the current frame, and computes models and history after
 * it.
 * \return number of bytes
 */
std::size_t
Payload::appendVoxels(Models& models,
                      HistoryPart part,
                      const VoxelFrame& frame,
                      const std::vector<std::uint16_t>& symbols,
                      std::vector<std::uint8_t>& payload)
{
  Workspace& work = *work_;
  const std::size_t begin = payload.size();
  work.frame.is_apart = part != HistoryPart::Used;
  if (work.frame.is_apart)
    matchHistory(no_history, frame.keys, work.frame);
  rans::NibbleEncoder coder(work.ranges);
  if (!is_i_frame_)
    codePart(coder, part);
  codeOccupancy(coder, models);
  listVoxels<false>(work.frame, nullptr);
  codeSymbols(coder, models, frame, symbols.data());
  coder.finish(rans::interleavingOf(frame.size()), work.words, payload);
  history_.reserveFor(work.next_history);
  return payload.size() - begin;
}

/** \brief Computes the history after a frame that was coded without, but keeps it.
 * \param[in,out] models the probabilities of tracked voxels learn
 */
void
Payload::followVoxels(const VoxelFrame& frame,
                      Models& models,
                      const std::vector<std::uint16_t>& symbols)
{
  Workspace& work = *work_;
  History& after = work.next_history;
  rans::SymbolSink sink;
  work.frame.is_apart = false;
  changed_rows_ = 0;
  matchHistory(history_, frame.keys, work.frame);
  reserveAhead(after.tracked, history_.tracked.size());
  after.tracked.assign(history_.tracked.begin(), history_.tracked.end());
  work.tracked_voxels.code(sink, models, history_, after, work.frame);
  NewVoxels::findRenewedBlocks(history_, work.frame);
  work.history_update.run(history_, after, history_.statistics, work.frame);
  listVoxels<false>(work.frame, nullptr);
  if (const unsigned int bits = firstSymbolBits(frame); bits > 0) {
    ++changed_rows_;
    work.intensities.code(
        sink, models.symbols, work.frame, history_.statistics, bits, symbols.data());
  }
  if (has_points_) {
    ++changed_rows_;
    work.points.code(sink,
                     *models.points,
                     work.frame,
                     beginPointStatistics(),
                     point_symbol_bits,
                     std::as_const(work.point_symbols).data());
  }
  history_.reserveFor(after);
}

bool
Payload::decode(CodingWorkspace& memory,
                const CodedPayload& payload,
                VoxelFrame& frame,
                PayloadSizes& sizes)
{
  const std::uint8_t* begin = payload.begin;
  const std::uint8_t* const end = payload.end;
  const bool is_i_frame = payload.is_i_frame;
  sizes = {static_cast<std::size_t>(end - begin), 0};
  has_points_ = hasPointsBesideIntensities(frame);
  if (payload.voxel_count == 0) {
    frame.keys.clear();
    frame.intensities.clear();
    frame.point_counts.clear();
    change_ = is_i_frame ? Change::Emptied : Change::None;
    return begin == end;
  }
  const std::uint8_t* residuals = end;
  if (frame.depth_model) {
    const auto size = static_cast<std::size_t>(end - begin);
    MemoryBuffer buffer(begin, size);
    ByteSource source(buffer, size);
    const std::uint64_t base_size = source.varint();
    if (source.failure() != ByteSource::Failure::None ||
        base_size > size - source.consumed())
      return false;
    begin += source.consumed();
    residuals = begin + base_size;
  }
  beginFrame(memory, frame, payload.voxel_count, is_i_frame);
  work_->frame.max_blocks = payload.max_blocks;
  work_->frame.has_too_many_blocks = false;
  if (!decodeVoxels(begin, residuals, frame)) {
    sizes.has_too_many_blocks = work_->frame.has_too_many_blocks;
    return false;
  }
  if (frame.depth_model && !residuals_.decode(residuals, end, is_i_frame, frame)) {
    restoreStatistics();
    return false;
  }
  change_ = frame.depth_model ? Change::Everything : Change::VoxelsOnly;
  sizes.intensity = static_cast<std::size_t>(end - residuals);
  sizes.occupancy -= sizes.intensity;
  return true;
}

bool
Payload::decodeVoxels(const std::uint8_t* begin,
                      const std::uint8_t* end,
                      VoxelFrame& frame)
{
  Workspace& work = *work_;
  *work.models = is_i_frame_ ? firstModels(has_points_) : *models_;
  rans::NibbleDecoder coder(
      begin, end, rans::interleavingOf(work.frame.voxel_count), work.bytes);
  if (coder.isOverrun())
    return false;
  part_ = is_i_frame_ ? HistoryPart::Replaced : codePart(coder, HistoryPart::Used);
  work.frame.is_apart = part_ != HistoryPart::Used;
  if (!codeOccupancy(coder, *work.models))
    return false;
  listVoxels<true>(work.frame, &frame.keys);
  if (frame.hasIntensities())
    frame.intensities.resize(work.frame.voxel_count);
  if (frame.has_point_counts)
    work.point_symbols.resize(work.frame.voxel_count);
  std::uint16_t* const symbols =
      (frame.hasIntensities() ? frame.intensities : work.point_symbols).data();
  if (codeSymbols(coder, *work.models, frame, symbols) && coder.isAtEnd()) {
    history_.reserveFor(work.next_history);
    if (part_ == HistoryPart::Kept)
      followVoxels(frame, *work.models, firstSymbols(frame));
    return true;
  }
  restoreStatistics();
  return false;
}

/** \brief Codes which voxels are occupied, stage by stage, and computes the next
 * history. */
template <class Coder>
bool
Payload::codeOccupancy(Coder& coder, Models& models)
{
  FrameBlocks& frame = work_->frame;
  History& after = work_->next_history;
  frame.found_voxels = 0;
  if (Coder::is_decoder) {
    reserveAhead(frame.occupied, before().tracked.size());
    frame.occupied.assign(before().tracked.size(), 0);
  }
  // Copied here, sequentially, long before single elements change.
  reserveAhead(after.tracked, before().tracked.size());
  after.tracked.assign(before().tracked.begin(), before().tracked.end());
  return work_->tracked_voxels.code(coder, models, before(), after, frame) &&
         work_->new_voxels.code(coder, models, before(), statistics(), frame) &&
         work_->new_blocks.code(coder, models.node, frame) &&
         (!Coder::is_decoder || frame.found_voxels == frame.voxel_count) &&
         work_->history_update.run(before(), after, statistics(), frame);
}

/** \brief Codes the symbols of intensities and of numbers of points.
 * \param[in,out] symbols the first ones, see firstSymbolBits()
 * \return false if the bytes are invalid
 */
template <class Coder, class FrameT, class Symbol>
bool
Payload::codeSymbols(Coder& coder, Models& models, FrameT& frame, Symbol* symbols)
{
  const unsigned int bits = firstSymbolBits(frame);
  Workspace& work = *work_;
  if (bits > 0) {
    ++changed_rows_;
    if (!work.intensities.code(
            coder, models.symbols, work.frame, statistics(), bits, symbols))
      return false;
  }
  if (!frame.has_point_counts)
    return true;
  if (has_points_) {
    StatisticsTable& point_statistics = beginPointStatistics();
    ++changed_rows_;
    Symbol* const point_symbols = work.point_symbols.data();
    if (!work.points.code(coder,
                          *models.points,
                          work.frame,
                          point_statistics,
                          point_symbol_bits,
                          point_symbols))
      return false;
  }
  if constexpr (Coder::is_decoder)
    frame.point_counts.assign(work.point_symbols.begin(), work.point_symbols.end());
  return codeExcess(coder, frame.point_counts);
}

void
Payload::learn() noexcept
{
  if (change_ == Change::Emptied)
    forget();
  if (change_ == Change::VoxelsOnly || change_ == Change::Everything) {
    models_.swap(work_->models);
    learnHistory(part_);
  }
  if (change_ == Change::Everything)
    residuals_.learn();
}

void
Payload::discard() noexcept
{
  if (change_ == Change::VoxelsOnly || change_ == Change::Everything)
    restoreStatistics();
}

void
Payload::releaseMemory()
{
  history_.releaseMemory();
  if (!models_->points)
    history_.point_statistics = StatisticsTable();
  residuals_.releaseMemory();
  base_payload_ = std::vector<std::uint8_t>();
}

void
Payload::beginFrame(CodingWorkspace& memory,
                    const VoxelFrame& frame,
                    std::size_t voxel_count,
                    bool is_i_frame)
{
  work_ = &memory.fast();
  is_i_frame_ = is_i_frame;
  work_->frame.depth = frame.grid.depth;
  work_->frame.voxel_count = voxel_count;
  changed_rows_ = 0;
}

/** \brief The symbols that are coded first, see firstSymbolBits(). */
const std::vector<std::uint16_t>&
Payload::firstSymbols(const VoxelFrame& frame) const
{
  return frame.hasIntensities() ? frame.intensities : work_->point_symbols;
}

const History&
Payload::before() const
{
  return work_->frame.is_apart ? no_history : history_;
}

StatisticsTable&
Payload::statistics() noexcept
{
  return work_->frame.is_apart ? work_->next_history.statistics : history_.statistics;
}

StatisticsTable&
Payload::pointStatistics() noexcept
{
  return work_->frame.is_apart ? work_->next_history.point_statistics
                               : history_.point_statistics;
}

/** \brief The statistics of numbers of points, with none for new voxels. */
StatisticsTable&
Payload::beginPointStatistics()
{
  const History& after = work_->next_history;
  StatisticsTable& table = pointStatistics();
  ensureSize(table, after.tracked.size() * block_cells);
  if (work_->frame.is_apart) // they are not read
    return table;
  const unsigned int past = voxel_past::first(false);
  const CellIndex* const cell_indices = after.cell_indices.data() + after.first[past];
  for (std::uint32_t i = 0; i < after.size[past]; ++i)
    table[cell_indices[i]] = History::no_statistics;
  return table;
}

/** \brief Undoes what decoding the symbols changed. */
void
Payload::restoreStatistics() noexcept
{
  if (changed_rows_ > 0)
    work_->intensities.restore(work_->frame, statistics());
  if (changed_rows_ > 1)
    work_->points.restore(work_->frame, pointStatistics());
}

void
Payload::learnHistory(HistoryPart part) noexcept
{
  // Those of a history that is not replaced were updated in place.
  const bool with_statistics = part == HistoryPart::Replaced;
  history_.assign(work_->next_history, with_statistics);
}

void
Payload::forget() noexcept
{
  *models_ = firstModels(has_points_);
  history_.clear();
  residuals_.reset();
}

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/history.h"

#include "bytes/reserve_ahead.h"
#include "codec/point_symbols.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

namespace {

// Most voxels of an I-frame are occupied again; most new voxels of P-frames are noise.
constexpr std::uint16_t first_probability_i_frame = 52000;
constexpr std::uint16_t first_probability_p_frame = 26000;
// Records below it save too few bytes for their time.
constexpr std::uint16_t least_probability = 1000;
constexpr std::uint8_t most_active = 7;
constexpr std::uint8_t first_activity_p_frame = 2;

/** \brief Ages are counted up to this. */
constexpr std::uint8_t oldest = 31;

/** \brief Adaptation rate of a probability by age, as a shift: 1/2 for two frames, 1/4
 * up to the fifth, 1/8 up to the tenth, then 1/16. */
constexpr std::array<std::uint8_t, oldest + 1>
makeRateShifts()
{
  std::array<std::uint8_t, oldest + 1> shifts{};
  for (unsigned int age = 0; age <= oldest; ++age)
    shifts[age] = age < 2 ? 1 : age < 5 ? 2 : age < 10 ? 3 : 4;
  return shifts;
}

constexpr std::array<std::uint8_t, oldest + 1> rate_shifts = makeRateShifts();

} // namespace

void
History::clear(unsigned int symbol_bits)
{
  blocks_.clear();
  record_count_ = 0;
  has_depths_ = false;
  has_points_ = false;
  fraction_bits_ = fractionBitsOf(symbol_bits);
}

void
History::predictDepths(const BlockList& frame,
                       std::vector<DepthPrediction>& predictions) const
{
  predictions.clear();
  AscendingLookup<HistoryBlock> lookup(blocks_);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const std::size_t old = lookup.find(frame.keys[i]);
    const std::uint64_t tracked = old != not_in_list ? blocks_[old].tracked : 0;
    for (std::uint64_t cells = frame.masks[i]; cells != 0; cells &= cells - 1) {
      const std::uint64_t cell = cells & (~cells + 1);
      DepthPrediction& prediction = predictions.emplace_back();
      if ((tracked & cell) == 0)
        continue;
      const DepthRecord record =
          depthRecord(blocks_[old].first_record + bitCount(tracked & (cell - 1)));
      prediction = {true, record.roughness, record.offset};
    }
  }
}

/** \brief Updates the records with one frame. Without branches on whether a voxel is
 * occupied, which would be mispredicted. */
struct History::Learning {
  const std::uint16_t* base_symbols;
  const DepthObservations* depths;
  const std::uint16_t* points;
  unsigned int fraction_bits;
  std::uint16_t first_probability;

  /** \brief Writes the next records of a block.
   * \param[in] record the first one
   * \param[in] tracked the block's cells that have a record
   * \param[in] occupied the block's cells in the frame
   * \param[in] voxel index of the first of these
   * \param[in,out] next where to write; then after the last one
   * \return the cells that have a record now
   */
  std::uint64_t
  learn(const VoxelRecord* record,
        std::uint64_t tracked,
        std::uint64_t occupied,
        std::size_t voxel,
        VoxelRecord*& next) const
  {
    struct Seen {
      VoxelRecord* record;
      std::size_t voxel;
    };
    std::array<Seen, block_cells> seen; // tracked voxels of the frame
    std::size_t seen_count = 0;
    std::uint64_t kept = 0;
    VoxelRecord* now = next;
    for (std::uint64_t cells = tracked | occupied; cells != 0; cells &= cells - 1) {
      const unsigned int cell = lowestBit(cells);
      const auto is_occupied = static_cast<std::uint32_t>(occupied >> cell & 1);
      std::uint32_t is_kept = 1;
      if ((tracked >> cell & 1) != 0) {
        *now = *record++;
        learnOccupancy(*now, is_occupied);
        is_kept = now->probability >= least_probability ? 1 : 0;
        seen[seen_count] = {now, voxel};
        seen_count += is_occupied;
      }
      else
        *now = begin(voxel);
      kept |= std::uint64_t{is_kept} << cell;
      now += is_kept;
      voxel += is_occupied;
    }
    for (std::size_t i = 0; i < seen_count; ++i)
      learnSymbol(*seen[i].record, base_symbols[seen[i].voxel], fraction_bits);
    next = now;
    return kept;
  }

  /** \brief Writes what is remembered beside the records of a block, after learn().
   * \param[in] record of the first record of the block
   * \param[in] kept the cells that have a record now
   * \param[out] next where to write
   * \param[in] learn_voxel adapts that of a voxel of the frame
   */
  template <class RecordT, class LearnT>
  static void
  learnBeside(const RecordT* record,
              std::uint64_t tracked,
              std::uint64_t occupied,
              std::uint64_t kept,
              std::size_t voxel,
              RecordT* next,
              const LearnT& learn_voxel)
  {
    for (std::uint64_t cells = tracked | occupied; cells != 0; cells &= cells - 1) {
      const unsigned int cell = lowestBit(cells);
      const bool is_occupied = (occupied >> cell & 1) != 0;
      const bool is_tracked = (tracked >> cell & 1) != 0;
      RecordT now{};
      if (is_tracked)
        now = *record++;
      if (is_occupied)
        learn_voxel(now, is_tracked, voxel);
      if ((kept >> cell & 1) != 0)
        *next++ = now;
      voxel += is_occupied ? 1 : 0;
    }
  }

  VoxelRecord
  begin(std::size_t voxel) const
  {
    VoxelRecord record{};
    record.probability = first_probability;
    beginSymbol(record, base_symbols[voxel], fraction_bits);
    record.recent = 1;
    return record;
  }

  /** \brief Begins with a symbol that has fraction bits, 16 bits in all. */
  static void
  beginSymbol(SymbolRecord& record, std::uint16_t symbol, unsigned int fraction_bits)
  {
    const int value = static_cast<int>(symbol) << fraction_bits;
    record.mean = static_cast<std::uint16_t>(value);
    record.deviation =
        static_cast<std::uint16_t>(std::max(1 << fraction_bits, value >> 2));
  }

  /** \brief Adapts the probability and the pattern of recent frames.
   * \param[in] is_occupied 1 or 0
   */
  static void
  learnOccupancy(VoxelRecord& record, std::uint32_t is_occupied)
  {
    // Towards 0xffff or 0, rounded towards the old value.
    const std::uint32_t flip = (0 - is_occupied) & 0xffff;
    const std::uint32_t distance = record.probability ^ flip;
    record.probability = static_cast<std::uint16_t>(
        (distance - (distance >> rate_shifts[record.age])) ^ flip);
    record.recent = static_cast<std::uint8_t>(record.recent * 2u | is_occupied);
    record.age = static_cast<std::uint8_t>(record.age + (record.age < oldest ? 1 : 0));
  }

  static void
  learnSymbol(SymbolRecord& record, std::uint16_t symbol, unsigned int fraction_bits)
  {
    // Right shifts of negative numbers round towards minus infinity, in all compilers
    // and by the standard since C++20.
    const int value = static_cast<int>(symbol) << fraction_bits;
    const int difference = value - static_cast<int>(record.mean);
    const int spread = std::abs(difference) - static_cast<int>(record.deviation);
    record.mean = static_cast<std::uint16_t>(record.mean + (difference >> 2));
    record.deviation = static_cast<std::uint16_t>(record.deviation + (spread >> 2));
  }

  void
  learnPoints(SymbolRecord& record, bool is_tracked, std::size_t voxel) const
  {
    constexpr unsigned int fraction = fractionBitsOf(point_symbol_bits);
    if (!is_tracked)
      beginSymbol(record, points[voxel], fraction);
    else
      learnSymbol(record, points[voxel], fraction);
  }

  void
  learnDepth(DepthRecord& record, bool is_tracked, std::size_t voxel) const
  {
    if (depths == nullptr)
      return;
    const std::int16_t offset = depths->offsets[voxel];
    const int residual = depths->residuals[voxel] << 4;
    if (!is_tracked) {
      record = {offset, static_cast<std::uint8_t>(residual)};
      return;
    }
    record.offset =
        static_cast<std::int16_t>(record.offset + ((offset - record.offset) >> 2));
    record.roughness = static_cast<std::uint8_t>(record.roughness +
                                                 ((residual - record.roughness) >> 2));
  }
};

void
History::makeRoom(const BlockList& frame,
                  bool has_depths,
                  bool is_i_frame,
                  bool has_points)
{
  // Upper bound: all records are kept and all voxels are new.
  const std::size_t records = (is_i_frame ? 0 : record_count_) + frame.voxelCount();
  if (next_records_.size() < records)
    next_records_.resize(records);
  if (has_depths || has_depths_) {
    if (next_depth_records_.size() < records)
      next_depth_records_.resize(records);
    if (!has_depths_)
      depth_records_.assign(record_count_, DepthRecord());
  }
  if (has_points && next_point_records_.size() < records)
    next_point_records_.resize(records);
  const std::size_t blocks = (is_i_frame ? 0 : blocks_.size()) + frame.size();
  next_blocks_.clear();
  reserveAhead(next_blocks_, blocks);
}

void
History::update(const BlockList& frame,
                const std::vector<std::uint16_t>& base_symbols,
                const DepthObservations* depths,
                bool is_i_frame,
                const std::vector<std::uint16_t>* points)
{
  makeRoom(frame, depths != nullptr, is_i_frame, points != nullptr);
  has_depths_ = has_depths_ || depths != nullptr;
  has_points_ = points != nullptr;
  const Learning learning{base_symbols.data(),
                          depths,
                          has_points_ ? points->data() : nullptr,
                          fraction_bits_,
                          is_i_frame ? first_probability_i_frame
                                     : first_probability_p_frame};
  const std::uint8_t first_activity = is_i_frame ? 0 : first_activity_p_frame;
  const VoxelRecord* record = records_.data();
  VoxelRecord* next = next_records_.data();
  const auto learn = [&](std::size_t old, std::size_t now) {
    HistoryBlock block{0, 0, 0, 0, first_activity};
    block.first_record = static_cast<std::uint32_t>(next - next_records_.data());
    std::uint64_t tracked = 0;
    if (old != not_in_list) {
      block.key = blocks_[old].key;
      tracked = blocks_[old].tracked;
      block.activity = blocks_[old].activity;
    }
    std::size_t voxel = 0;
    if (now != not_in_list) {
      block.key = frame.keys[now];
      block.last = frame.masks[now];
      voxel = frame.first_voxels[now];
    }
    block.tracked = learning.learn(record, tracked, block.last, voxel, next);
    const auto learn_beside =
        [&](const auto& old_records, auto& next_records, const auto& learn_voxel) {
          learning.learnBeside(old_records.data() + (record - records_.data()),
                               tracked,
                               block.last,
                               block.tracked,
                               voxel,
                               next_records.data() + block.first_record,
                               learn_voxel);
        };
    if (has_depths_)
      learn_beside(depth_records_, next_depth_records_, [&](auto&&... arguments) {
        learning.learnDepth(arguments...);
      });
    if (has_points_)
      learn_beside(point_records_, next_point_records_, [&](auto&&... arguments) {
        learning.learnPoints(arguments...);
      });
    record += bitCount(tracked);
    const unsigned int new_voxels =
        is_i_frame ? 0 : std::min(bitCount(block.last & ~tracked), 7u);
    block.activity = static_cast<std::uint8_t>(std::min<unsigned int>(
        (block.activity * 3u + new_voxels * 2u + 2u) / 4u, most_active));
    if (block.tracked != 0)
      next_blocks_.push_back(block);
  };
  walkSideBySide(
      blocks_,
      frame.keys,
      [&](std::size_t old) { learn(old, not_in_list); },
      [&](std::size_t now, std::size_t old) {
        learn(old, now);
        return true;
      });
  record_count_ = static_cast<std::size_t>(next - next_records_.data());
  blocks_.swap(next_blocks_);
  records_.swap(next_records_);
  if (has_depths_)
    depth_records_.swap(next_depth_records_);
  if (has_points_)
    point_records_.swap(next_point_records_);
}

void
History::releaseMemory()
{
  next_blocks_ = std::vector<HistoryBlock>();
  next_records_ = std::vector<VoxelRecord>();
  next_depth_records_ = std::vector<DepthRecord>();
  next_point_records_ = std::vector<SymbolRecord>();
  depth_records_.resize(has_depths_ ? record_count_ : 0);
  depth_records_.shrink_to_fit();
  point_records_.resize(has_points_ ? record_count_ : 0);
  point_records_.shrink_to_fit();
  records_.resize(record_count_);
  records_.shrink_to_fit();
  blocks_.shrink_to_fit();
}

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

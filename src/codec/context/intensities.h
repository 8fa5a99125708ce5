// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/context/frame_blocks.h"
#include "codec/context/history.h"
#include "codec/context/intensity_contexts.h"
#include "codec/context/intensity_neighbours.h"
#include "codec/context/local_expectation.h"
#include "codec/depth_split.h"
#include "codec/point_symbols.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Codes the intensity symbols of a frame's voxels, for either direction.
 * \tparam CodingT DecisionCoding
 */
template <typename CodingT>
class IntensityPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] directory scratch memory
   * \param[in] parameters of the frame
   */
  IntensityPass(CodingT& coding,
                IntensityContexts& models,
                FrameDirectory& directory,
                const FrameParameters& parameters)
  : coding_(coding)
  , models_(models)
  , directory_(directory)
  , history_(parameters.history)
  , levels_(levelsAboveBlocks(parameters.grid_depth))
  , symbol_bits_(parameters.symbol_bits)
  {}

  /** \brief Codes the symbols.
   * \param[in] frame the frame's blocks
   * \param[in,out] symbols one for each voxel; the decoder fills them
   * \param[in] remembered what is remembered of these, in the order of the history's
   * records; null: the records themselves
   */
  void
  run(const BlockList& frame,
      std::vector<std::uint16_t>& symbols,
      const SymbolRecord* remembered = nullptr)
  {
    // Point symbols are never 0: lengths then start at 1.
    const bool has_zero = coding_.codeBypass(
        std::find(symbols.begin(), symbols.end(), 0) != symbols.end());
    shortest_ = has_zero ? 0 : 1;
    // Where records expect the symbols well, the neighbours are not worth their time.
    std::uint32_t& frames_without = models_.local.frames_without;
    const bool uses_neighbours =
        CodingT::is_small || coding_.codeBypass(frames_without == 0);
    IntensityNeighbours neighbours(frame, levels_, directory_);
    LocalExpectation local(
        models_.local, directory_.smoothed, uses_neighbours ? symbols.size() : 0);
    if (uses_neighbours)
      neighbours.begin();
    std::size_t local_voxels = 0;
    AscendingLookup<HistoryBlock> lookup(history_.blocks());
    std::size_t voxel = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const std::size_t old = lookup.find(frame.keys[i]);
      const std::uint64_t tracked =
          old != not_in_list ? history_.blocks()[old].tracked : 0;
      if (uses_neighbours)
        neighbours.moveTo(i);
      for (std::uint64_t cells = frame.masks[i]; cells != 0; cells &= cells - 1) {
        const std::uint64_t lowest = cells & (~cells + 1); // of the mask
        const VoxelRecord* const record =
            (tracked & lowest) != 0
                ? history_.records() + history_.blocks()[old].first_record +
                      bitCount(tracked & (lowest - 1))
                : nullptr;
        const SymbolRecord* const of_symbols =
            remembered == nullptr || record == nullptr
                ? record
                : remembered + (record - history_.records());
        const unsigned int cell = lowestBit(cells);
        std::uint32_t average = running_;
        if (uses_neighbours)
          local.expect(neighbours, cell);
        if constexpr (CodingT::is_small)
          average = neighbours.averageOf(cell, symbols, running_);
        expect(record, of_symbols, uses_neighbours ? &local : nullptr, average);
        symbols[voxel] = static_cast<std::uint16_t>(codeSymbol(symbols[voxel]));
        if (uses_neighbours)
          local.learn(voxel, symbols[voxel], otherwise_, of_symbols != nullptr);
        learn(symbols[voxel]);
        local_voxels += is_local_ ? 1 : 0;
        ++voxel;
      }
    }
    if constexpr (!CodingT::is_decoder) {
      if (!uses_neighbours)
        --frames_without;
      else if (2 * local_voxels < voxel)
        frames_without = Models::frames_without;
    }
  }

  /** \brief Codes the residuals of a depth model.
   * \param[in] split after predict()
   * \param[in,out] symbols one for each voxel; a decoder replaces the numbers of points
   * by the symbols
   * \return false if the decoded numbers are not symbols
   */
  bool
  codeResiduals(const DepthSplit& split, std::vector<std::uint16_t>& symbols)
  {
    std::uint32_t running_residual = 16; // mean so far, in sixteenths
    for (std::size_t i = 0; i < symbols.size(); ++i) {
      const std::uint8_t residual_class = split.classes()[i];
      if (residual_class == DepthSplit::no_residual)
        continue;
      const std::uint32_t target =
          CodingT::is_decoder ? 0 : split.residual(i, symbols[i]);
      typename decltype(models_.residual)::Contexts contexts;
      contexts.ways[0] = residual_class * IntensityContexts::longest_residual;
      if constexpr (CodingT::is_small) {
        const std::uint32_t prediction = split.predictionContext(i);
        contexts.ways[1] =
            (prediction * 6 + residual_class % 6) * IntensityContexts::longest_residual;
        contexts.ways[2] =
            (((prediction >> 2) * 4 + std::min(running_residual / 8, 3u)) * 4 +
             split.pointClass(i)) *
            IntensityContexts::longest_residual;
      }
      std::uint32_t residual = 0;
      for (; residual < IntensityContexts::longest_residual; ++residual) {
        contexts.weight_set = std::min(residual, 7u);
        if (!coding_.code(models_.residual, contexts, target > residual))
          break;
        for (std::uint32_t& context : contexts.ways)
          ++context;
      }
      if (residual == IntensityContexts::longest_residual) {
        const std::uint32_t beyond =
            codeEscape(target - residual, Models::longest_escape);
        if (beyond == invalid)
          return false;
        residual += beyond;
      }
      if (!split.symbol(i, residual, symbols[i]))
        return false;
      running_residual += (16 * std::min(residual, 64u) >> 3) - (running_residual >> 3);
    }
    return true;
  }

  /** \brief Codes what numbers of points have beyond the highest symbol.
   * \param[in,out] counts one for each voxel; a decoder adds to their symbols
   * \return false if a decoded number is too large
   */
  template <class CountsT>
  bool
  codeExcess(CountsT& counts)
  {
    for (auto& count : counts) {
      if (count < highest_point_symbol)
        continue;
      const std::uint32_t excess =
          codeEscape(count - highest_point_symbol, Models::longest_excess);
      if (excess > most_points - highest_point_symbol)
        return false;
      if constexpr (CodingT::is_decoder)
        count += excess;
    }
    return true;
  }

private:
  using Models = IntensityContexts;
  static constexpr std::uint32_t invalid = 0xffffffff;

  /** \brief A decision of a symbol: does it reach the middle of an interval? */
  struct Decision {
    std::uint32_t node;   ///< which of the decisions it is
    bool is_length;       ///< of the unary code; else of a bit
    std::uint32_t middle; ///< of the interval
    unsigned int width;   ///< of the interval, a power of two
  };

  /** \brief Prepares the contexts of a symbol.
   * \param[in] record of the voxel; null if it is not tracked
   * \param[in] tracked what is remembered of its symbols; null likewise
   * \param[in] local what its neighbours let expect; null if that is not used
   * \param[in] average symbol before it, in sixteenths
   */
  void
  expect([[maybe_unused]] const VoxelRecord* record,
         const SymbolRecord* tracked,
         const LocalExpectation* local,
         std::uint32_t average)
  {
    const unsigned int shift = 4 - History::fractionBitsOf(symbol_bits_);
    const bool has_record = tracked != nullptr;
    otherwise_ =
        has_record ? static_cast<std::uint32_t>(tracked->mean) << shift : average;
    is_local_ = local != nullptr && local->isCloser(has_record);
    is_tracked_ = has_record && !is_local_;
    std::uint32_t deviation = static_cast<std::uint32_t>(error_);
    if (is_local_) {
      const std::uint64_t expected = local->sixteenths();
      expected_ = static_cast<std::int32_t>(expected);
      deviation = static_cast<std::uint32_t>(expected * local->error() / octave);
      rows_[0] = Models::first_local +
                 Models::localLevel(*local) * Models::local_errors +
                 Models::localErrorClass(local->error());
    }
    else {
      expected_ = static_cast<std::int32_t>(otherwise_);
      if (has_record)
        deviation = static_cast<std::uint32_t>(tracked->deviation) << shift;
      rows_[0] = (has_record ? recordRow() : Models::first_running) +
                 Models::classOf(running_ / 16, Models::classes);
    }
    scale_ = highestBit(deviation + 4);
    rows_[1] =
        (is_tracked_ ? Models::scales : 0) + std::min(scale_, Models::scales - 1);
    if constexpr (CodingT::is_small) {
      const int above = (logarithmOf(running_ + 8) - local->logarithm()) >> 6;
      rows_[2] = local->faces() * Models::averages +
                 Models::classOf(average / 16, Models::averages);
      rows_[3] = has_record
                     ? recordRow() + (record->probability >> 13)
                     : Models::first_local +
                           Models::localLevel(*local) * Models::classes +
                           static_cast<std::uint32_t>(std::clamp(above + 4, 0, 7));
    }
  }

  /** \brief First of the rows of the mean of a record. */
  std::uint32_t
  recordRow() const
  {
    return Models::classOf(otherwise_ / 4, Models::levels) * Models::classes;
  }

  /** \brief Adapts the running means to a symbol. */
  void
  learn(std::uint32_t symbol)
  {
    const auto value = static_cast<std::int32_t>(symbol << 4);
    if (!is_tracked_)
      error_ += (std::abs(value - expected_) - error_) >> 3;
    const auto running = static_cast<std::int32_t>(running_);
    running_ = static_cast<std::uint32_t>(
        is_first_ ? value : running + ((value - running) >> 2));
    is_first_ = false;
  }

  /** \brief Codes the length of a symbol in bits, in unary in either direction from the
   * expected one.
   * \param[in] target not used by a decoder
   */
  std::uint32_t
  codeLength(std::uint32_t target)
  {
    if (shortest_ == symbol_bits_)
      return shortest_;
    const auto expected = static_cast<std::uint32_t>(std::max(expected_, 8));
    std::uint32_t length =
        std::clamp(highestBit(expected / 8), shortest_, symbol_bits_ - 1);
    const auto isLonger = [&](std::uint32_t node) {
      return codeDecision({node, true, 1u << length, std::max(length, 1u)},
                          target > length);
    };
    if (isLonger(Models::nodeOf(length))) {
      while (++length < symbol_bits_ && isLonger(Models::nodeOf(length))) {
      }
      return length;
    }
    while (length > shortest_) {
      --length;
      if (isLonger(Models::shorter + length))
        return length + 1;
    }
    return length;
  }

  /** \brief Codes a symbol: its length in bits, then the bits below the highest
   * one. */
  std::uint32_t
  codeSymbol(std::uint32_t symbol)
  {
    const std::uint32_t length =
        codeLength(CodingT::is_decoder || symbol == 0 ? 0 : highestBit(symbol) + 1);
    if (length < 2)
      return length;
    std::uint32_t prefix = 1;
    for (unsigned int bit = length - 1; bit-- > 0;) {
      const bool is_one = (symbol >> bit & 1) != 0;
      const bool selects = prefix < Models::prefixes;
      // Bits well below the deviation are noise.
      const bool is_noise = !selects && bit + 7 <= scale_;
      const Decision decision = {selects ? Models::nodeOf(length) + prefix
                                         : 5 * Models::prefixes + bit,
                                 false,
                                 (2 * prefix + 1) << bit,
                                 bit + 1};
      prefix = prefix << 1 |
               static_cast<std::uint32_t>(is_noise ? coding_.codeBypass(is_one)
                                                   : codeDecision(decision, is_one));
    }
    return prefix;
  }

  /** \param[in] is_above whether the symbol reaches the middle; not used by a decoder
   * \return whether it does
   */
  bool
  codeDecision(const Decision& decision, bool is_above)
  {
    const std::uint32_t first = rows_[0] * Models::nodes + decision.node;
    // Of lengths and small symbols, where mixing takes more time than it is worth.
    if (!CodingT::is_small && (decision.is_length || decision.node < 8))
      return coding_.codeFirst(models_.symbol, first, is_above);
    typename decltype(models_.symbol)::Contexts contexts;
    contexts.weight_set = 2 * decision.node + (is_tracked_ ? 1 : 0);
    contexts.ways[0] = first;
    contexts.ways[1] = distanceContext(decision);
    if constexpr (CodingT::is_small) {
      contexts.ways[2] = rows_[2] * Models::nodes + decision.node;
      contexts.ways[3] = rows_[3] * Models::nodes + decision.node;
    }
    return coding_.code(models_.symbol, contexts, is_above);
  }

  /** \brief Context of where the middle is from what is expected, in units of the
   * deviation. */
  std::uint32_t
  distanceContext(const Decision& decision) const
  {
    const std::int32_t distance =
        (static_cast<std::int32_t>(16 * decision.middle) - 8 - expected_) * 8 >> scale_;
    const std::uint32_t size =
        Models::classOf(static_cast<std::uint32_t>(distance < 0 ? ~distance : distance),
                        Models::distances);
    const std::uint32_t width =
        decision.width + 6 > scale_
            ? std::min(decision.width + 6 - scale_, Models::widths - 1)
            : 0;
    return ((rows_[1] * Models::widths + width) * 2 + (distance < 0 ? 0 : 1)) *
               Models::distances +
           size;
  }

  /** \brief Codes what is beyond a residual or symbol as an Elias gamma code whose
   * length has a model.
   * \param[in] number 0 or more
   * \param[in] longest number of bits that is invalid
   */
  std::uint32_t
  codeEscape(std::uint32_t number, std::uint32_t longest)
  {
    const std::uint32_t target = CodingT::is_decoder ? 0 : number + 1;
    std::uint32_t bits = 0;
    while (coding_.code(
        models_.escape, {{bits}}, !CodingT::is_decoder && target >> bits > 1))
      if (++bits == longest)
        return invalid;
    std::uint32_t value = 1;
    for (; bits > 0; --bits)
      value = value << 1 | static_cast<std::uint32_t>(
                               coding_.codeBypass((target >> (bits - 1) & 1) != 0));
    return value - 1;
  }

  CodingT& coding_;
  IntensityContexts& models_;
  FrameDirectory& directory_;
  const History& history_;
  unsigned int levels_;
  unsigned int symbol_bits_;
  std::uint32_t shortest_ = 0; ///< length of a symbol
  // In sixteenths of a symbol.
  std::uint32_t running_ = 16; ///< mean of the previous symbols
  std::int32_t error_ = 64;    ///< mean error of what was expected without records
  bool is_first_ = true;
  // Of the symbol that is coded.
  bool is_tracked_ = false;     ///< expected from a record
  bool is_local_ = false;       ///< expected from neighbours
  std::uint32_t otherwise_ = 0; ///< what is expected without neighbours
  std::int32_t expected_ = 0;
  unsigned int scale_ = 0; ///< of the deviation, as a power of two
  std::array<std::uint32_t, 4> rows_{};
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

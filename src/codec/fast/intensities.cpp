// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/intensities.h"

#include "codec/fast/symbol_statistics.h"
#include "codec/rans/entropy_coder.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

static_assert(History::no_statistics == symbol_statistics::none,
              "has a context of its own");

namespace {

/** \brief Not 0 if a nibble does not say all of a symbol: it is the escape, 15, or the
 * bin is one of those from 16 on, which have low bits. Both are seen in bit 4 and
 * above, so that it is one test, also for many voxels at once. */
constexpr unsigned int
moreThanNibble(unsigned int nibble, unsigned int bin)
{
  return ((nibble + 1) | bin) >> 4;
}

} // namespace

/** \brief Begins a frame: reads the statistics, and allocates all memory. */
void
Intensities::begin(const FrameBlocks& frame,
                   const StatisticsTable& statistics,
                   unsigned int bits)
{
  top_ = (1u << bits) - 1;
  const bool has_low_bits = top_ >= intensity_bins::exact;
  highest_bin_ = has_low_bits ? intensity_bins::binOf(top_) + 1 : top_;
  top_bin_ = has_low_bits ? highest_bin_ : intensity_bins::highest + 1;
  count_ = frame.voxel_count;
  cell_indices_ = frame.cell_indices.data();
  ensureSize(before_, count_);
  ensureSize(after_, count_);
  ensureSize(contexts_, count_);
  ensureSize(lowest_, count_);
  ensureSize(bins_, count_);
  ensureSize(coded_, count_);
  ensureSize(noted_, count_ + 1);
  std::uint16_t* const before = before_.data();
  for (std::size_t i = 0; i < count_; ++i)
    before[i] = statistics[cell_indices_[i]];
}

void
Intensities::restore(const FrameBlocks& frame, StatisticsTable& statistics) const
{
  for (std::size_t i = 0; i < frame.voxel_count; ++i)
    statistics[frame.cell_indices[i]] = before_[i];
}

template <class Coder, class Symbol>
bool
Intensities::code(Coder& coder,
                  SymbolModels& models,
                  const FrameBlocks& frame,
                  StatisticsTable& all_statistics,
                  unsigned int bits,
                  Symbol* symbols)
{
  begin(frame, all_statistics, bits);
  std::uint16_t* const statistics = all_statistics.data();
  const bool is_whole = frame.is_apart
                            ? codeRunning(coder, models, statistics, symbols)
                            : codeRow(coder, models, statistics, symbols) &&
                                  codeNotedBins(coder, models, statistics, symbols);
  if (!is_whole)
    return false;
  std::uint32_t bits_of_all = 0;
  for (std::size_t i = 0; Coder::is_decoder && i < count_; ++i)
    bits_of_all |= symbols[i];
  return bits_of_all <= top_;
}

/** \brief Codes the voxels of a frame without history, each relative to running
 * statistics of those before it. */
template <class Coder, class Symbol>
bool
Intensities::codeRunning(Coder& coder_now,
                         SymbolModels& models,
                         std::uint16_t* statistics,
                         Symbol* symbols)
{
  coder_now.reserve(4 * count_);
  Coder coder = coder_now;
  const CellIndex* const cell_indices = cell_indices_;
  symbol_statistics::Running running(2);
  for (std::size_t i = 0; i < count_; ++i) {
    const unsigned int lowest = running.lowestBin();
    unsigned int value = Coder::is_decoder ? 0u : symbols[i];
    unsigned int bin = Coder::is_decoder ? 0 : binOf(value);
    const unsigned int symbol = coder.code(models.running_symbol[running.contextOf()],
                                           std::min(bin - lowest, rans::escape));
    bin = lowest + symbol;
    if (moreThanNibble(symbol, bin) != 0) {
      // By a copy, so that the coder itself stays in registers.
      Coder copy = coder;
      if (symbol == rans::escape && !codeWholeBin(copy, models, lowest, value, bin))
        return false;
      if (!codeValue(copy, bin, value))
        return false;
      coder = copy;
    }
    else {
      value = bin;
    }
    statistics[cell_indices[i]] = symbol_statistics::first(bin);
    running.add(bin);
    if constexpr (Coder::is_decoder)
      symbols[i] = static_cast<std::uint16_t>(value);
    if (coder.isOverrun())
      return false;
  }
  coder_now = coder;
  return true;
}

/** \brief Codes the voxels of a frame with history, each relative to its own
 * statistics. The loops are such that compilers vectorise them. */
template <class Coder, class Symbol>
bool
Intensities::codeRow(Coder& coder,
                     SymbolModels& models,
                     std::uint16_t* statistics,
                     Symbol* symbols)
{
  const std::size_t count = count_;
  coder.reserve(count);
  // Local pointers (doc/implementation_notes.md, "Pointers in local variables").
  const std::uint16_t* const before = before_.data();
  std::uint16_t* const contexts = contexts_.data();
  std::uint16_t* const lowest = lowest_.data();
  std::uint8_t* const coded = coded_.data();
  for (std::size_t i = 0; i < count; ++i) {
    contexts[i] = symbol_statistics::contextOf<std::int16_t>(before[i]);
    lowest[i] = symbol_statistics::lowestBin<std::int16_t>(before[i]);
  }
  if constexpr (Coder::is_decoder) {
    if (!coder.codeRow(models.symbol.data(), contexts, coded, count))
      return false;
    learnRow(statistics, symbols);
  }
  else {
    const std::uint16_t* const bins = binsOf(symbols);
    for (std::size_t i = 0; i < count; ++i) {
      const auto above = static_cast<std::uint16_t>(bins[i] - lowest[i]);
      coded[i] = static_cast<std::uint8_t>(above < rans::escape ? above : rans::escape);
    }
    coder.codeRow(models.symbol.data(), contexts, coded, count);
    learnRow(statistics, contexts); // the contexts are not needed any more
  }
  return true;
}

/** \brief For an encoder: the bins of all symbols. */
const std::uint16_t*
Intensities::binsOf(const std::uint16_t* symbols)
{
  unsigned int any = 0;
  for (std::size_t i = 0; i < count_; ++i)
    any |= symbols[i];
  if (any < intensity_bins::exact)
    return symbols;
  for (std::size_t i = 0; i < count_; ++i)
    bins_[i] = static_cast<std::uint16_t>(binOf(symbols[i]));
  return bins_.data();
}

/** \brief Updates the statistics as far as the symbols are coded.
 * \param[out] bins of the voxels as far as they are coded
 */
void
Intensities::learnRow(std::uint16_t* statistics, std::uint16_t* bins)
{
  const std::size_t count = count_;
  const CellIndex* const cell_indices = cell_indices_;
  const std::uint16_t* const before = before_.data();
  const std::uint8_t* const coded = coded_.data();
  const std::uint16_t* const lowest = lowest_.data();
  std::uint16_t* const after = after_.data();
  std::uint16_t any = 0;
  for (std::size_t i = 0; i < count; ++i) {
    bins[i] = static_cast<std::uint16_t>(lowest[i] + coded[i]);
    after[i] = symbol_statistics::next<std::int16_t>(before[i], bins[i]);
    any = static_cast<std::uint16_t>(any | bins[i] | (coded[i] + 1));
  }
  for (std::size_t i = 0; i < count; ++i)
    statistics[cell_indices[i]] = after[i];
  // Voxels with an escaped bin or with low bits.
  std::uint32_t* noted = noted_.data();
  for (std::size_t i = 0; i < count && any >> 4 != 0; ++i) {
    *noted = static_cast<std::uint32_t>(i);
    noted += moreThanNibble(coded[i], bins[i]) != 0 ? 1 : 0;
  }
  noted_count_ = static_cast<std::size_t>(noted - noted_.data());
}

/** \brief Codes escaped bins and low bits of a P-frame. */
template <class Coder, class Symbol>
bool
Intensities::codeNotedBins(Coder& coder,
                           SymbolModels& models,
                           std::uint16_t* statistics,
                           Symbol* symbols)
{
  coder.reserve(3 * noted_count_);
  for (std::size_t i = 0; i < noted_count_; ++i) {
    const std::uint32_t voxel = noted_[i];
    const std::uint16_t before = before_[voxel];
    const unsigned int lowest = symbol_statistics::lowestBin(before);
    unsigned int value = symbols[voxel];
    // In a decoder the symbol is the bin as far as it is coded.
    unsigned int bin = Coder::is_decoder ? value : binOf(value);
    if (bin - lowest >= rans::escape) {
      if (!codeWholeBin(coder, models, lowest, value, bin))
        return false;
      statistics[cell_indices_[voxel]] = symbol_statistics::next(before, bin);
    }
    if (!codeValue(coder, bin, value) || coder.isOverrun())
      return false;
    if constexpr (Coder::is_decoder)
      symbols[voxel] = static_cast<std::uint16_t>(value);
  }
  return true;
}

unsigned int
Intensities::binOf(unsigned int value) const
{
  return value == top_ && value >= intensity_bins::exact ? top_bin_
                                                         : intensity_bins::binOf(value);
}

/** \brief Codes an escaped bin, which is not one of the fifteen from `lowest` on. */
template <class Coder>
bool
Intensities::codeWholeBin(Coder& coder,
                          SymbolModels& models,
                          unsigned int lowest,
                          unsigned int value,
                          unsigned int& bin)
{
  bin = Coder::is_decoder ? 0 : binOf(value);
  const unsigned int high = coder.code(models.escape_high, bin >> 4);
  bin = high << 4 | coder.code(models.escape_low[high & 7], bin & 15);
  return bin - lowest >= rans::escape;
}

/** \brief Codes the low bits of a value in a bin; a decoder sets the value. */
template <class Coder>
bool
Intensities::codeValue(Coder& coder, unsigned int bin, unsigned int& value)
{
  if (bin > highest_bin_)
    return false;
  if (bin == top_bin_)
    value = top_;
  else if (bin < intensity_bins::exact)
    value = bin;
  else {
    const unsigned int bits = intensity_bins::lowBits(bin);
    value = intensity_bins::lowestValue(bin) |
            coder.codeBits(bits, value & ((1u << bits) - 1));
    return value < top_ && !coder.isOverrun();
  }
  return true;
}

template bool
Intensities::code(rans::NibbleEncoder&,
                  SymbolModels&,
                  const FrameBlocks&,
                  StatisticsTable&,
                  unsigned int,
                  const std::uint16_t*);
template bool
Intensities::code(rans::SymbolSink&,
                  SymbolModels&,
                  const FrameBlocks&,
                  StatisticsTable&,
                  unsigned int,
                  const std::uint16_t*);
template bool
Intensities::code(rans::NibbleDecoder&,
                  SymbolModels&,
                  const FrameBlocks&,
                  StatisticsTable&,
                  unsigned int,
                  std::uint16_t*);

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

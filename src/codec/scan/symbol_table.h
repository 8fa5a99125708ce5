// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Fixed probabilities of symbols, which are sent before the symbols. */
class SymbolTable {
public:
  static constexpr std::size_t symbol_count = 80;
  using Counts = std::array<std::uint32_t, symbol_count>;
  using Widths = std::array<std::uint16_t, symbol_count>;

  /** \brief Sets the probabilities.
   * \param[in] widths slots of each symbol; their sum is rans::probability_one
   */
  void
  set(const Widths& widths);

  rans::ProbabilityRange
  range(unsigned int symbol) const
  {
    return {ranges_[symbol] & 0xffff, ranges_[symbol] >> 16};
  }

  /** \brief The symbol of a slot. */
  unsigned int
  find(std::uint32_t slot) const
  {
    return symbols_[slot];
  }

private:
  static constexpr std::size_t fill_size = 16; // slots written at a time

  std::array<std::uint32_t, symbol_count> ranges_{};
  std::array<std::uint8_t, rans::probability_one + fill_size> symbols_{};
};

/** \brief Slots for symbols in proportion to how often they occur: at least one for each
 * that does, and at least two symbols have some.
 * \param[in] counts their sum is below 2^32
 */
SymbolTable::Widths
widthsOf(const SymbolTable::Counts& counts);

/** \brief Bits that symbols take with the table of their counts, and about what that
 * takes itself, in units of 2^-8. */
std::uint64_t
costOf(const SymbolTable::Counts& counts);

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

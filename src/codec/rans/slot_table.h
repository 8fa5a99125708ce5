// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief Fixed probabilities of up to 256 symbols. */
template <std::size_t count>
class SlotTable {
public:
  static constexpr std::size_t symbol_count = count;
  using Widths = std::array<std::uint16_t, symbol_count>;

  /** \brief Sets the probabilities.
   * \param[in] widths slots of each symbol; their sum is probability_one
   */
  void
  set(const Widths& widths)
  {
    std::uint32_t start = 0;
    for (std::size_t symbol = 0; symbol < symbol_count; ++symbol) {
      const std::uint32_t end = start + widths[symbol];
      ranges_[symbol] = start | std::uint32_t{widths[symbol]} << 16;
      // Slots written beyond `end` are overwritten by the next symbol.
      for (std::uint32_t slot = start; slot < end; slot += fill_size)
        std::memset(&symbols_[slot], static_cast<int>(symbol), fill_size);
      start = end;
    }
  }

  ProbabilityRange
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
  std::array<std::uint8_t, probability_one + fill_size> symbols_{};
};

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

/** \brief Fixed probabilities of the 256 values of a byte. */
class ByteTable {
public:
  static constexpr std::size_t symbol_count = 256;
  using Weights = std::array<std::uint32_t, symbol_count>;

  /** \brief Sets the probabilities.
   * \param[in] weights of the values; their sum is 2^32 or a little less
   */
  void
  set(const Weights& weights);

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
  static constexpr std::size_t fill_size = 16; ///< slots written at a time

  std::array<std::uint32_t, symbol_count> ranges_;
  std::array<std::uint8_t, probability_one + fill_size> symbols_;
};

/** \brief The probability of the table for a probability, of which 2^16 is 1: in units
 * of 2^-7, in coarser steps in the middle. */
constexpr unsigned int
tableProbability(unsigned int probability)
{
  const unsigned int fine = probability >> 9;
  return fine < 1 ? 1 : fine >= 8 && fine < 120 ? fine / 4 * 4 + 2 : fine;
}

/** \brief Table of the occupancy pattern of eight voxels that are occupied
 * independently with the same probability.
 * \param[in] probability 2^16 is 1
 */
const ByteTable&
occupancyTable(unsigned int probability);

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io

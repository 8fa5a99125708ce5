// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/point_symbols.h"
#include "codec/rans/nibble_model.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Codes what numbers of points have beyond the highest symbol.
 * \param[in,out] counts one for each voxel; a decoder adds to their symbols
 * \return false if a decoded number is too large
 */
template <class Coder, class CountsT>
bool
codeExcess(Coder& coder, CountsT& counts)
{
  for (auto& count : counts) {
    if (count < highest_point_symbol)
      continue;
    coder.reserve(4);
    const std::uint32_t target = count - highest_point_symbol + 1;
    unsigned int left = coder.codeBits(5, Coder::is_decoder ? 0 : highestBit(target));
    std::uint32_t number = 1;
    while (left > 0) {
      const unsigned int part = std::min(left, rans::probability_bits);
      left -= part;
      number =
          number << part | coder.codeBits(part, target >> left & ((1u << part) - 1));
    }
    if (number - 1 > most_points - highest_point_symbol || coder.isOverrun())
      return false;
    if constexpr (Coder::is_decoder)
      count += number - 1;
  }
  return true;
}

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

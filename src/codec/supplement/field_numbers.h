// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/supplement/fields.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Bits of a number without leading zeros. */
inline unsigned int
bitLength(std::uint64_t number)
{
  const auto high = static_cast<std::uint32_t>(number >> 32);
  const auto low = static_cast<std::uint32_t>(number);
  return high != 0 ? 33 + highestBit(high) : low != 0 ? 1 + highestBit(low) : 0;
}

/** \brief 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...; differences are modulo 2^64. */
constexpr std::uint64_t
foldDifference(std::uint64_t number, std::uint64_t expected)
{
  const std::uint64_t difference = number - expected;
  return difference << 1 ^ (0 - (difference >> 63));
}

/** \brief Inverse of foldDifference. */
constexpr std::uint64_t
unfoldDifference(std::uint64_t folded, std::uint64_t expected)
{
  return expected + (folded >> 1 ^ (0 - (folded & 1)));
}

/** \brief Symbols to reserve for codeWide. */
constexpr std::size_t most_wide_symbols = 12;

/** \brief Codes a number of up to 64 bits: its length, its highest bits, the others as
 * they are.
 * \param[in,out] coding a NumberCoding
 * \param[in,out] lengths model of the context
 * \param[in,out] models of large numbers
 * \param[in,out] number the decoder sets it
 * \return false if what was decoded is no number
 */
template <class CodingT>
PCL_EXT_ALWAYS_INLINE bool
codeWide(CodingT& coding,
         rans::NibbleModel& lengths,
         WideNumberModels& models,
         std::uint64_t& number)
{
  unsigned int left = CodingT::is_decoder ? 0 : bitLength(number);
  unsigned int length = 0;
  rans::NibbleModel* model = &lengths;
  for (unsigned int nibble = rans::escape; nibble == rans::escape && length < 64;
       model = &models.further_lengths) {
    nibble = coding.codeNibble(*model, std::min(left, rans::escape));
    left -= std::min(left, rans::escape);
    length += nibble;
  }
  if (length > 64)
    return false;
  if (length < 2) {
    number = length;
    return !coding.isOverrun();
  }
  // Below the highest bit, which is 1, up to four bits have a model.
  const unsigned int below = length - 1;
  const unsigned int modelled = std::min(below, 4u);
  const unsigned int raw = below - modelled;
  const auto target = static_cast<unsigned int>(number >> raw & ((1u << modelled) - 1));
  const unsigned int high = coding.codeNibble(models.tails[length], target);
  if (high >> modelled != 0)
    return false;
  const std::uint64_t low =
      coding.codeBits(number & ((std::uint64_t{1} << raw) - 1), raw);
  number = (std::uint64_t{1} << below) | std::uint64_t{high} << raw | low;
  return !coding.isOverrun();
}

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/symbol_table.h"

#include "simd/bit_operations.h"

#include <algorithm>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

namespace {

/** \brief Binary logarithm in units of 2^-8, rounded down, of a number above 0. In
 * integers, so that encoders write the same bytes on all machines. */
std::uint32_t
log2Of(std::uint32_t number)
{
  const unsigned int octave = highestBit(number);
  std::uint64_t mantissa = (std::uint64_t{number} << 31) >> octave; // 2^31 is 1
  std::uint32_t fraction = 0;
  for (unsigned int bit = 0; bit < 8; ++bit) {
    mantissa = mantissa * mantissa >> 31;
    const std::uint64_t carry = mantissa >> 32;
    fraction = fraction << 1 | static_cast<std::uint32_t>(carry);
    mantissa >>= carry;
  }
  return octave << 8 | fraction;
}

} // namespace

SymbolTable::Widths
widthsOf(const SymbolCounts& counts)
{
  const std::uint64_t sum = std::max<std::uint64_t>(
      std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), 1);
  SymbolTable::Widths widths{};
  // No width is all slots, which the coder could not divide by.
  constexpr std::uint32_t most = rans::probability_one - 1;
  std::uint32_t used = 0;
  for (std::size_t symbol = 0; symbol < counts.size(); ++symbol) {
    const std::uint64_t share = (counts[symbol] * std::uint64_t{most} + sum / 2) / sum;
    const std::uint64_t least = counts[symbol] > 0 ? 1 : 0;
    widths[symbol] = static_cast<std::uint16_t>(std::max(share, least));
    used += widths[symbol];
  }
  // The widest symbols give what rounding took too much.
  const auto widest = [&widths] {
    return std::max_element(widths.begin(), widths.end());
  };
  for (; used > rans::probability_one; --used)
    --*widest();
  // What is left is of the widest or, where that has nearly all, of another one.
  const auto left = static_cast<std::uint16_t>(rans::probability_one - used);
  auto other = widest();
  if (*other + left > most)
    other = other == widths.begin() ? other + 1 : widths.begin();
  *other = static_cast<std::uint16_t>(*other + left);
  if (*other > most) // there are no counts
    widths = {static_cast<std::uint16_t>(most), 1};
  return widths;
}

std::uint64_t
costOf(const SymbolCounts& counts)
{
  constexpr std::uint64_t of_width = 7u << 8; // bits, about
  std::uint64_t sum = 0;
  std::uint64_t saved = 0;
  std::uint64_t widths = 0;
  for (const std::uint32_t count : counts)
    if (count > 0) {
      sum += count;
      saved += count * std::uint64_t{log2Of(count)};
      widths += of_width;
    }
  return sum == 0 ? 0 : sum * log2Of(static_cast<std::uint32_t>(sum)) - saved + widths;
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

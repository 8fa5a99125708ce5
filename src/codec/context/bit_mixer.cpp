// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/bit_mixer.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

LogisticTables::LogisticTables()
{
  // e^(1/256) in units of 2^-32. Powers are in units of 2^-18, so that no product
  // overflows.
  constexpr std::uint64_t factor = 0x10100802b;
  constexpr std::uint64_t one = std::uint64_t{1} << 18;
  std::uint64_t power = one;
  for (std::int32_t number = 0; number <= largest; ++number) {
    const auto probability = static_cast<std::int32_t>((power << 16) / (power + one));
    squash_[static_cast<std::size_t>(largest + number)] = probability;
    squash_[static_cast<std::size_t>(largest - number)] = (1 << 16) - probability;
    power = power * factor >> 32;
  }
  std::int32_t number = -largest;
  for (std::size_t i = 0; i < stretch_.size(); ++i) {
    // The smallest number whose probability reaches the middle of the interval.
    const auto probability = static_cast<std::int32_t>(16 * i + 8);
    while (number < largest && squash(number) < probability)
      ++number;
    stretch_[i] = static_cast<std::int16_t>(number);
  }
}

const LogisticTables&
logisticTables()
{
  static const LogisticTables tables;
  return tables;
}

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxels/ascending_keys.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Sorts keys, or entries by their member `key`, ascending; stable.
 *
 * Least significant digit first, with digits of equal width of at most 11 bits, so that
 * the counters fit the first-level cache. Each pass counts the digits of the next one:
 * the counters of all passes would be too large for the stack in a browser.
 * \param[in,out] entries entries to sort, fewer than 2^32
 * \param[in,out] spare scratch memory, kept from call to call
 * \param[in] key_bits keys are below 2^key_bits
 */
template <typename EntryT>
void
radixSort(std::vector<EntryT>& entries,
          std::vector<EntryT>& spare,
          unsigned int key_bits)
{
  constexpr unsigned int widest_digit = 11;
  using Counters = std::array<std::uint32_t, std::size_t{1} << widest_digit>;
  const unsigned int passes =
      std::max(1u, (key_bits + widest_digit - 1) / widest_digit);
  const unsigned int digit_bits = (key_bits + passes - 1) / passes;
  const std::size_t digit_mask = (std::size_t{1} << digit_bits) - 1;
  const auto digit_of = [&](const EntryT& entry, unsigned int pass) {
    return static_cast<std::size_t>(keyOf(entry) >> pass * digit_bits) & digit_mask;
  };
  Counters counters{};
  for (const EntryT& entry : entries)
    ++counters[digit_of(entry, 0)];

  spare.resize(entries.size());
  for (unsigned int pass = 0; pass < passes; ++pass) {
    std::uint32_t begin = 0;
    for (std::size_t digit = 0; digit <= digit_mask; ++digit)
      begin += std::exchange(counters[digit], begin);
    Counters next_counters{};
    const bool is_last = pass + 1 == passes;
    for (const EntryT& entry : entries) {
      spare[counters[digit_of(entry, pass)]++] = entry;
      if (!is_last)
        ++next_counters[digit_of(entry, pass + 1)];
    }
    entries.swap(spare);
    counters = next_counters;
  }
}

/** \brief Number of bits of the largest key, at least 1. */
template <typename EntryT>
unsigned int
usedBits(const std::vector<EntryT>& entries)
{
  std::uint64_t all_bits = 0;
  for (const EntryT& entry : entries)
    all_bits |= keyOf(entry);
  unsigned int bits = 1;
  while (bits < 64 && all_bits >> bits != 0)
    ++bits;
  return bits;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

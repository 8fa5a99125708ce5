#pragma once

#include "voxels/ascending_keys.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Sorts keys, or entries by their member `key`, ascending; stable.
 *
 * Least significant digit first, with digits of equal width of at most 11 bits, so that
 * the counters fit the first-level cache.
 * \param[in,out] entries entries to sort
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
  const unsigned int passes =
      std::max(1u, (key_bits + widest_digit - 1) / widest_digit);
  const unsigned int digit_bits = (key_bits + passes - 1) / passes;
  const std::size_t digit_mask = (std::size_t{1} << digit_bits) - 1;
  const auto digit_of = [&](const EntryT& entry, unsigned int shift) {
    return static_cast<std::size_t>(keyOf(entry) >> shift) & digit_mask;
  };
  spare.resize(entries.size());

  for (unsigned int pass = 0; pass < passes; ++pass) {
    const unsigned int shift = pass * digit_bits;
    std::array<std::size_t, std::size_t{1} << widest_digit> next{};
    for (const EntryT& entry : entries)
      ++next[digit_of(entry, shift)];
    std::size_t begin = 0;
    for (std::size_t digit = 0; digit <= digit_mask; ++digit)
      begin += std::exchange(next[digit], begin);
    for (const EntryT& entry : entries)
      spare[next[digit_of(entry, shift)]++] = entry;
    entries.swap(spare);
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

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Operations on rows of small integers for effort fast, with SSE2 and in plain
 * C++, with the same results.
 */
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace pcl_ext {

/** \brief The functions below in plain C++. */
namespace portable {

inline unsigned int
firstAbove(const std::uint16_t* ends, std::uint32_t number)
{
  unsigned int index = 0;
  while (ends[index] <= number)
    ++index;
  return index;
}

inline void
moveEnds(std::uint16_t* ends,
         std::uint8_t* counts,
         std::uint32_t least,
         std::uint32_t unit,
         unsigned int shift)
{
  std::uint32_t sum = 0;
  for (std::uint32_t i = 0; i < 16; ++i) {
    sum += counts[i];
    counts[i] = 0;
    const std::uint32_t goal = (i + 1) * least + sum * unit;
    const std::int32_t distance = static_cast<std::int32_t>(goal) - ends[i];
    ends[i] = static_cast<std::uint16_t>(ends[i] + (distance >> shift));
  }
}

template <class Number>
inline void
addToBytes(const std::uint8_t* bytes, Number number, Number* sums)
{
  for (std::size_t i = 0; i < 8; ++i)
    sums[i] = number + bytes[i];
}

} // namespace portable

/** \brief Index of the first of sixteen ends above number * 2^bits + offset, which must
 * be below 2^15.
 * \param[in] ends sixteen of them, ascending, the last one 2^15; aligned to 16 bytes
 */
template <unsigned int bits, std::uint32_t offset>
PCL_EXT_ALWAYS_INLINE unsigned int
firstAbove(const std::uint16_t* ends, std::uint32_t number)
{
#if defined(__SSE2__)
  // In 16 bits end - number - 1 - 2^15 is negative if end > number. That is one
  // instruction less than a signed comparison, whose operand cannot be 2^15.
  constexpr std::uint32_t shift = offset + 1 + (std::uint32_t{1} << 15);
  const __m128i bound = _mm_set1_epi16(static_cast<short>((number << bits) + shift));
  const auto* const values = reinterpret_cast<const __m128i*>(ends);
  const __m128i low = _mm_sub_epi16(_mm_load_si128(values), bound);
  const __m128i high = _mm_sub_epi16(_mm_load_si128(values + 1), bound);
  const auto above =
      static_cast<unsigned int>(_mm_movemask_epi8(_mm_packs_epi16(low, high)));
  return lowestBit(above);
#else
  return portable::firstAbove(ends, (number << bits) + offset);
#endif
}

/** \brief Adapts ends to counts, and sets the counts to 0: end i moves by 2^-shift of
 * its distance to (i + 1) * least + unit * (sum of the counts up to i).
 * \param[in,out] ends sixteen of them; aligned to 16 bytes
 * \param[in,out] counts sixteen of them, at most 255 in all; aligned to 16 bytes
 */
inline void
moveEnds(std::uint16_t* ends,
         std::uint8_t* counts,
         std::uint32_t least,
         std::uint32_t unit,
         unsigned int shift)
{
#if defined(__SSE2__)
  auto* const values = reinterpret_cast<__m128i*>(ends);
  auto* const bytes = reinterpret_cast<__m128i*>(counts);
  __m128i sums = _mm_load_si128(bytes);
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 1));
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 2));
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 4));
  sums = _mm_add_epi8(sums, _mm_slli_si128(sums, 8));
  const __m128i zero = _mm_setzero_si128();
  const __m128i units = _mm_set1_epi16(static_cast<short>(unit));
  const auto w = static_cast<short>(least);
  const auto times = [w](int factor) { return static_cast<short>(factor * w); };
  const __m128i floors = _mm_set_epi16(
      times(8), times(7), times(6), times(5), times(4), times(3), times(2), w);
  const __m128i shifts = _mm_cvtsi32_si128(static_cast<int>(shift));
  const auto moved = [&](__m128i end, __m128i count, __m128i floor) {
    const __m128i goal = _mm_add_epi16(_mm_mullo_epi16(count, units), floor);
    return _mm_add_epi16(end, _mm_sra_epi16(_mm_sub_epi16(goal, end), shifts));
  };
  _mm_store_si128(values,
                  moved(_mm_load_si128(values), _mm_unpacklo_epi8(sums, zero), floors));
  _mm_store_si128(values + 1,
                  moved(_mm_load_si128(values + 1),
                        _mm_unpackhi_epi8(sums, zero),
                        _mm_add_epi16(floors, _mm_set1_epi16(times(8)))));
  _mm_store_si128(bytes, zero);
#else
  portable::moveEnds(ends, counts, least, unit, shift);
#endif
}

#if defined(__SSE2__)
/** \brief Eight numbers of 32 bits. */
struct EightNumbers {
  __m128i low;
  __m128i high;
};

/** \brief Eight bytes as numbers. */
inline EightNumbers
widened(const std::uint8_t* bytes)
{
  const __m128i zero = _mm_setzero_si128();
  const __m128i words =
      _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes)), zero);
  return {_mm_unpacklo_epi16(words, zero), _mm_unpackhi_epi16(words, zero)};
}
#endif

/** \brief Adds a number to each of eight bytes. */
inline void
addToBytes(const std::uint8_t* bytes, std::uint32_t number, std::uint32_t* sums)
{
#if defined(__SSE2__)
  const EightNumbers wide = widened(bytes);
  const __m128i all = _mm_set1_epi32(static_cast<int>(number));
  auto* const target = reinterpret_cast<__m128i*>(sums);
  _mm_storeu_si128(target, _mm_add_epi32(wide.low, all));
  _mm_storeu_si128(target + 1, _mm_add_epi32(wide.high, all));
#else
  portable::addToBytes(bytes, number, sums);
#endif
}

/** \brief Adds a number to each of eight bytes. */
inline void
addToBytes(const std::uint8_t* bytes, std::uint64_t number, std::uint64_t* sums)
{
#if defined(__SSE2__)
  const EightNumbers wide = widened(bytes);
  const __m128i zero = _mm_setzero_si128();
  const __m128i all = _mm_set1_epi64x(static_cast<long long>(number));
  auto* const target = reinterpret_cast<__m128i*>(sums);
  _mm_storeu_si128(target, _mm_add_epi64(_mm_unpacklo_epi32(wide.low, zero), all));
  _mm_storeu_si128(target + 1, _mm_add_epi64(_mm_unpackhi_epi32(wide.low, zero), all));
  _mm_storeu_si128(target + 2, _mm_add_epi64(_mm_unpacklo_epi32(wide.high, zero), all));
  _mm_storeu_si128(target + 3, _mm_add_epi64(_mm_unpackhi_epi32(wide.high, zero), all));
#else
  portable::addToBytes(bytes, number, sums);
#endif
}

} // namespace pcl_ext

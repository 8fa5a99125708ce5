// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <emmintrin.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext {

/** \brief The lanes of SSE2, which every x86-64 machine has; see ScalarLanes. */
struct Sse2Lanes {
  using Floats = __m128;
  using Ints = __m128i;

  static constexpr unsigned int width = 4;

  static Floats
  all(float value)
  {
    return _mm_set1_ps(value);
  }

  static Ints
  all(std::int32_t value)
  {
    return _mm_set1_epi32(value);
  }

  static Floats
  add(Floats first, Floats second)
  {
    return _mm_add_ps(first, second);
  }

  static Floats
  subtract(Floats first, Floats second)
  {
    return _mm_sub_ps(first, second);
  }

  static Floats
  multiply(Floats first, Floats second)
  {
    return _mm_mul_ps(first, second);
  }

  static Floats
  minimum(Floats first, Floats second)
  {
    return _mm_min_ps(first, second);
  }

  static Floats
  maximum(Floats first, Floats second)
  {
    return _mm_max_ps(first, second);
  }

  static Ints
  less(Floats first, Floats second)
  {
    return _mm_castps_si128(_mm_cmplt_ps(first, second));
  }

  static Ints
  lessOrEqual(Floats first, Floats second)
  {
    return _mm_castps_si128(_mm_cmple_ps(first, second));
  }

  static Floats
  absolute(Floats values)
  {
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), values);
  }

  static Ints
  round(Floats values)
  {
    return _mm_cvtps_epi32(values);
  }

  static Floats
  toFloats(Ints values)
  {
    return _mm_cvtepi32_ps(values);
  }

  static Ints
  subtract(Ints first, Ints second)
  {
    return _mm_sub_epi32(first, second);
  }

  static Ints
  bitAnd(Ints first, Ints second)
  {
    return _mm_and_si128(first, second);
  }

  static Ints
  bitOr(Ints first, Ints second)
  {
    return _mm_or_si128(first, second);
  }

  static Ints
  isZero(Ints values)
  {
    return _mm_cmpeq_epi32(values, _mm_setzero_si128());
  }

  template <int bits>
  static Ints
  shiftLeft(Ints values)
  {
    return _mm_slli_epi32(values, bits);
  }

  template <int bits>
  static Ints
  shiftRight(Ints values)
  {
    return _mm_srli_epi32(values, bits);
  }

  static unsigned int
  bitsOf(Ints mask)
  {
    return static_cast<unsigned int>(_mm_movemask_ps(_mm_castsi128_ps(mask)));
  }

  static void
  store(Ints values, std::uint32_t* to)
  {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), values);
  }

  static void
  store(Floats values, float* to)
  {
    _mm_storeu_ps(to, values);
  }

  template <unsigned int part>
  static void
  storeFour(Floats values, float* to)
  {
    static_assert(part == 0);
    store(values, to);
  }

  static void
  storePairs(Ints low, Ints high, std::uint64_t* to)
  {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_unpacklo_epi32(low, high));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + 2), _mm_unpackhi_epi32(low, high));
  }

  static unsigned int
  nonZeroBytes(const std::uint8_t* bytes)
  {
    const __m128i values = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
    const int zeros = _mm_movemask_epi8(_mm_cmpeq_epi8(values, _mm_setzero_si128()));
    return static_cast<unsigned int>(zeros) ^ 0xffff;
  }

  static void
  transpose(Floats& x, Floats& y, Floats& z, Floats& w)
  {
    _MM_TRANSPOSE4_PS(x, y, z, w);
  }

  static Floats
  loadPoint(const unsigned char* point)
  {
    // As integers, as the bytes may not be aligned for floats.
    return _mm_castsi128_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(point)));
  }
};

} // namespace pcl_ext

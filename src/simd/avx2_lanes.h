// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/lanes_target.h"

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext {

/** \brief Eight lanes, of AVX2; see ScalarLanes, and lanes_target.h for their use. */
struct Avx2Lanes {
  using Floats = __m256;
  using Ints = __m256i;

  static constexpr unsigned int width = 8;

  PCL_EXT_LANES_TARGET static Floats
  all(float value)
  {
    return _mm256_set1_ps(value);
  }

  PCL_EXT_LANES_TARGET static Ints
  all(std::int32_t value)
  {
    return _mm256_set1_epi32(value);
  }

  PCL_EXT_LANES_TARGET static Floats
  add(Floats first, Floats second)
  {
    return _mm256_add_ps(first, second);
  }

  PCL_EXT_LANES_TARGET static Floats
  subtract(Floats first, Floats second)
  {
    return _mm256_sub_ps(first, second);
  }

  PCL_EXT_LANES_TARGET static Floats
  multiply(Floats first, Floats second)
  {
    return _mm256_mul_ps(first, second);
  }

  PCL_EXT_LANES_TARGET static Floats
  minimum(Floats first, Floats second)
  {
    return _mm256_min_ps(first, second);
  }

  PCL_EXT_LANES_TARGET static Floats
  maximum(Floats first, Floats second)
  {
    return _mm256_max_ps(first, second);
  }

  PCL_EXT_LANES_TARGET static Ints
  less(Floats first, Floats second)
  {
    return _mm256_castps_si256(_mm256_cmp_ps(first, second, _CMP_LT_OQ));
  }

  PCL_EXT_LANES_TARGET static Ints
  lessOrEqual(Floats first, Floats second)
  {
    return _mm256_castps_si256(_mm256_cmp_ps(first, second, _CMP_LE_OQ));
  }

  PCL_EXT_LANES_TARGET static Floats
  absolute(Floats values)
  {
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), values);
  }

  PCL_EXT_LANES_TARGET static Ints
  round(Floats values)
  {
    return _mm256_cvtps_epi32(values);
  }

  PCL_EXT_LANES_TARGET static Floats
  toFloats(Ints values)
  {
    return _mm256_cvtepi32_ps(values);
  }

  PCL_EXT_LANES_TARGET static Ints
  subtract(Ints first, Ints second)
  {
    return _mm256_sub_epi32(first, second);
  }

  PCL_EXT_LANES_TARGET static Ints
  bitAnd(Ints first, Ints second)
  {
    return _mm256_and_si256(first, second);
  }

  PCL_EXT_LANES_TARGET static Ints
  bitOr(Ints first, Ints second)
  {
    return _mm256_or_si256(first, second);
  }

  PCL_EXT_LANES_TARGET static Ints
  isZero(Ints values)
  {
    return _mm256_cmpeq_epi32(values, _mm256_setzero_si256());
  }

  template <int bits>
  PCL_EXT_LANES_TARGET static Ints
  shiftLeft(Ints values)
  {
    return _mm256_slli_epi32(values, bits);
  }

  template <int bits>
  PCL_EXT_LANES_TARGET static Ints
  shiftRight(Ints values)
  {
    return _mm256_srli_epi32(values, bits);
  }

  PCL_EXT_LANES_TARGET static unsigned int
  bitsOf(Ints mask)
  {
    return static_cast<unsigned int>(_mm256_movemask_ps(_mm256_castsi256_ps(mask)));
  }

  PCL_EXT_LANES_TARGET static void
  store(Ints values, std::uint32_t* to)
  {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), values);
  }

  PCL_EXT_LANES_TARGET static void
  store(Floats values, float* to)
  {
    _mm256_storeu_ps(to, values);
  }

  template <unsigned int part>
  PCL_EXT_LANES_TARGET static void
  storeFour(Floats values, float* to)
  {
    static_assert(part < 2);
    _mm_storeu_ps(to, _mm256_extractf128_ps(values, part));
  }

  PCL_EXT_LANES_TARGET static void
  storePairs(Ints low, Ints high, std::uint64_t* to)
  {
    // Within each half of the lanes.
    const __m256i first = _mm256_unpacklo_epi32(low, high);
    const __m256i last = _mm256_unpackhi_epi32(low, high);
    auto* const pairs = reinterpret_cast<__m256i*>(to);
    _mm256_storeu_si256(pairs, _mm256_permute2x128_si256(first, last, 0x20));
    _mm256_storeu_si256(pairs + 1, _mm256_permute2x128_si256(first, last, 0x31));
  }

  PCL_EXT_LANES_TARGET static void
  transpose(Floats& x, Floats& y, Floats& z, Floats& w)
  {
    const __m256 low_xy = _mm256_unpacklo_ps(x, y);
    const __m256 high_xy = _mm256_unpackhi_ps(x, y);
    const __m256 low_zw = _mm256_unpacklo_ps(z, w);
    const __m256 high_zw = _mm256_unpackhi_ps(z, w);
    x = _mm256_shuffle_ps(low_xy, low_zw, 0x44);
    y = _mm256_shuffle_ps(low_xy, low_zw, 0xee);
    z = _mm256_shuffle_ps(high_xy, high_zw, 0x44);
    w = _mm256_shuffle_ps(high_xy, high_zw, 0xee);
  }

  /** \brief Reads four floats each of two points, which need not be aligned, into the
   * first and the last four lanes. */
  PCL_EXT_LANES_TARGET static Floats
  loadPoints(const unsigned char* first, const unsigned char* last)
  {
    // As integers, as the bytes may not be aligned for floats.
    const __m128i low = _mm_loadu_si128(reinterpret_cast<const __m128i*>(first));
    const __m128i high = _mm_loadu_si128(reinterpret_cast<const __m128i*>(last));
    return _mm256_castsi256_ps(
        _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1));
  }
};

} // namespace pcl_ext

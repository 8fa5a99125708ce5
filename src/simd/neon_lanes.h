// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <arm_neon.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext {

/** \brief The lanes of NEON, which every ARMv8 machine has; see ScalarLanes. */
struct NeonLanes {
  using Floats = float32x4_t;
  using Ints = int32x4_t;

  static constexpr unsigned int width = 4;

  static Floats
  all(float value)
  {
    return vdupq_n_f32(value);
  }

  static Ints
  all(std::int32_t value)
  {
    return vdupq_n_s32(value);
  }

  static Floats
  add(Floats first, Floats second)
  {
    return vaddq_f32(first, second);
  }

  static Floats
  subtract(Floats first, Floats second)
  {
    return vsubq_f32(first, second);
  }

  static Floats
  multiply(Floats first, Floats second)
  {
    return vmulq_f32(first, second);
  }

  static Floats
  minimum(Floats first, Floats second)
  {
    return vminq_f32(first, second);
  }

  static Floats
  maximum(Floats first, Floats second)
  {
    return vmaxq_f32(first, second);
  }

  static Ints
  less(Floats first, Floats second)
  {
    return vreinterpretq_s32_u32(vcltq_f32(first, second));
  }

  static Ints
  lessOrEqual(Floats first, Floats second)
  {
    return vreinterpretq_s32_u32(vcleq_f32(first, second));
  }

  static Floats
  absolute(Floats values)
  {
    return vabsq_f32(values);
  }

  static Ints
  round(Floats values)
  {
    return vcvtnq_s32_f32(values);
  }

  static Floats
  toFloats(Ints values)
  {
    return vcvtq_f32_s32(values);
  }

  static Ints
  subtract(Ints first, Ints second)
  {
    return vsubq_s32(first, second);
  }

  static Ints
  bitAnd(Ints first, Ints second)
  {
    return vandq_s32(first, second);
  }

  static Ints
  bitOr(Ints first, Ints second)
  {
    return vorrq_s32(first, second);
  }

  static Ints
  isZero(Ints values)
  {
    return vreinterpretq_s32_u32(vceqzq_s32(values));
  }

  template <int bits>
  static Ints
  shiftLeft(Ints values)
  {
    return vshlq_n_s32(values, bits);
  }

  template <int bits>
  static Ints
  shiftRight(Ints values)
  {
    return vreinterpretq_s32_u32(vshrq_n_u32(vreinterpretq_u32_s32(values), bits));
  }

  static unsigned int
  bitsOf(Ints mask)
  {
    const uint32x4_t weights = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(vreinterpretq_u32_s32(mask), weights));
  }

  static void
  store(Ints values, std::uint32_t* to)
  {
    vst1q_u32(to, vreinterpretq_u32_s32(values));
  }

  static void
  store(Floats values, float* to)
  {
    vst1q_f32(to, values);
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
    // As bytes, as the name of the 64-bit type differs between systems.
    auto* const bytes = reinterpret_cast<std::uint8_t*>(to);
    vst1q_u8(bytes, vreinterpretq_u8_s32(vzip1q_s32(low, high)));
    vst1q_u8(bytes + 16, vreinterpretq_u8_s32(vzip2q_s32(low, high)));
  }

  static unsigned int
  nonZeroBytes(const std::uint8_t* bytes)
  {
    const uint8x16_t values = vld1q_u8(bytes);
    const uint8x8_t weights = {1, 2, 4, 8, 16, 32, 64, 128};
    const uint8x16_t bits =
        vandq_u8(vtstq_u8(values, values), vcombine_u8(weights, weights));
    return vaddv_u8(vget_low_u8(bits)) |
           static_cast<unsigned int>(vaddv_u8(vget_high_u8(bits))) << 8;
  }

  static void
  transpose(Floats& x, Floats& y, Floats& z, Floats& w)
  {
    const float32x4_t low_xz = vzip1q_f32(x, z);
    const float32x4_t high_xz = vzip2q_f32(x, z);
    const float32x4_t low_yw = vzip1q_f32(y, w);
    const float32x4_t high_yw = vzip2q_f32(y, w);
    x = vzip1q_f32(low_xz, low_yw);
    y = vzip2q_f32(low_xz, low_yw);
    z = vzip1q_f32(high_xz, high_yw);
    w = vzip2q_f32(high_xz, high_yw);
  }

  static Floats
  loadPoint(const unsigned char* point)
  {
    return vreinterpretq_f32_u8(vld1q_u8(point));
  }
};

} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace pcl_ext {

/** \brief Four lanes of floats or integers in plain C++: for machines without vector
 * instructions, and as the reference for the other lanes types, which have to give the
 * same results to the last bit.
 *
 * Contract of a lanes type: the members below, for so many lanes as its width, four or
 * eight. Comparisons return a mask with all bits set in lanes where they are true; they
 * are false for NaN.
 */
struct ScalarLanes {
  using Floats = std::array<float, 4>;
  using Ints = std::array<std::int32_t, 4>;

  static constexpr unsigned int width = 4;

  static Floats
  all(float value)
  {
    return {value, value, value, value};
  }

  static Ints
  all(std::int32_t value)
  {
    return {value, value, value, value};
  }

  static Floats
  add(const Floats& first, const Floats& second)
  {
    return each(first, second, [](float a, float b) { return a + b; });
  }

  static Floats
  subtract(const Floats& first, const Floats& second)
  {
    return each(first, second, [](float a, float b) { return a - b; });
  }

  static Floats
  multiply(const Floats& first, const Floats& second)
  {
    return each(first, second, [](float a, float b) { return a * b; });
  }

  /** \brief The smaller numbers; of NaN and a number either. */
  static Floats
  minimum(const Floats& first, const Floats& second)
  {
    return each(first, second, [](float a, float b) { return a < b ? a : b; });
  }

  /** \brief The larger numbers; of NaN and a number either. */
  static Floats
  maximum(const Floats& first, const Floats& second)
  {
    return each(first, second, [](float a, float b) { return a > b ? a : b; });
  }

  static Ints
  less(const Floats& first, const Floats& second)
  {
    Ints mask;
    for (std::size_t lane = 0; lane < 4; ++lane)
      mask[lane] = first[lane] < second[lane] ? -1 : 0;
    return mask;
  }

  static Ints
  lessOrEqual(const Floats& first, const Floats& second)
  {
    Ints mask;
    for (std::size_t lane = 0; lane < 4; ++lane)
      mask[lane] = first[lane] <= second[lane] ? -1 : 0;
    return mask;
  }

  static Floats
  absolute(const Floats& values)
  {
    return each(values, values, [](float a, float) { return std::fabs(a); });
  }

  /** \brief The nearest integers in the current rounding mode; any integer for numbers
   * that do not fit 32 bits. */
  static Ints
  round(const Floats& values)
  {
    Ints result;
    for (std::size_t lane = 0; lane < 4; ++lane)
      result[lane] = values[lane] >= -0x1p31f && values[lane] < 0x1p31f
                         ? static_cast<std::int32_t>(std::nearbyint(values[lane]))
                         : std::numeric_limits<std::int32_t>::min();
    return result;
  }

  static Floats
  toFloats(const Ints& values)
  {
    Floats result;
    for (std::size_t lane = 0; lane < 4; ++lane)
      result[lane] = static_cast<float>(values[lane]);
    return result;
  }

  /** \brief Differences, modulo 2^32. */
  static Ints
  subtract(const Ints& first, const Ints& second)
  {
    return eachBits(
        first, second, [](std::uint32_t a, std::uint32_t b) { return a - b; });
  }

  static Ints
  bitAnd(const Ints& first, const Ints& second)
  {
    return eachBits(
        first, second, [](std::uint32_t a, std::uint32_t b) { return a & b; });
  }

  static Ints
  bitOr(const Ints& first, const Ints& second)
  {
    return eachBits(
        first, second, [](std::uint32_t a, std::uint32_t b) { return a | b; });
  }

  static Ints
  isZero(const Ints& values)
  {
    return eachBits(values, values, [](std::uint32_t a, std::uint32_t) {
      return a == 0 ? ~0u : 0u;
    });
  }

  template <int bits>
  static Ints
  shiftLeft(const Ints& values)
  {
    return eachBits(
        values, values, [](std::uint32_t a, std::uint32_t) { return a << bits; });
  }

  /** \brief Logical shift: the highest bits become 0. */
  template <int bits>
  static Ints
  shiftRight(const Ints& values)
  {
    return eachBits(
        values, values, [](std::uint32_t a, std::uint32_t) { return a >> bits; });
  }

  /** \brief Bit i is set if lane i of a mask is set. */
  static unsigned int
  bitsOf(const Ints& mask)
  {
    unsigned int bits = 0;
    for (unsigned int lane = 0; lane < 4; ++lane)
      bits |= mask[lane] != 0 ? 1u << lane : 0u;
    return bits;
  }

  static void
  store(const Ints& values, std::uint32_t* to)
  {
    std::memcpy(to, values.data(), sizeof(values));
  }

  static void
  store(const Floats& values, float* to)
  {
    std::memcpy(to, values.data(), sizeof(values));
  }

  /** \brief Writes the four floats that begin with lane 4 * part. */
  template <unsigned int part>
  static void
  storeFour(const Floats& values, float* to)
  {
    static_assert(part == 0);
    store(values, to);
  }

  /** \brief Writes a 64-bit number a lane, given as low and high halves. */
  static void
  storePairs(const Ints& low, const Ints& high, std::uint64_t* to)
  {
    for (std::size_t lane = 0; lane < 4; ++lane)
      to[lane] = static_cast<std::uint32_t>(low[lane]) |
                 std::uint64_t{static_cast<std::uint32_t>(high[lane])} << 32;
  }

  /** \brief Bit i is set where byte i of 16 is not 0. */
  static unsigned int
  nonZeroBytes(const std::uint8_t* bytes)
  {
    unsigned int bits = 0;
    for (unsigned int i = 0; i < 16; ++i)
      bits |= bytes[i] != 0 ? 1u << i : 0u;
    return bits;
  }

  /** \brief Reads four floats of a point, which need not be aligned. */
  static Floats
  loadPoint(const unsigned char* point)
  {
    Floats floats;
    std::memcpy(floats.data(), point, sizeof(floats));
    return floats;
  }

  /** \brief Transposes x, y, z, w of four points to four points x, y, z, w; with eight
   * lanes the first and the last four points by themselves. */
  static void
  transpose(Floats& x, Floats& y, Floats& z, Floats& w)
  {
    const std::array<Floats, 4> rows{x, y, z, w};
    for (std::size_t row = 0; row < 4; ++row) {
      x[row] = rows[row][0];
      y[row] = rows[row][1];
      z[row] = rows[row][2];
      w[row] = rows[row][3];
    }
  }

private:
  template <typename OperationT>
  static Floats
  each(const Floats& first, const Floats& second, OperationT operation)
  {
    Floats result;
    for (std::size_t lane = 0; lane < 4; ++lane)
      result[lane] = operation(first[lane], second[lane]);
    return result;
  }

  template <typename OperationT>
  static Ints
  eachBits(const Ints& first, const Ints& second, OperationT operation)
  {
    Ints result;
    for (std::size_t lane = 0; lane < 4; ++lane)
      result[lane] = static_cast<std::int32_t>(
          operation(static_cast<std::uint32_t>(first[lane]),
                    static_cast<std::uint32_t>(second[lane])));
    return result;
  }
};

} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the step of a sensor's intensities: the largest of some fractions of 1
 * that all of them are multiples of. */
class CommonStep {
public:
  /** \brief Takes a finite number into account. */
  void
  add(float number)
  {
    if (!isWholeNumber(number))
      addFraction(number);
  }

  /** \brief Takes the numbers of another instance into account. */
  void
  add(const CommonStep& other)
  {
    candidates_ &= other.candidates_;
  }

  /** \brief True for whole numbers below 2^23, which need not be added; without a
   * branch, for loops over many numbers. */
  static bool
  isSmallWholeNumber(float number)
  {
    const bool is_small = std::abs(number) < 0x1p23f; // NaN is not
    const float converted = is_small ? number : 0.5f;
    return static_cast<float>(static_cast<std::int32_t>(converted)) == converted;
  }

  /** \brief The step is 1 / divisor; 0: there is none. */
  unsigned int
  divisor() const
  {
    return candidates_ == 0 ? 0 : divisors[lowestBit(candidates_)];
  }

private:
  /** \brief Of fractions that programs divide or round by: tenths to thousandths, 7 to
   * 12 bits with and without the highest number as 1. */
  static constexpr std::array<std::uint16_t, 17> divisors = {
      1, 2, 4, 5, 8, 10, 20, 50, 100, 127, 128, 200, 255, 256, 1000, 1023, 4095};

  /** \brief Without a library call. */
  static bool
  isWholeNumber(float number)
  {
    return std::abs(number) >= 0x1p23f || isSmallWholeNumber(number);
  }

  void
  addFraction(float number)
  {
    for (std::uint32_t left = candidates_; left != 0; left &= left - 1) {
      const unsigned int candidate = lowestBit(left);
      const double multiple =
          std::abs(static_cast<double>(number)) * divisors[candidate];
      // A float is within 2^-24 of its decimal; more than 16 bits are not coded.
      constexpr double most = 65535.0;
      const double nearest = std::floor(multiple + 0.5);
      if (multiple > most || std::abs(multiple - nearest) > multiple * 0x1p-23)
        candidates_ &= ~(std::uint32_t{1} << candidate);
    }
  }

  std::uint32_t candidates_ = (std::uint32_t{1} << divisors.size()) - 1; // one bit each
};

} // namespace pcl_ext::PCL_EXT_ABI::io

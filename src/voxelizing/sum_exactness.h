// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Tells whether sums of some floats in double precision are exact, so that they
 * do not depend on the order of the summands. */
class SumExactness {
public:
  /** \brief Takes finite numbers into account.
   * \param[in] are_whole all are whole numbers below 2^23
   */
  void
  add(const float* numbers, std::size_t count, bool are_whole)
  {
    std::uint32_t largest = largest_;
    std::uint32_t smallest = smallest_;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t magnitude;
      std::memcpy(&magnitude, numbers + i, sizeof(magnitude));
      magnitude &= 0x7fffffff;
      largest = std::max(largest, magnitude);
      smallest = std::min(smallest, magnitude - 1); // 0 becomes the largest
    }
    largest_ = largest;
    if (are_whole)
      has_whole_ |= count > 0;
    else
      smallest_ = smallest;
  }

  /** \brief Takes the numbers of another instance into account. */
  void
  add(const SumExactness& other)
  {
    largest_ = std::max(largest_, other.largest_);
    smallest_ = std::min(smallest_, other.smallest_);
    has_whole_ |= other.has_whole_;
  }

  /** \brief True if any sum of at most some of the numbers is exact. */
  bool
  areExact(std::uint64_t summands) const
  {
    if (largest_ == 0)
      return true;
    // A number is below 2^(e + 1) and a multiple of 2^(e - 23), whole ones of 1;
    // exponents are biased. Multiples of a step below 2^53 steps are exact.
    const auto exponent = [](std::uint32_t magnitude) {
      return std::max<std::int32_t>(static_cast<std::int32_t>(magnitude >> 23), 1);
    };
    constexpr std::int32_t of_one = 127;
    constexpr std::int32_t fraction_bits = 23;
    std::int32_t step = has_whole_ ? of_one : exponent(largest_) - fraction_bits;
    if (smallest_ != none)
      step = std::min(step, exponent(smallest_ + 1) - fraction_bits);
    const std::int32_t spare_bits = 53 + step - (exponent(largest_) + 1);
    return spare_bits >= 32 || (spare_bits >= 0 && summands >> spare_bits == 0);
  }

private:
  static constexpr std::uint32_t none = 0xffffffff;

  std::uint32_t largest_ = 0;     // its bits without the sign
  std::uint32_t smallest_ = none; // of those that are not 0 and not whole, less 1
  bool has_whole_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

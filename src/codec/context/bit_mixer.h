// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief The logistic function and its inverse in fixed point, for mixing
 * (doc/bitstream_context.md, "Mixing"). The tables are made with integers only, so that
 * they are the same on every machine. */
class LogisticTables {
public:
  /** \brief Largest magnitude of a number on the logistic scale, whose unit is
   * 1/256. */
  static constexpr std::int32_t largest = 2047;

  LogisticTables();

  /** \brief Probability, in units of 2^-16, of a number on the logistic scale, which is
   * clamped to -largest..largest. */
  std::int32_t
  squash(std::int32_t number) const
  {
    if (number > largest)
      number = largest;
    if (number < -largest)
      number = -largest;
    return squash_[static_cast<std::size_t>(number + largest)];
  }

  /** \brief ln(p / (1 - p)), in units of 1/256, of a probability p in units of
   * 2^-16. */
  std::int32_t
  stretch(std::uint32_t probability) const
  {
    return stretch_[probability >> 4];
  }

private:
  std::array<std::int32_t, 2 * largest + 1> squash_;
  std::array<std::int16_t, 4096> stretch_;
};

/** \brief The tables, made at the first call. */
const LogisticTables&
logisticTables();

// Mixing of several probabilities of one bit into one: a weighted sum on the logistic
// scale with weights that adapt to every bit (M. Mahoney, Adaptive weighing of context
// models for lossless data compression, 2005). Weights are in units of 2^-16.

/** \brief Weight of each of a number of ways at the start; their sum is 1.2. */
constexpr std::int32_t
startingWeight(std::size_t ways)
{
  return (6 << 16) / (5 * static_cast<std::int32_t>(ways));
}

/** \brief The mixed number on the logistic scale. */
template <std::size_t WayCount>
PCL_EXT_ALWAYS_INLINE std::int32_t
mix(const std::int32_t* weights, const std::array<std::int32_t, WayCount>& stretched)
{
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < WayCount; ++i)
    sum += std::int64_t{weights[i]} * stretched[i];
  return static_cast<std::int32_t>(sum >> 16);
}

/** \brief Adapts weights to a bit.
 * \param[in] stretched the inputs
 * \param[in] error bit - probability, in units of 2^-16
 */
template <std::size_t WayCount>
PCL_EXT_ALWAYS_INLINE void
adaptWeights(std::int32_t* weights,
             const std::array<std::int32_t, WayCount>& stretched,
             std::int32_t error)
{
  // Clamped so that no sum overflows for any sequence of bits.
  constexpr std::int32_t heaviest = 8 << 16;
  for (std::size_t i = 0; i < WayCount; ++i)
    weights[i] = std::clamp(
        weights[i] + ((stretched[i] * error + (1 << 14)) >> 15), -heaviest, heaviest);
}

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

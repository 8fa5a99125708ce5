// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Random numbers that are the same on all machines.
 */
#pragma once

#include <algorithm>
#include <cstdint>

namespace pcl_ext {
namespace cell {

/** \brief A pseudo-random number made of numbers; the same on all machines. */
std::uint32_t
mixSeeds(std::uint32_t a, std::uint32_t b, std::uint32_t c = 0);

/** \brief The threshold that 32 random bits are below with a probability. */
inline std::uint32_t
asThreshold(double probability)
{
  constexpr double two_to_32 = 4294967296.0;
  return static_cast<std::uint32_t>(
      std::min(two_to_32 - 1.0, std::max(0.0, probability) * two_to_32));
}

/** \brief 32 bits as a number of 0 to 1. */
inline double
asShare(std::uint32_t bits)
{
  return bits / 4294967296.0;
}

} // namespace cell
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Bands of the distance from a sensor, four for each doubling, in which the
 * temporal filter learns what is usual. */
constexpr std::size_t distance_band_count = 64;

/** \brief The band of a distance.
 * \param[in] distance squared, in voxels; 0 without a sensor */
inline std::size_t
distanceBand(std::uint64_t distance)
{
  const auto bounded = static_cast<std::uint32_t>(
      std::clamp(distance, std::uint64_t{2}, std::uint64_t{0xffffffff}));
  const unsigned int highest = highestBit(bounded);
  return 2 * highest + (bounded >> (highest - 1) & 1);
}

} // namespace pcl_ext::PCL_EXT_ABI

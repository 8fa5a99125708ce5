// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/point_period.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Sensors have at most so many lasers. */
constexpr std::size_t longest_period = 256;

/** \brief Octaves of the distance of two points, on all axes: about the bits it takes. */
double
bitsBetween(const std::array<double, 3>& a, const std::array<double, 3>& b, double edge)
{
  double bits = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    bits += std::log2(1.0 + std::abs(a[axis] - b[axis]) / edge);
  return bits;
}

} // namespace

std::uint32_t
findPointPeriod(const std::vector<std::array<double, 3>>& positions, double edge)
{
  constexpr std::size_t samples = 128;
  constexpr double least_gain = 1.0; // bits of a point
  if (positions.size() < 2 * longest_period)
    return 0;
  std::vector<double> bits(longest_period + 1);
  for (std::size_t sample = 0; sample < samples; ++sample) {
    const std::size_t point =
        longest_period + sample * (positions.size() - longest_period) / samples;
    for (std::size_t period = 1; period <= longest_period; ++period)
      bits[period] += bitsBetween(positions[point], positions[point - period], edge);
  }
  const auto best = std::min_element(bits.begin() + 1, bits.end());
  return *best + least_gain * samples < bits[1]
             ? static_cast<std::uint32_t>(best - bits.begin())
             : 0;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

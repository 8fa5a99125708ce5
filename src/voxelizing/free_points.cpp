// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/free_points.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Sensors have at most so many lasers. */
constexpr std::size_t longest_period = 256;

/** \brief Two to the power of about the bits that the distance of two points takes. */
double
sizeBetween(const std::array<double, 3>& a,
            const std::array<double, 3>& b,
            double per_metre)
{
  double size = 1.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    size *= 1.0 + std::abs(a[axis] - b[axis]) * per_metre;
  return size;
}

/** \brief The fraction of an edge that whole edges are to be added to, so that numbers
 * rounded to the nearest of these are off by as much above as below. Numbers on a grid of
 * an edge, or of a part of one, would be on ties between two of them otherwise.
 * \param[in] numbers edges
 * \return 0 to below 1; of several the one nearest to 1/2
 */
double
coordinatePhase(const std::vector<double>& numbers)
{
  constexpr double middle = 0.5;
  constexpr int most_parts = 10; // of more, ties are few
  for (int parts = 1; parts <= most_parts; ++parts) {
    const double part = 1.0 / parts;
    double offset = 0.0;
    if (!(coherence(numbers, part, offset) > 0.99)) // also if it is no number
      continue;
    // Amid two numbers, where they would be ties else.
    const double phase = parts % 2 == 0 ? offset + part / 2.0 : offset;
    const double nearest = phase + std::round((middle - phase) / part) * part;
    return nearest - std::floor(nearest);
  }
  return middle;
}

} // namespace

std::uint32_t
findPointPeriod(const std::vector<std::array<double, 3>>& positions, double edge)
{
  constexpr std::size_t samples = 128;
  constexpr std::size_t samples_at_once = 8; // whose product is a number
  constexpr double least_gain = 1.0;         // bits of a point
  if (positions.size() < 2 * longest_period)
    return 0;
  std::vector<double> bits(longest_period + 1);
  std::vector<double> sizes(longest_period + 1, 1.0);
  for (std::size_t sample = 0; sample < samples; ++sample) {
    const std::size_t point =
        longest_period + sample * (positions.size() - longest_period) / samples;
    for (std::size_t period = 1; period <= longest_period; ++period)
      sizes[period] *=
          sizeBetween(positions[point], positions[point - period], 1.0 / edge);
    if (sample % samples_at_once == samples_at_once - 1)
      for (std::size_t period = 1; period <= longest_period; ++period)
        bits[period] += std::log2(std::exchange(sizes[period], 1.0));
  }
  const auto best = std::min_element(bits.begin() + 1, bits.end());
  return *best + least_gain * samples < bits[1]
             ? static_cast<std::uint32_t>(best - bits.begin())
             : 0;
}

std::array<double, 3>
findPhases(const std::vector<std::array<double, 3>>& positions, const VoxelGrid& grid)
{
  constexpr std::size_t enough = 512;
  std::array<double, 3> phases;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> edges;
    for (std::size_t point = 0; point < positions.size(); ++point) {
      if (!isChosen(point, positions.size(), enough))
        continue;
      const double number =
          (positions[point][axis] - grid.lowerCorner(axis)) / grid.resolution;
      if (std::abs(number) < 0x1p26) // a scan reaches no further
        edges.push_back(number);
    }
    phases[axis] = coordinatePhase(edges);
  }
  return phases;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

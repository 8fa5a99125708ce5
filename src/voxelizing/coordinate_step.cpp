// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/coordinate_step.h"

#include "voxelizing/point_batches.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

enum class Match { Some, All, NoPoints };

/** \brief Whether the finite coordinates are multiples of a step. Ends at the first
 * point that has another one.
 * \param[in] points the cloud
 * \param[in] step metres
 * \param[in] tolerance metres
 * \param[in] most_multiples, middle see findCoordinateStep()
 */
Match
matchMultiples(PointBatches& points,
               double step,
               double tolerance,
               double most_multiples,
               const std::array<double, 3>& middle)
{
  const double inverse = 1.0 / step;
  const double tolerated = tolerance / step;
  // Adding it rounds a number below 2^51 to the nearest whole one.
  constexpr double rounding = 0x1.8p52;
  Match result = Match::NoPoints;
  PointView view;
  const auto are_multiples = [&](const auto* point) {
    for (std::size_t i = 0; i < view.count;
         ++i, point = detail::atOffset(point, view.coordinate_stride)) {
      if (!isFinite(point))
        continue;
      result = Match::All;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double steps = static_cast<double>(point[axis]) * inverse;
        if (!(std::abs(steps - middle[axis] * inverse) < most_multiples &&
              std::abs(steps - ((steps + rounding) - rounding)) <= tolerated))
          return false;
      }
    }
    return true;
  };
  points.restart();
  while (points.next(view))
    if (!(view.double_coordinates != nullptr ? are_multiples(view.double_coordinates)
                                             : are_multiples(view.coordinates)))
      return Match::Some;
  return result;
}

} // namespace

std::array<double, 3>
anyPoint(PointBatches& points)
{
  std::array<double, 3> any{};
  bool is_found = false;
  const auto look_at = [&](const auto* point) {
    if (is_found || !isFinite(point))
      return;
    is_found = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      any[axis] = static_cast<double>(point[axis]);
  };
  points.restart();
  for (PointView view; !is_found && points.next(view);)
    visitPoints(view, look_at);
  return any;
}

double
findCoordinateStep(PointBatches& points,
                   double resolution,
                   bool may_be_larger,
                   double largest,
                   double most_multiples,
                   const std::array<double, 3>& middle)
{
  constexpr std::array<double, 10> larger_steps = {
      0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001};
  const auto match_or_none = [&](double step, double tolerance) {
    const Match match =
        step > largest
            ? Match::Some
            : matchMultiples(points, step, tolerance, most_multiples, middle);
    return match == Match::NoPoints ? std::numeric_limits<double>::quiet_NaN()
           : match == Match::All    ? step
                                    : 0.0;
  };
  for (const double larger : larger_steps) {
    if (!may_be_larger || larger < 2.0 * resolution)
      break;
    const double step = match_or_none(larger, resolution / 4.0);
    if (step != 0.0) // also NaN
      return step;
  }
  // More exactly, as a few points anywhere may be near multiples of a small step.
  return match_or_none(resolution, resolution / 16.0);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ray_fit.h"
#include "voxelizing/robust_fit.h"

#include <cmath>
#include <limits>
#include <vector>

namespace pcl_ext {
namespace io {

namespace {

/** \brief A camera's rays, its depth being along an axis.
 * \param[in] sign 1, or -1 for the other direction of the axis
 * \param[out] error median, metres
 */
FittedRays
fitPlanarRays(const std::vector<PixelPoint>& points,
              int axis,
              double sign,
              double& error)
{
  FittedRays rays;
  std::vector<Eigen::Vector3d> features;
  std::vector<double> depths;
  for (const PixelPoint& point : points) {
    features.push_back({1.0, double(point.column), double(point.row)});
    depths.push_back(sign * point.position[axis]);
  }
  error = 0.0;
  rays.plane(axis, 0) = sign;
  for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
    std::vector<double> slopes;
    for (const PixelPoint& point : points)
      slopes.push_back(point.position[other] / (sign * point.position[axis]));
    double slope_error = 0.0;
    rays.plane.row(other) = fitRobustly(features, slopes, slope_error).transpose();
    error += slope_error;
  }
  error *= medianSize(depths);
  return rays;
}

} // namespace

std::optional<FittedRays>
fitPlanarRays(const std::vector<PixelPoint>& points)
{
  std::optional<FittedRays> best;
  double best_error = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 == 0 ? 1.0 : -1.0;
    std::vector<PixelPoint> ahead;
    for (const PixelPoint& point : points)
      if (sign * point.position[axis] > 0.0)
        ahead.push_back(point);
    if (ahead.size() < 16 || 10 * ahead.size() < 9 * points.size())
      continue;
    double error = 0.0;
    FittedRays rays = fitPlanarRays(ahead, axis, sign, error);
    if (!(error < best_error))
      continue;
    best_error = error;
    std::vector<double> depths;
    for (const PixelPoint& point : ahead)
      depths.push_back(sign * point.position[axis]);
    for (const double step : depth_steps) {
      double offset = 0.0;
      if (coherence(depths, step, offset) > least_coherence &&
          std::abs(offset) < 0.05 * step) {
        rays.depth_step = step;
        break;
      }
    }
    best = rays;
  }
  return best;
}

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ray_fit.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

namespace {

/** \brief A point of a row of a spinning sensor. */
struct RowPoint {
  std::uint32_t column;
  double azimuth;
  double distance; // from the axis
  double height;
};

/** \brief Leaves some of a row's points out, where more would only take time. Pairs of
 * neighbours stay, which the angle between columns is found by. */
void
thinOut(std::vector<RowPoint>& row)
{
  constexpr std::size_t enough_pairs = 32;
  const std::size_t every = row.size() / 2 / enough_pairs;
  if (every < 2)
    return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (i / 2 % every == 0)
      row[kept++] = row[i];
  row.resize(kept);
}

/** \brief The angle between neighbouring columns. */
double
fitTurn(const std::vector<std::vector<RowPoint>>& rows, std::uint32_t width)
{
  std::vector<double> slopes;
  for (const auto& row : rows)
    for (std::size_t i = 1; i < row.size(); ++i)
      if (row[i].column == row[i - 1].column + 1)
        slopes.push_back(std::remainder(row[i].azimuth - row[i - 1].azimuth, two_pi));
  if (slopes.empty())
    return 0.0;
  std::nth_element(slopes.begin(),
                   slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2),
                   slopes.end());
  const double slope = slopes[slopes.size() / 2];
  // Most turn once.
  const double whole = std::copysign(two_pi / width, slope);
  return std::abs(slope - whole) < 0.1 * std::abs(whole) ? whole : slope;
}

/** \brief Fits a row but for where its depths begin.
 * \param[in] turn of a column
 */
FittedRays::Row
fitRow(const std::vector<RowPoint>& points, double turn)
{
  FittedRays::Row row;
  std::vector<Eigen::Vector2d> features;
  std::vector<double> heights;
  std::complex<double> sum;
  for (const RowPoint& point : points) {
    features.push_back({1.0, point.distance});
    heights.push_back(point.height);
    sum += std::polar(1.0, point.azimuth - turn * point.column);
  }
  double error = 0.0;
  const Eigen::Vector2d line = fitRobustly(features, heights, error);
  const double length = std::hypot(1.0, line[1]);
  row.up = line[0];
  row.run = 1.0 / length;
  row.rise = line[1] / length;
  const double middle = std::arg(sum);
  features.clear();
  std::vector<double> angles;
  for (const RowPoint& point : points) {
    features.push_back({1.0, 1.0 / point.distance});
    angles.push_back(
        std::remainder(point.azimuth - turn * point.column - middle, two_pi));
  }
  const Eigen::Vector2d angle = fitRobustly(features, angles, error);
  row.angle = middle + angle[0];
  row.across = angle[1];
  return row;
}

/** \brief The depths of a row from where its line begins. */
std::vector<double>
depthsOf(const std::vector<RowPoint>& points, const FittedRays::Row& row)
{
  std::vector<double> depths;
  for (const RowPoint& point : points)
    depths.push_back(point.distance * row.run + (point.height - row.up) * row.rise);
  return depths;
}

/** \brief Finds the distance of depths, and moves the begin of each row to one. */
void
fitDepthSteps(const std::vector<std::vector<RowPoint>>& points, FittedRays& rays)
{
  for (const double step : depth_steps) {
    double sum = 0.0;
    double count = 0.0;
    std::vector<double> offsets(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto size = static_cast<double>(points[i].size());
      sum += size * coherence(depthsOf(points[i], rays.rows[i]), step, offsets[i]);
      count += size;
    }
    if (sum < least_coherence * count)
      continue;
    rays.depth_step = step;
    for (std::size_t i = 0; i < points.size(); ++i) {
      rays.rows[i].along += offsets[i] * rays.rows[i].run;
      rays.rows[i].up += offsets[i] * rays.rows[i].rise;
    }
    return;
  }
}

} // namespace

std::optional<FittedRays>
fitSpinningRays(const std::vector<PixelPoint>& points,
                const ImageSize& size,
                const std::optional<double>& turn)
{
  if (size.width < 2)
    return std::nullopt;
  std::vector<std::vector<RowPoint>> rows(size.height);
  for (const PixelPoint& point : points) {
    const double x = point.position.x();
    const double y = point.position.y();
    if (const double distance = std::hypot(x, y); distance > 0.0)
      rows[point.row].push_back(
          {point.column, std::atan2(y, x), distance, point.position.z()});
  }
  FittedRays rays;
  rays.shape = scan::RayShape::Spinning;
  for (std::vector<RowPoint>& row : rows)
    thinOut(row);
  rays.turn = turn ? *turn : fitTurn(rows, size.width);
  constexpr std::size_t least_points = 16;
  std::size_t last = size.height;
  for (std::uint32_t i = 0; i < size.height; ++i) {
    if (rows[i].size() >= least_points) {
      const FittedRays::Row row = fitRow(rows[i], rays.turn);
      // Rows with few points have the rays of the nearest one.
      if (last == size.height)
        rays.rows.assign(i, row);
      last = i;
      rays.rows.push_back(row);
    }
    else if (last != size.height)
      rays.rows.push_back(rays.rows[last]);
  }
  if (last == size.height)
    return std::nullopt;
  fitDepthSteps(rows, rays);
  return rays;
}

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ray_fit.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Whether the depths of a scan are those that the sensor has itself. */
bool
isStepKept(double fitted_step, double resolution)
{
  return fitted_step >= 0.45 * resolution;
}

/** \brief Step of depths, metres; 0: they have none. */
double
stepOf(const std::vector<double>& depths)
{
  for (const double step : depth_steps) {
    double offset = 0.0;
    if (coherence(depths, step, offset) > least_coherence &&
        std::abs(offset) < 0.05 * step)
      return step;
  }
  return 0.0;
}

/** \brief A camera's rays, its depth being along an axis.
 * \param[in] sign 1, or -1 for the other direction of the axis
 * \param[out] error median, metres
 */
PlanarFit
fitPlanar(const std::vector<PixelPoint>& points, int axis, double sign, double& error)
{
  PlanarFit rays;
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
  rays.depth_step = stepOf(depths);
  error *= medianSize(depths);
  return rays;
}

/** \brief Gives column, row and 1, times the depth, of a position whose last coordinate
 * is 1. */
using Projection = Eigen::Matrix<double, 3, 4>;

/** \brief A point and where it is in the image. */
struct ProjectedPoint {
  Eigen::Vector4d position; ///< the last coordinate is 1
  Eigen::Vector2d image;    ///< column and row
};

/** \brief The projection that is best for the points with errors of at most some size. */
Projection
fitProjection(const std::vector<ProjectedPoint>& points,
              const std::vector<double>& errors,
              double most)
{
  Eigen::Matrix<double, 12, 12> squares = Eigen::Matrix<double, 12, 12>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(errors[i] <= most))
      continue;
    const auto& [position, image] = points[i];
    Eigen::Matrix<double, 12, 2> equations;
    equations << position, Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero(), position,
        -image.x() * position, -image.y() * position;
    squares += equations * equations.transpose();
  }
  const SymmetricEigen eigen(squares);
  return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(
      eigen.vectors.data()); // of the smallest eigenvalue
}

/** \brief The rays of a projection, unless points are behind it. */
std::optional<PlanarFit>
raysOf(Projection projection, const std::vector<PixelPoint>& points)
{
  const double length = projection.block<1, 3>(2, 0).norm();
  projection /= length;
  std::vector<double> depths;
  std::ptrdiff_t ahead = 0;
  for (const PixelPoint& point : points) {
    depths.push_back(projection.row(2).dot(point.position.homogeneous()));
    ahead += depths.back() > 0.0 ? 1 : -1;
  }
  if (ahead < 0) {
    projection = -projection;
    for (double& depth : depths)
      depth = -depth;
  }
  Eigen::Matrix3d directions;
  bool has_directions = false;
  projection.leftCols<3>().computeInverseWithCheck(directions, has_directions);
  if (!has_directions || !projection.allFinite() || !directions.allFinite() ||
      5 * std::abs(ahead) < 4 * static_cast<std::ptrdiff_t>(points.size()))
    return std::nullopt;
  PlanarFit rays;
  rays.origin = -directions * projection.col(3);
  rays.plane << directions.col(2), directions.col(0), directions.col(1);
  rays.depth_step = stepOf(depths);
  return rays;
}

} // namespace

std::optional<PlanarFit>
fitPlanar(const std::vector<PixelPoint>& points)
{
  std::optional<PlanarFit> best;
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
    const PlanarFit rays = fitPlanar(ahead, axis, sign, error);
    if (error < best_error) {
      best_error = error;
      best = rays;
    }
  }
  return best;
}

std::optional<PlanarFit>
fitPlanarAnywhere(const std::vector<PixelPoint>& points)
{
  constexpr std::size_t least_points = 64;
  if (points.size() < least_points)
    return std::nullopt;
  // Numbers about 1, as the equations are of squares.
  const Extent extent(points);
  if (!(extent.mean_distance > 0.0))
    return std::nullopt;
  double pixels = 1.0;
  for (const PixelPoint& point : points)
    pixels = std::max({pixels, double(point.column), double(point.row)});
  std::vector<ProjectedPoint> projected;
  for (const PixelPoint& point : points)
    projected.push_back(
        {((point.position - extent.middle) / extent.mean_distance).homogeneous(),
         {point.column / pixels, point.row / pixels}});
  Projection projection;
  std::vector<double> errors(points.size());
  double most = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 4; ++round) {
    projection = fitProjection(projected, errors, most);
    for (std::size_t i = 0; i < errors.size(); ++i)
      errors[i] = finiteOrLargest(
          ((projection * projected[i].position).hnormalized() - projected[i].image)
              .norm());
    std::vector<double> sizes = errors;
    most = 4.0 * medianSize(sizes);
  }
  projection.topRows<2>() *= pixels;
  projection.leftCols<3>() /= extent.mean_distance;
  projection.col(3) -= projection.leftCols<3>() * extent.middle;
  return raysOf(projection, points);
}

double
depthStepFor(double fitted_step, double resolution)
{
  double step = isStepKept(fitted_step, resolution) ? fitted_step : resolution;
  while (step > 16.0 * resolution)
    step /= 2.0;
  return step;
}

PlanarDepths
chooseDepths(const std::vector<PixelPoint>& points,
             const WorldPose& sensor_pose,
             double resolution,
             const PlanarFit& fit)
{
  PlanarDepths chosen;
  if (isStepKept(fit.depth_step, resolution))
    return chosen;
  const auto bits_of_point = [&](const PlanarDepths& depths) {
    std::size_t beside = 0;
    for (const PixelPoint& point : points) {
      const Eigen::Vector3d step = depths.edges * resolution * fit.plane *
                                   Eigen::Vector3d(1.0, point.column, point.row);
      const Eigen::Vector3d from_origin = point.position - fit.origin;
      const double depth = from_origin.dot(step) / step.squaredNorm();
      const double nearest =
          depths.has_half_depths ? std::floor(depth) + 0.5 : std::round(depth);
      const Eigen::Vector3d error =
          sensor_pose.linear() * (from_origin - nearest * step);
      beside += error.cwiseAbs().maxCoeff() > 0.5 * resolution ? 1 : 0;
    }
    // Some more than ten bits for each, as measured.
    return 10.0 * static_cast<double>(beside) / static_cast<double>(points.size()) -
           std::log2(depths.edges);
  };
  // Others have to save more, as these are amid the voxels of a camera along an axis.
  constexpr double least_saved = 0.05;
  double fewest = bits_of_point(chosen) - least_saved;
  for (const bool has_half_depths : {true, false})
    for (const double edges : {1.0, 0.95, 0.9, 0.8}) {
      const double bits = bits_of_point({edges, has_half_depths});
      if (bits < fewest) {
        fewest = bits;
        chosen = {edges, has_half_depths};
      }
    }
  return chosen;
}

bool
setPlanarRays(const PlanarFit& fit,
              const WorldPose& sensor_pose,
              const VoxelGrid& grid,
              scan::ScanLayout& layout)
{
  scan::ScanRays& rays = layout.rays;
  rays = scan::ScanRays();
  const bool is_kept = isStepKept(fit.depth_step, grid.resolution);
  const double step = depthStepFor(fit.depth_step, grid.resolution) *
                      (is_kept ? 1.0 : fit.depths.edges);
  rays.has_half_depths =
      !layout.is_on_lattice && !is_kept && fit.depths.has_half_depths;
  const Eigen::Matrix3d plane =
      sensor_pose.linear() * fit.plane * (step / grid.resolution * 0x1p40);
  const Eigen::Vector3d origin = sensor_pose * fit.origin;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<int>(axis);
    const double from_corner = origin[row] - grid.lowerCorner(axis);
    rays.pose.origin[axis] = fixedPoint(from_corner / grid.resolution, 16, 0x1p42);
    for (std::size_t i = 0; i < 3; ++i)
      rays.pose.vectors[i][axis] =
          fixedPoint(plane(row, static_cast<int>(i)), 0, 0x1p46);
  }
  return isConsistent(layout);
}

double
distanceFromRays(const std::vector<PixelPoint>& points,
                 const WorldPose& pose,
                 const VoxelGrid& grid,
                 const scan::ScanLayout& layout)
{
  scan::ScanRayReader reader(layout.rays);
  std::vector<double> distances;
  for (const PixelPoint& point : points) {
    reader.moveTo(point.row);
    const scan::Ray ray = reader.at(point.column, 0);
    Eigen::Vector3d offset = pose * point.position;
    Eigen::Vector3d step;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<int>(axis);
      offset[i] = (offset[i] - grid.lowerCorner(axis)) / grid.resolution -
                  0x1p-32 * static_cast<double>(ray.start[axis]);
      step[i] = 0x1p-32 * static_cast<double>(ray.step[axis]);
    }
    distances.push_back(
        finiteOrLargest(offset.cross(step).norm() / std::max(step.norm(), 1e-9)));
  }
  return distances.empty() ? 0.0 : medianSize(distances);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

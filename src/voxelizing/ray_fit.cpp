// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ray_fit.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace io {

namespace {

/** \brief A number as an integer of some units, within a range; 0 for NaN. */
std::int64_t
fixed(double number, double unit, double most)
{
  const double units = std::round(number * unit);
  return std::isnan(units) ? 0
                           : static_cast<std::int64_t>(std::clamp(units, -most, most));
}

/** \brief The same for the numbers of a spinning sensor. */
std::int32_t
fixed(double number, double unit)
{
  return static_cast<std::int32_t>(fixed(number, unit, 0x1p30));
}

constexpr double of_directions = 0x1p30;
constexpr double of_steps = 0x1p24;
constexpr double of_places = 0x1p16;
constexpr double of_planes = 0x1p40;

void
setSpinning(const FittedRays& fitted,
            const WorldPose& pose,
            double resolution,
            double step,
            scan::ScanLayout& layout)
{
  scan::ScanRays& rays = layout.rays;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 3; ++i)
      rays.pose.vectors[static_cast<std::size_t>(axis)][static_cast<std::size_t>(i)] =
          fixed(pose.linear()(i, axis), of_directions);
  for (std::uint32_t column = 1; column < 2 * layout.width; column *= 2) {
    const double angle = column * fitted.turn;
    rays.turns.push_back(
        {fixed(std::cos(angle), of_directions), fixed(std::sin(angle), of_directions)});
  }
  rays.columns.resize(layout.width);
  std::iota(rays.columns.begin(), rays.columns.end(), 0);
  for (const FittedRays::Row& row : fitted.rows)
    rays.rows.push_back({fixed(std::cos(row.angle), of_directions),
                         fixed(std::sin(row.angle), of_directions),
                         fixed(row.run * step / resolution, of_steps),
                         fixed(row.rise * step / resolution, of_steps),
                         fixed(row.along / resolution, of_places),
                         fixed(row.across / resolution, of_places),
                         fixed(row.up / resolution, of_places)});
}

/** \brief Median distance of points from the rays of their pixels, edges.
 * \param[in] points in the coordinates of the sensor; of none it is 0
 * \param[in] pose sensor -> grid, metres
 * \param[in] layout isConsistent(); its rays
 */
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

} // namespace

double
depthStepFor(double fitted_step, double resolution)
{
  double step = fitted_step < 0.45 * resolution ? resolution : fitted_step;
  while (step > 16.0 * resolution)
    step /= 2.0;
  return step;
}

bool
setRays(const FittedRays& fitted,
        const WorldPose& sensor_pose,
        const VoxelGrid& grid,
        scan::ScanLayout& layout)
{
  scan::ScanRays& rays = layout.rays;
  rays = scan::ScanRays();
  rays.shape = fitted.shape;
  const double step = depthStepFor(fitted.depth_step, grid.resolution);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double from_corner =
        sensor_pose.translation()[static_cast<int>(axis)] - grid.lowerCorner(axis);
    rays.pose.origin[axis] = fixed(from_corner / grid.resolution, of_places, 0x1p42);
  }
  if (fitted.shape == scan::RayShape::Spinning) {
    setSpinning(fitted, sensor_pose, grid.resolution, step, layout);
    return isConsistent(layout);
  }
  const Eigen::Matrix3d plane =
      sensor_pose.linear() * fitted.plane * (step / grid.resolution * of_planes);
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis)
      rays.pose.vectors[static_cast<std::size_t>(i)][static_cast<std::size_t>(axis)] =
          fixed(plane(axis, i), 1.0, 0x1p46);
  return isConsistent(layout);
}

std::optional<FittedRays>
fitRays(const std::vector<PixelPoint>& points,
        const WorldPose& sensor_pose,
        const VoxelGrid& grid,
        const ImageSize& size)
{
  // A camera has few numbers to fit.
  constexpr std::size_t enough = 2048;
  std::vector<PixelPoint> sample;
  const std::size_t every = points.size() / enough + 1;
  for (std::size_t i = 0; i < points.size(); i += every)
    sample.push_back(points[i]);
  double best_distance = std::numeric_limits<double>::infinity();
  std::optional<FittedRays> best;
  const auto use = [&](const std::optional<FittedRays>& fitted) {
    scan::ScanLayout layout;
    layout.width = size.width;
    layout.height = size.height;
    if (!fitted || !setRays(*fitted, sensor_pose, grid, layout))
      return;
    const double distance = distanceFromRays(sample, sensor_pose, grid, layout);
    if (distance < best_distance) {
      best_distance = distance;
      best = fitted;
    }
  };
  use(fitPlanarRays(sample));
  constexpr double near = 0.25;
  if (best_distance > near)
    use(fitSpinningRays(points, size, std::nullopt));
  return best;
}

} // namespace io
} // namespace pcl_ext

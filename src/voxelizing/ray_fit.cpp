// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/ray_fit.h"

#include "voxelizing/robust_fit.h"
#include "voxels/rays.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
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
            PointImage& image)
{
  RayModel& rays = image.rays;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 3; ++i)
      rays.pose.vectors[static_cast<std::size_t>(axis)][static_cast<std::size_t>(i)] =
          fixed(pose.linear()(i, axis), of_directions);
  for (unsigned int bit = 0; bit < columnBits(image.width); ++bit) {
    const double angle = std::ldexp(fitted.turn, static_cast<int>(bit));
    rays.turns.push_back(
        {fixed(std::cos(angle), of_directions), fixed(std::sin(angle), of_directions)});
  }
  for (const FittedRays::Row& row : fitted.rows)
    rays.rows.push_back({fixed(std::cos(row.angle), of_directions),
                         fixed(std::sin(row.angle), of_directions),
                         fixed(row.run * step / resolution, of_steps),
                         fixed(row.rise * step / resolution, of_steps),
                         fixed(row.along / resolution, of_places),
                         fixed(row.across / resolution, of_places),
                         fixed(row.up / resolution, of_places)});
}

} // namespace

double
distanceFromRays(const std::vector<PixelPoint>& points,
                 const WorldPose& pose,
                 const VoxelGrid& grid,
                 const PointImage& image)
{
  RayReader reader(image);
  std::vector<double> distances;
  for (const PixelPoint& point : points) {
    reader.moveTo(point.row);
    const Ray ray = reader.at(point.column);
    Eigen::Vector3d offset = pose * point.position;
    Eigen::Vector3d step;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<int>(axis);
      offset[i] = (offset[i] - grid.origin[axis]) / grid.resolution -
                  static_cast<double>(grid.first_index[axis]) -
                  0x1p-32 * static_cast<double>(ray.start[axis]);
      step[i] = 0x1p-32 * static_cast<double>(ray.step[axis]);
    }
    distances.push_back(
        finiteOrLargest(offset.cross(step).norm() / std::max(step.norm(), 1e-9)));
  }
  return distances.empty() ? 0.0 : medianSize(distances);
}

bool
setRays(const FittedRays& fitted,
        const WorldPose& sensor_pose,
        const VoxelGrid& grid,
        PointImage& image)
{
  RayModel& rays = image.rays;
  rays = RayModel();
  rays.shape = fitted.shape;
  // Much finer steps than voxels take bits, and nobody sees them.
  rays.has_half_steps = fitted.depth_step < 0.45 * grid.resolution;
  double step = rays.has_half_steps ? grid.resolution : fitted.depth_step;
  while (step > 32.0 * grid.resolution) // as steps have no more than 64 voxels
    step /= 2.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double from_corner =
        sensor_pose.translation()[static_cast<int>(axis)] - grid.lowerCorner(axis);
    rays.pose.origin[axis] = fixed(from_corner / grid.resolution, of_places, 0x1p38);
  }
  if (fitted.shape == RayShape::Spinning) {
    setSpinning(fitted, sensor_pose, grid.resolution, step, image);
    return isConsistent(image);
  }
  const Eigen::Matrix3d plane =
      sensor_pose.linear() * fitted.plane * (step / grid.resolution * of_planes);
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis)
      rays.pose.vectors[static_cast<std::size_t>(i)][static_cast<std::size_t>(axis)] =
          fixed(plane(axis, i), 1.0, 0x1p46);
  return isConsistent(image);
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
    PointImage image;
    image.width = size.width;
    image.height = size.height;
    if (!fitted || !setRays(*fitted, sensor_pose, grid, image))
      return;
    const double distance = distanceFromRays(sample, sensor_pose, grid, image);
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

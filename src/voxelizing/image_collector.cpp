// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/image_collector.h"

#include "voxelizing/ring_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace pcl_ext {
namespace io {

bool
ImageCollector::begin(const PointBatches& points,
                      const WorldPose& sensor_pose,
                      std::uint64_t most_pixels)
{
  size_ = points.imageSize();
  most_pixels_ = most_pixels;
  ring_.reset();
  has_other_ring_ = false;
  // One row or column is no image.
  if (size_.width <= 1 || size_.height <= 1)
    ring_ = findRing(points.fields());
  from_sensor_ = sensor_pose;
  to_sensor_ = sensor_pose.inverse();
  points_.clear();
  points_.reserve(points.size());
  return ring_ || (size_.width > 1 && size_.height > 1 &&
                   size_.width <= most_image_side && size_.height <= most_image_side &&
                   std::uint64_t{size_.width} * size_.height <= most_pixels);
}

void
ImageCollector::add(const PointView& points,
                    std::size_t first,
                    const LocatedPoints& located)
{
  std::optional<RingReader> rings;
  if (ring_)
    rings.emplace(points.fields[*ring_]);
  for (std::size_t i = 0; i < located.count; ++i) {
    const std::size_t point = located.points[i];
    const auto position = [&](const auto* numbers) {
      const auto* const x = detail::atOffset(numbers, point * points.coordinate_stride);
      return Eigen::Vector3d(static_cast<double>(x[0]),
                             static_cast<double>(x[1]),
                             static_cast<double>(x[2]));
    };
    points_.push_back({0,
                       0,
                       to_sensor_ * (points.double_coordinates != nullptr
                                         ? position(points.double_coordinates)
                                         : position(points.coordinates))});
    if (rings) {
      const std::uint32_t row = rings->row(point);
      has_other_ring_ = has_other_ring_ || row == most_image_side;
      points_.back().row = row;
      continue;
    }
    const std::size_t pixel =
        points.pixels != nullptr ? points.pixels[point] : first + point;
    points_.back().row = static_cast<std::uint32_t>(pixel / size_.width);
    points_.back().column = static_cast<std::uint32_t>(pixel % size_.width);
  }
}

bool
ImageCollector::fit(bool may_refit, const VoxelGrid& grid, PointImage& image)
{
  image = PointImage();
  double shift = 0.0;
  bool is_refitted = false;
  if (ring_ ? !setColumns(may_refit, shift, is_refitted) : !arePixels())
    return false;
  WorldPose pose = from_sensor_;
  if (shift != 0.0)
    pose.rotate(Eigen::AngleAxisd(shift, Eigen::Vector3d::UnitZ()));
  is_refitted = is_refitted || size_.width != rays_.width ||
                size_.height != rays_.height || rays_.is_organised == ring_.has_value();
  if (may_refit || is_refitted)
    rays_.has_points_at_sensor = arePointsAtSensor();
  if (!is_refitted && (grid != grid_ || pose.matrix() != pose_.matrix()))
    turnRays(grid, pose);
  if (is_refitted || (may_refit && !areAlongRays())) {
    fitRaysOfSize(grid, shift);
    turnRays(grid, pose);
    fitted_points_ = points_.size();
    fitted_distance_ = reader_ ? distanceFromRays() : 0.0;
  }
  if (reader_)
    image = rays_;
  return reader_.has_value();
}

/** \brief Sets the integers of the fitted rays.
 * \param[in] pose of the rays, sensor -> grid
 */
void
ImageCollector::turnRays(const VoxelGrid& grid, const WorldPose& pose)
{
  const bool has_points_at_sensor = rays_.has_points_at_sensor;
  reader_.reset();
  rays_ = PointImage();
  rays_.has_points_at_sensor = has_points_at_sensor;
  rays_.width = size_.width;
  rays_.height = size_.height;
  rays_.is_organised = !ring_;
  grid_ = grid;
  pose_ = pose;
  if (fitted_ && setRays(*fitted_, pose, grid, rays_))
    reader_.emplace(rays_);
}

/** \brief Whether there are many more points than columns and rays were fitted to, which
 * may then fit better. */
bool
ImageCollector::hasManyMorePoints() const
{
  return points_.size() > 2 * fitted_points_;
}

/** \brief Whether the points are as near to the rays as those that they were fitted
 * to. */
bool
ImageCollector::areAlongRays() const
{
  constexpr double tolerance = 1.1;
  constexpr double least = 1.0 / 64; // voxels
  return reader_ && !hasManyMorePoints() &&
         distanceFromRays() <= std::max(tolerance * fitted_distance_, least);
}

/** \brief Median distance of some points from their rays, voxels. */
double
ImageCollector::distanceFromRays() const
{
  constexpr std::size_t enough = 2048;
  std::vector<PixelPoint> sample;
  const std::size_t every = points_.size() / enough + 1;
  for (std::size_t i = 0; i < points_.size(); i += every)
    if (!isAtSensor(points_[i]))
      sample.push_back(points_[i]);
  return io::distanceFromRays(sample, from_sensor_, grid_, rays_);
}

/** \brief Whether so many points are at the sensor that they are missing ones. */
bool
ImageCollector::arePointsAtSensor() const
{
  constexpr std::ptrdiff_t share = 64;
  return share * std::count_if(points_.begin(), points_.end(), isAtSensor) >=
         static_cast<std::ptrdiff_t>(points_.size());
}

/** \brief Fits rays to the points that are not at the sensor.
 * \param[in] shift of their columns, radians, which turnRays() adds again
 */
void
ImageCollector::fitRaysOfSize(const VoxelGrid& grid, double shift)
{
  std::vector<PixelPoint> points;
  std::copy_if(points_.begin(),
               points_.end(),
               std::back_inserter(points),
               [](const PixelPoint& point) { return !isAtSensor(point); });
  if (points.empty())
    fitted_.reset();
  else if (ring_) {
    const Eigen::AngleAxisd back(-shift, Eigen::Vector3d::UnitZ());
    for (PixelPoint& point : points)
      point.position = back * point.position;
    fitted_ = fitSpinningRays(points, size_, ring_columns_.step());
  }
  else
    fitted_ = fitRays(points, from_sensor_, grid, size_);
}

/** \brief Whether all points have pixels of their own. */
bool
ImageCollector::arePixels()
{
  is_taken_.assign(std::size_t{size_.width} * size_.height, false);
  for (std::size_t point = 0; point < points_.size(); ++point) {
    if (points_[point].row >= size_.height || is_taken_[pixel(point)])
      return false;
    is_taken_[pixel(point)] = true;
  }
  return true;
}

/** \brief Finds the columns of points whose rows are known.
 * \param[out] shift of the columns, radians
 * \param[out] is_refitted set to true if columns are others than before
 * \return false if they are not in columns
 */
bool
ImageCollector::setColumns(bool may_refit, double& shift, bool& is_refitted)
{
  std::uint32_t rows = 0;
  for (const PixelPoint& point : points_)
    rows = std::max(rows, point.row + 1);
  if (has_other_ring_)
    return false;
  const auto assign = [&] {
    size_ = {ring_columns_.count(), ring_columns_.rows()};
    return ring_columns_.assign(points_, shift);
  };
  const bool may_keep = !may_refit || !hasManyMorePoints();
  // Rows without points are those of a sensor, too.
  if (may_keep && rows <= ring_columns_.rows() && assign() &&
      (!may_refit || ring_columns_.areAlike()))
    return true;
  is_refitted = true;
  return rows >= 2 && ring_columns_.fit(points_, rows, most_pixels_) && assign();
}

std::uint32_t
ImageCollector::depth(std::size_t point, std::uint64_t key)
{
  const VoxelPosition voxel = voxelPosition(key);
  if (rays_.has_points_at_sensor &&
      std::array<std::int64_t, 3>{voxel.x, voxel.y, voxel.z} ==
          sensorVoxel(rays_.rays.pose))
    return 0;
  reader_->moveTo(points_[point].row);
  const Ray ray = reader_->at(points_[point].column);
  const Eigen::Vector3d position = from_sensor_ * points_[point].position;
  double along = 0.0;
  double square = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double start = 0x1p-32 * static_cast<double>(ray.start[axis]);
    const double step = 0x1p-32 * static_cast<double>(ray.step[axis]);
    const double voxels =
        (position[static_cast<int>(axis)] - grid_.lowerCorner(axis)) / grid_.resolution;
    along += (voxels - start) * step;
    square += step * step;
  }
  constexpr double most = depth_end - 2;
  const double nearest = std::floor(along / square + 0.5);
  const auto first =
      static_cast<std::uint32_t>(nearest > 1.0 ? std::min(nearest, most) : 1.0);
  const auto is_in_voxel = [&](std::uint32_t depth) {
    return ray.at(depth, 0) >> 32 == voxel.x && ray.at(depth, 1) >> 32 == voxel.y &&
           ray.at(depth, 2) >> 32 == voxel.z;
  };
  // Of depths in the same voxel any is as good: the nearest one if it is in it.
  for (const std::uint32_t depth : {first, first - 1, first + 1})
    if (is_in_voxel(depth))
      return depth;
  return first;
}

void
ImageCollector::releaseMemory()
{
  points_ = std::vector<PixelPoint>();
  is_taken_ = std::vector<bool>();
  ring_columns_.releaseMemory();
}

} // namespace io
} // namespace pcl_ext

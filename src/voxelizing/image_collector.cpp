#include "voxelizing/image_collector.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace io {

void
ImageCollector::begin(const ImageSize& size, const WorldPose& sensor_pose)
{
  size_ = size;
  from_sensor_ = sensor_pose;
  to_sensor_ = sensor_pose.inverse();
  points_.clear();
}

void
ImageCollector::add(const PointView& points,
                    std::size_t first,
                    const LocatedPoints& located)
{
  for (std::size_t i = 0; i < located.count; ++i) {
    const std::size_t point = located.points[i];
    const std::size_t pixel =
        points.pixels != nullptr ? points.pixels[point] : first + point;
    const auto position = [&](const auto* numbers) {
      const auto* const x = detail::atOffset(numbers, point * points.coordinate_stride);
      return Eigen::Vector3d(static_cast<double>(x[0]),
                             static_cast<double>(x[1]),
                             static_cast<double>(x[2]));
    };
    points_.push_back({static_cast<std::uint32_t>(pixel / size_.width),
                       static_cast<std::uint32_t>(pixel % size_.width),
                       to_sensor_ * (points.double_coordinates != nullptr
                                         ? position(points.double_coordinates)
                                         : position(points.coordinates))});
  }
}

bool
ImageCollector::fit(bool may_refit, const VoxelGrid& grid, PointImage& image)
{
  image = PointImage();
  if (!arePixels())
    return false;
  const bool is_other_size = size_.width != rays_.width || size_.height != rays_.height;
  if (may_refit || is_other_size)
    fitted_ = fitRays(points_, from_sensor_, grid, size_);
  if (may_refit || is_other_size || grid != grid_ ||
      from_sensor_.matrix() != pose_.matrix()) {
    reader_.reset();
    rays_ = PointImage();
    rays_.width = size_.width;
    rays_.height = size_.height;
    grid_ = grid;
    pose_ = from_sensor_;
    if (fitted_ && setRays(*fitted_, from_sensor_, grid, rays_))
      reader_.emplace(rays_);
  }
  if (reader_)
    image = rays_;
  return reader_.has_value();
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

std::uint32_t
ImageCollector::depth(std::size_t point, std::uint64_t key)
{
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
  const VoxelPosition voxel = voxelPosition(key);
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

} // namespace io
} // namespace pcl_ext

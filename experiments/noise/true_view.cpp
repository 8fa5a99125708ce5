#include "true_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double wanted_edges_behind = 2.0;

const cell::RayGrid&
cameraRays()
{
  static const cell::RayGrid rays;
  return rays;
}

const cell::LidarRays&
lidarRays()
{
  static const cell::LidarRays rays;
  return rays;
}

/** \brief Where a ray leaves a cube, in lengths of its direction; negative if it does
 * not meet the cube.
 * \param[in] centre of the cube, from the ray's origin
 */
double
exitFromCube(const Eigen::Vector3d& direction,
             const Eigen::Vector3d& centre,
             double edge)
{
  double entry = 0.0;
  double exit = std::numeric_limits<double>::infinity();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double one = (centre[axis] - edge / 2.0) / direction[axis];
    const double other = (centre[axis] + edge / 2.0) / direction[axis];
    entry = std::max(entry, std::min(one, other));
    exit = std::min(exit, std::max(one, other));
  }
  return entry < exit ? exit : -1.0;
}

} // namespace

TrueView::TrueView(const Eigen::Isometry3d& pose, const cell::SurfaceImage& surfaces)
: pose_(pose)
, world_to_sensor_(pose.inverse())
, is_lidar_(surfaces.depth.size() == cell::LidarRays::size)
, depths_(surfaces.depth)
{}

TrueView::Pixels
TrueView::cameraPixels(const Eigen::Vector3d& centre, double edge) const
{
  const cell::RayGrid& rays = cameraRays();
  const double radius = 0.5 * std::sqrt(3.0) * edge;
  const double nearest = centre.z() - radius;
  if (nearest <= 0.0)
    return {};
  // The ball around the cube, and a pixel to spare; each ray is tested in any case.
  const auto range = [&](double at, double first, double step, std::size_t count) {
    const double low =
        std::min((at - radius) / nearest, (at - radius) / (centre.z() + radius));
    const double high =
        std::max((at + radius) / nearest, (at + radius) / (centre.z() + radius));
    const auto last = static_cast<double>(count) - 1.0;
    return std::pair(
        static_cast<long>(std::clamp(std::ceil((low - first) / step), 0.0, last + 1.0)),
        static_cast<long>(std::clamp(std::floor((high - first) / step), -1.0, last)));
  };
  const auto columns =
      range(centre.x(), rays.x(0), rays.x(1) - rays.x(0), cell::RayGrid::columns);
  const auto rows =
      range(centre.y(), rays.y(0), rays.y(1) - rays.y(0), cell::RayGrid::rows);
  return {rows.first, rows.second, columns.first, columns.second};
}

TrueView::Pixels
TrueView::lidarPixels(const Eigen::Vector3d& centre, double edge) const
{
  constexpr auto columns = static_cast<double>(cell::LidarRays::columns);
  constexpr auto last_ring = static_cast<double>(cell::LidarRays::rings) - 1.0;
  const double across = std::hypot(centre.x(), centre.y());
  const double radius = 0.5 * std::sqrt(3.0) * edge;
  if (across <= 2.0 * radius)
    return {};
  const double ring_step = 2.0 * pi / 180.0;
  const double ring = std::atan2(centre.z(), across) / ring_step + last_ring / 2.0;
  const double rings = std::asin(radius / centre.norm()) / ring_step;
  const double column = std::fmod(
      columns - std::atan2(centre.y(), centre.x()) / (2.0 * pi) * columns, columns);
  const double half_width = std::asin(radius / across) / (2.0 * pi) * columns;
  return {static_cast<long>(std::clamp(std::ceil(ring - rings), 0.0, last_ring + 1.0)),
          static_cast<long>(std::clamp(std::floor(ring + rings), -1.0, last_ring)),
          static_cast<long>(std::ceil(column - half_width + columns)),
          static_cast<long>(std::floor(column + half_width + columns))};
}

bool
TrueView::seesThrough(const io::VoxelGrid& grid, std::uint64_t key) const
{
  const double edge = grid.resolution;
  const Eigen::Vector3d centre = centreOf(grid, key);
  const Eigen::Vector3d from_sensor = centre - pose_.translation();
  const Eigen::Vector3d in_sensor = world_to_sensor_ * centre;
  const Pixels pixels =
      is_lidar_ ? lidarPixels(in_sensor, edge) : cameraPixels(in_sensor, edge);
  const auto columns =
      static_cast<long>(is_lidar_ ? cell::LidarRays::columns : cell::RayGrid::columns);
  bool is_met = false;
  for (long row = pixels.first_row; row <= pixels.last_row; ++row)
    for (long i = pixels.first_column; i <= pixels.last_column; ++i) {
      const long column = i % columns;
      const auto pixel = static_cast<std::size_t>(row * columns + column);
      const Eigen::Vector3d ray =
          is_lidar_ ? lidarRays().direction(pixel)
                    : Eigen::Vector3d(cameraRays().x(static_cast<std::size_t>(column)),
                                      cameraRays().y(static_cast<std::size_t>(row)),
                                      1.0);
      const double exit = exitFromCube(pose_.linear() * ray, from_sensor, edge);
      if (exit < 0.0)
        continue;
      is_met = true;
      const auto depth = static_cast<double>(depths_[pixel]);
      if (depth > 0.0 && (depth - exit) * ray.norm() <= wanted_edges_behind * edge)
        return false;
    }
  return is_met;
}

} // namespace noise
} // namespace pcl_ext

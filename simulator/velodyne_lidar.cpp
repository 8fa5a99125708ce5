// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/velodyne_lidar.h"

#include "simulator/random_numbers.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace cell {

namespace {

constexpr double degree = pi / 180.0;
constexpr double azimuth_step = 360.0 * degree / LidarRays::columns;

/** \brief Frame of an image plane that looks sideways from the lidar, lidar -> plane: x
 * to the right, y down, z along the plane's centre.
 * \param[in] turn of the centre from straight ahead, clockwise, radians
 */
Eigen::Isometry3d
lidarToPlane(double turn)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d ahead(std::cos(turn), -std::sin(turn), 0.0);
  const Eigen::Vector3d down(0.0, 0.0, -1.0);
  pose.linear().row(0) = down.cross(ahead);
  pose.linear().row(1) = down;
  pose.linear().row(2) = ahead;
  return pose;
}

} // namespace

LidarRays::LidarRays()
{
  for (std::size_t i = 0; i < quarter_columns; ++i)
    sideways_[i] =
        azimuth_step * (static_cast<double>(i) - (quarter_columns - 1) / 2.0);
  for (std::size_t ring = 0; ring < rings; ++ring)
    elevation_[ring] = (2.0 * static_cast<double>(ring) - 15.0) * degree;
}

Eigen::Vector3d
LidarRays::direction(std::size_t pixel) const
{
  const double turn = azimuth_step * static_cast<double>(pixel % columns);
  const double elevation = elevation_[pixel / columns];
  return {std::cos(elevation) * std::cos(turn),
          -std::cos(elevation) * std::sin(turn),
          std::sin(elevation)};
}

template <typename TargetT>
void
LidarRays::traceTarget(const TargetT& target,
                       Material material,
                       std::size_t quarter,
                       SurfaceImage& image) const
{
  ImageBounds bounds;
  if (!target.imageBounds(bounds))
    return;
  const double first_angle = std::atan(bounds.min_x) - azimuth_step;
  const double last_angle = std::atan(bounds.max_x) + azimuth_step;
  for (std::size_t i = 0; i < quarter_columns; ++i) {
    if (sideways_[i] < first_angle || sideways_[i] > last_angle)
      continue;
    const double x = std::tan(sideways_[i]);
    for (std::size_t ring = 0; ring < rings; ++ring) {
      const double y = -std::tan(elevation_[ring]) / std::cos(sideways_[i]);
      if (y < bounds.min_y || y > bounds.max_y)
        continue;
      const Hit hit = target.meet(x, y);
      const float range =
          static_cast<float>(hit.depth * std::sqrt(1.0 + x * x + y * y));
      const std::size_t pixel = ring * columns + quarter * quarter_columns + i;
      image.drawInFront(pixel, range, hit.cos_incidence, material);
    }
  }
}

void
LidarRays::trace(const Solids& solids,
                 const Eigen::Isometry3d& world_to_lidar,
                 SurfaceImage& image) const
{
  for (std::size_t quarter = 0; quarter < quarters; ++quarter) {
    const double centre =
        azimuth_step *
        (static_cast<double>(quarter * quarter_columns) + (quarter_columns - 1) / 2.0);
    const Eigen::Isometry3d world_to_plane = lidarToPlane(centre) * world_to_lidar;
    for (const Solid& solid : solids) {
      if (const Box* box = std::get_if<Box>(&solid))
        traceTarget(BoxTarget(*box, world_to_plane), box->material, quarter, image);
      else if (const Capsule* capsule = std::get_if<Capsule>(&solid))
        traceTarget(
            CapsuleTarget(*capsule, world_to_plane), capsule->material, quarter, image);
    }
  }
}

double
LidarErrorModel::intensity(Material material, double cos_incidence, double range) const
{
  const double share = range / half_intensity_range;
  return 100.0 * reflectivity(material) * cos_incidence / (1.0 + share * share);
}

double
LidarErrorModel::signal(const SurfaceImage& surfaces, std::size_t pixel)
{
  const double range = surfaces.depth[pixel];
  return reflectivity(surfaces.material[pixel]) * surfaces.cos_incidence[pixel] /
         (range * range);
}

double
LidarErrorModel::strength(double signal) const
{
  return std::min(1.0,
                  std::max(0.0, (signal - lost_signal) / (safe_signal - lost_signal)));
}

double
LidarErrorModel::visibleShare(double signal) const
{
  const double share = strength(signal);
  return share * share * (3.0 - 2.0 * share);
}

float
LidarErrorModel::rounded(double range) const
{
  return static_cast<float>(range_step * std::floor(range / range_step + 0.5));
}

double
LidarErrorModel::lossProbability(const SurfaceImage& surfaces, std::size_t pixel) const
{
  const double range = surfaces.depth[pixel];
  if (range < nearest || range > farthest)
    return 1.0;
  const double share = strength(signal(surfaces, pixel));
  // Not by visibleShare(), whose other order of factors rounds otherwise.
  return 1.0 - (1.0 - random_loss) * share * share * (3.0 - 2.0 * share);
}

/** \brief Range between that of a ray and of the next one of its ring; 0 where the two
 * do not mix. */
double
LidarErrorModel::mixedRange(const SurfaceImage& surfaces,
                            std::size_t pixel,
                            double share) const
{
  const std::size_t ring_begin = pixel - pixel % LidarRays::columns;
  const std::size_t next = ring_begin + (pixel + 1 - ring_begin) % LidarRays::columns;
  const double here = surfaces.depth[pixel];
  const double there = surfaces.depth[next];
  const double step = std::abs(there - here);
  if (there <= 0.0 || step < smallest_mixed_step || step > largest_mixed_step)
    return 0.0;
  return here + share * (there - here);
}

void
LidarErrorModel::measure(const SurfaceImage& surfaces,
                         std::uint32_t random_seed,
                         LidarMeasurement& measurement) const
{
  boost::random::mt19937 random(random_seed);
  boost::random::normal_distribution<float> normal;
  const std::uint32_t mixed_threshold = asThreshold(mixed_share);
  const std::size_t size = surfaces.depth.size();
  measurement.range.assign(size, 0.0f);
  measurement.intensity.assign(size, 0);
  measurement.truth.assign(size, PointTruth::None);
  for (std::size_t pixel = 0; pixel < size; ++pixel) {
    if (random() < asThreshold(lossProbability(surfaces, pixel)))
      continue;
    double range = surfaces.depth[pixel];
    PointTruth truth = PointTruth::Surface;
    if (random() < mixed_threshold) {
      const double mixed = mixedRange(surfaces, pixel, asShare(random()));
      if (mixed > 0.0) {
        range = mixed;
        truth = PointTruth::FlyingPixel;
      }
    }
    range += range_noise * normal(random);
    const double value =
        intensity(surfaces.material[pixel], surfaces.cos_incidence[pixel], range) +
        intensity_noise * normal(random);
    measurement.range[pixel] = rounded(range);
    measurement.intensity[pixel] =
        static_cast<std::uint8_t>(std::min(100.0, std::max(0.0, value + 0.5)));
    measurement.truth[pixel] = truth;
  }
}

} // namespace cell
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/ray_hits.h"

#include "outliers/density_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr double nearest = 0.001;       ///< range, metres
constexpr double steepest_cosine = 0.1; ///< of elevations, towards the sensor's axis
constexpr double neighbours = 25.0;     ///< voxels of a surface among 5 x 5 x 5

double
lengthOf(const std::array<double, 3>& vector)
{
  // Not std::hypot, of which libraries have several.
  return std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] +
                   vector[2] * vector[2]);
}

} // namespace

LidarRays
raysOf(const RaysUnit& unit, const io::VoxelGrid& grid, const io::VoxelPosition& first)
{
  LidarRays rays;
  const std::array<double, 3> at = {static_cast<double>(first.x),
                                    static_cast<double>(first.y),
                                    static_cast<double>(first.z)};
  const std::array<double, 3> sensor = unit.sensor_position.value_or(rays.origin);
  for (std::size_t axis = 0; axis < 3; ++axis)
    rays.origin[axis] =
        (sensor[axis] - grid.lowerCorner(axis)) / grid.resolution + at[axis];
  rays.azimuth_step = unit.azimuth_step;
  rays.elevation_step = unit.elevation_step;
  return rays;
}

std::optional<LidarRays>
raysOf(const io::SpinningSensor& sensor, const io::VoxelPosition& first)
{
  if (!(sensor.azimuth_step > 0.0 && sensor.elevation_step > 0.0))
    return std::nullopt;
  LidarRays rays;
  rays.origin = {sensor.origin[0] + first.x,
                 sensor.origin[1] + first.y,
                 sensor.origin[2] + first.z};
  rays.up = sensor.up;
  rays.azimuth_step = sensor.azimuth_step;
  rays.elevation_step = sensor.elevation_step;
  return rays;
}

RayHits::RayHits(const LidarRays& rays,
                 double resolution,
                 unsigned int levels,
                 double most)
: rays_(rays)
, resolution_(resolution)
, width_(std::ldexp(1.0, static_cast<int>(levels)))
, most_(most)
{}

double
RayHits::mostWithoutPoints(unsigned int levels)
{
  return std::min(std::ldexp(16.0, 2 * static_cast<int>(levels)),
                  static_cast<double>(DensityBlocks::most_points));
}

float
RayHits::evidence(const io::VoxelPosition& coarse,
                  std::int32_t own,
                  std::int32_t near) const
{
  const std::array<double, 3> from = {(coarse.x + 0.5) * width_ - rays_.origin[0],
                                      (coarse.y + 0.5) * width_ - rays_.origin[1],
                                      (coarse.z + 0.5) * width_ - rays_.origin[2]};
  const double distance = lengthOf(from); // voxels
  const double height =
      from[0] * rays_.up[0] + from[1] * rays_.up[1] + from[2] * rays_.up[2];
  const double sine = distance > 0.0 ? std::min(std::abs(height) / distance, 1.0) : 0.0;
  const double cosine = std::max(steepest_cosine, std::sqrt(1.0 - sine * sine));
  const double range = std::max(nearest, distance * resolution_);
  const auto hits = [&](double width, double most) { // of a surface across the rays
    const double columns = width / (range * rays_.azimuth_step * cosine);
    const double rows = width / (range * rays_.elevation_step);
    return std::min(most, std::max(1.0, columns) * std::max(1.0, rows));
  };
  const double edge = width_ * resolution_;
  return static_cast<float>(0.05 + 1.4 * own / hits(edge, most_) +
                            18.0 * near / hits(5.0 * edge, neighbours * most_));
}

} // namespace pcl_ext::PCL_EXT_ABI

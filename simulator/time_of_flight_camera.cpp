// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/time_of_flight_camera.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace cell {

namespace {

constexpr double half_width_angle = 70.6 / 2.0 * pi / 180.0;  // radians
constexpr double half_height_angle = 60.0 / 2.0 * pi / 180.0; // radians

/** \brief First and last grid index within [min, max] of a coordinate that runs evenly
 * over [-half, half]; empty where last < first. */
void
gridRange(
    double min, double max, double half, std::size_t count, long& first, long& last)
{
  const double n = static_cast<double>(count);
  const double from = std::max(-half, std::min(half, min));
  const double to = std::max(-half, std::min(half, max));
  first =
      std::max(0L, static_cast<long>(std::floor((from / half + 1.0) * n / 2.0)) - 1);
  last = std::min(static_cast<long>(count) - 1,
                  static_cast<long>(std::ceil((to / half + 1.0) * n / 2.0)));
  if (max < -half || min > half)
    last = first - 1;
}

} // namespace

RayGrid::RayGrid()
{
  const double half_x = std::tan(half_width_angle);
  const double half_y = std::tan(half_height_angle);
  for (std::size_t i = 0; i < columns; ++i)
    x_.push_back(half_x * (2.0 * (static_cast<double>(i) + 0.5) / columns - 1.0));
  for (std::size_t i = 0; i < rows; ++i)
    y_.push_back(half_y * (2.0 * (static_cast<double>(i) + 0.5) / rows - 1.0));
}

template <typename TargetT>
void
RayGrid::traceTarget(const TargetT& target,
                     Material material,
                     SurfaceImage& image,
                     std::vector<std::size_t>* changed) const
{
  ImageBounds bounds;
  if (!target.imageBounds(bounds))
    return;
  long first_column, last_column, first_row, last_row;
  gridRange(bounds.min_x,
            bounds.max_x,
            std::tan(half_width_angle),
            columns,
            first_column,
            last_column);
  gridRange(bounds.min_y,
            bounds.max_y,
            std::tan(half_height_angle),
            rows,
            first_row,
            last_row);
  for (long row = first_row; row <= last_row; ++row)
    for (long column = first_column; column <= last_column; ++column) {
      const auto i = static_cast<std::size_t>(column);
      const auto j = static_cast<std::size_t>(row);
      const Hit hit = target.meet(x_[i], y_[j]);
      const std::size_t pixel = j * columns + i;
      const bool is_drawn = image.drawInFront(
          pixel, static_cast<float>(hit.depth), hit.cos_incidence, material);
      if (is_drawn && changed != nullptr)
        changed->push_back(pixel);
    }
}

void
RayGrid::trace(const Solids& solids,
               const Eigen::Isometry3d& world_to_sensor,
               SurfaceImage& image,
               std::vector<std::size_t>* changed) const
{
  for (const Solid& solid : solids) {
    if (const Box* box = std::get_if<Box>(&solid))
      traceTarget(BoxTarget(*box, world_to_sensor), box->material, image, changed);
    else if (const Capsule* capsule = std::get_if<Capsule>(&solid))
      traceTarget(
          CapsuleTarget(*capsule, world_to_sensor), capsule->material, image, changed);
  }
}

double
ErrorModel::axialNoise(double depth, double incidence)
{
  const double ratio = incidence / (pi / 2.0 - incidence);
  const double millimetres = 1.5 - 0.5 * depth + 0.3 * depth * depth +
                             0.1 * depth * std::sqrt(depth) * ratio * ratio;
  return millimetres / 1000.0;
}

PixelError
ErrorModel::pixelError(const RayGrid& rays,
                       const SurfaceImage& surfaces,
                       std::size_t pixel) const
{
  PixelError error;
  const double depth = surfaces.depth[pixel];
  if (depth <= 0.0) {
    error.loss = asThreshold(1.0);
    return error;
  }
  const double x = rays.x(pixel % RayGrid::columns) / std::tan(half_width_angle);
  const double y = rays.y(pixel / RayGrid::columns) / std::tan(half_height_angle);
  const double border = 1.0 + corner_noise_growth * (x * x + y * y) / 2.0;
  const double cosine = surfaces.cos_incidence[pixel];
  const double incidence = std::min(steepest_modelled_angle, std::acos(cosine));
  const auto& [a, b, c] = depth_noise;
  const double noise = a + b + c > 0.0 ? (a + (b + c * depth) * depth) / 1000.0
                                       : axialNoise(depth, incidence);
  error.sigma = static_cast<float>(border * noise);

  const double signal =
      reflectivity(surfaces.material[pixel]) * cosine / (depth * depth);
  const double share = std::min(
      1.0, std::max(0.0, (signal - lost_signal) / (safe_signal - lost_signal)));
  error.loss = asThreshold(1.0 - share * share * (3.0 - 2.0 * share));
  return error;
}

namespace {

/** \brief For each pixel that a depth edge runs through, the depth beyond the edge. */
void
findEdges(const ErrorModel& model,
          const std::vector<float>& depth,
          std::uint32_t sensor_seed,
          std::vector<float>& beyond)
{
  beyond.assign(depth.size(), 0.0f);
  const float step = static_cast<float>(model.edge_step);
  const float step_share = static_cast<float>(model.edge_step_share);
  const auto look = [&](std::size_t pixel, std::size_t neighbour) {
    const float here = depth[pixel];
    const float there = depth[neighbour];
    const float difference = std::abs(here - there);
    if (difference <= step || difference <= step_share * std::min(here, there) ||
        here <= 0.0f || there <= 0.0f)
      return;
    // The edge runs through one of the two pixels; which one is random, but constant.
    if (mixSeeds(sensor_seed,
                 static_cast<std::uint32_t>(pixel),
                 static_cast<std::uint32_t>(neighbour)) &
        1u)
      beyond[pixel] = there;
    else
      beyond[neighbour] = here;
  };
  for (std::size_t row = 0; row < RayGrid::rows; ++row)
    for (std::size_t column = 0; column < RayGrid::columns; ++column) {
      const std::size_t pixel = row * RayGrid::columns + column;
      if (column + 1 < RayGrid::columns)
        look(pixel, pixel + 1);
      if (row + 1 < RayGrid::rows)
        look(pixel, pixel + RayGrid::columns);
    }
}

} // namespace

void
ErrorModel::measure(const SurfaceImage& surfaces,
                    const std::vector<PixelError>& errors,
                    std::uint32_t frame_seed,
                    std::uint32_t sensor_seed,
                    Measurement& measurement) const
{
  std::vector<float> beyond;
  findEdges(*this, surfaces.depth, sensor_seed, beyond);
  boost::random::mt19937 random(frame_seed);
  boost::random::normal_distribution<float> normal;
  const std::uint32_t speckle_threshold = asThreshold(speckle_probability);
  const std::uint32_t flying_threshold = asThreshold(flying_share);

  measurement.depth.assign(surfaces.depth.size(), 0);
  measurement.truth.assign(surfaces.depth.size(), PointTruth::None);
  for (std::size_t pixel = 0; pixel < surfaces.depth.size(); ++pixel) {
    double depth = surfaces.depth[pixel];
    PointTruth truth = PointTruth::Surface;
    if (random() < errors[pixel].loss || depth <= 0.0) {
      if (random() >= speckle_threshold)
        continue;
      depth =
          speckle_nearest + (speckle_farthest - speckle_nearest) * asShare(random());
      truth = PointTruth::Speckle;
    }
    else if (beyond[pixel] > 0.0f && random() < flying_threshold) {
      const double step = beyond[pixel] - depth;
      const double proportion =
          asShare(mixSeeds(sensor_seed, static_cast<std::uint32_t>(pixel), 0x5eed));
      depth += step * (proportion + flying_scatter * normal(random));
      truth = PointTruth::FlyingPixel;
    }
    else {
      depth += errors[pixel].sigma * normal(random);
    }
    const double millimetres = std::floor(depth * 1000.0 + 0.5);
    if (millimetres < 1.0)
      continue;
    measurement.depth[pixel] =
        static_cast<std::uint16_t>(std::min(65535.0, millimetres));
    measurement.truth[pixel] = truth;
  }
}

} // namespace cell
} // namespace pcl_ext

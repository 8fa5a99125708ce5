// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/rays_beyond.h"

#include "voxelizing/box_of_floats.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr std::size_t batch_size = DirectionDepths::batch_size;

/** \brief A ray has a direction if it is longer, metres. */
constexpr float least_ray = std::numeric_limits<float>::min();

/** \brief The ends of a box that points with floats or doubles are compared with. */
template <typename NumberT>
struct Ends {
  std::array<NumberT, 3> min;
  std::array<NumberT, 3> max;
};

Ends<float>
endsFor(const io::BoundingBox& box, const float*)
{
  const io::BoxOfFloats floats(box);
  return {floats.min, floats.max};
}

Ends<double>
endsFor(const io::BoundingBox& box, const double*)
{
  return {box.min, box.max};
}

/** \brief Some points of a view, an array for each axis, so that they are vectorized. */
template <typename NumberT>
using Coordinates = std::array<std::array<NumberT, batch_size>, 3>;

/** \brief Moves points to the sensor; those that are in the box, or too far away for
 * floats, to its position. */
template <typename NumberT>
void
moveToSensor(const Coordinates<NumberT>& points,
             const Ends<NumberT>& box,
             const std::array<double, 3>& position,
             DirectionDepths::Batch& moved)
{
  constexpr float largest = std::numeric_limits<float>::max();
  std::array<std::int32_t, batch_size> is_beyond;
  for (std::size_t i = 0; i < batch_size; ++i) {
    std::int32_t is_inside = 1;
    std::int32_t is_finite = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const NumberT at = points[axis][i];
      is_inside &= (at >= box.min[axis] ? 1 : 0) & (at <= box.max[axis] ? 1 : 0);
      moved[axis][i] = static_cast<float>(static_cast<double>(at) - position[axis]);
      is_finite &= std::fabs(moved[axis][i]) <= largest ? 1 : 0;
    }
    is_beyond[i] = is_finite & ~is_inside;
  }
  for (std::array<float, batch_size>& along : moved)
    for (std::size_t i = 0; i < batch_size; ++i)
      along[i] = is_beyond[i] != 0 ? along[i] : 0.0f;
}

template <typename NumberT>
void
addPointsBeyond(const NumberT* point,
                const io::PointView& points,
                const Ends<NumberT>& box,
                const std::array<double, 3>& position,
                DirectionDepths& depths)
{
  Coordinates<NumberT> batch{};
  DirectionDepths::Batch moved;
  for (std::size_t first = 0; first < points.count; first += batch_size) {
    const std::size_t count = std::min(points.count - first, batch_size);
    for (std::size_t i = 0; i < count; ++i) {
      batch[0][i] = point[0];
      batch[1][i] = point[1];
      batch[2][i] = point[2];
      point = io::detail::atOffset(point, points.coordinate_stride);
    }
    moveToSensor(batch, box, position, moved);
    depths.add(moved, count, least_ray);
  }
}

} // namespace

void
addPointsBeyond(io::PointBatches& points,
                const io::BoundingBox& box,
                const std::array<double, 3>& position,
                DirectionDepths& depths)
{
  points.restart();
  for (io::PointView view; points.next(view);) {
    if (view.double_coordinates != nullptr)
      addPointsBeyond(view.double_coordinates,
                      view,
                      endsFor(box, view.double_coordinates),
                      position,
                      depths);
    else
      addPointsBeyond(
          view.coordinates, view, endsFor(box, view.coordinates), position, depths);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI

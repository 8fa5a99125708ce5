// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/direction_depths.h"

#include "bytes/reserve_ahead.h"
#include "voxelizing/box_of_floats.h"

#include <cmath>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr std::size_t batch_size = DirectionDepths::batch_size;

/** \brief A ray has a direction if it is longer, metres. */
constexpr float least_ray = std::numeric_limits<float>::min();

/** \brief Some points of a view, an array for each axis, so that they are vectorized. */
template <typename NumberT>
using Coordinates = std::array<std::array<NumberT, batch_size>, 3>;

/** \brief Moves points to the sensor; those that are in the box, or too far away for
 * floats, to its position. */
template <typename NumberT, typename BoxT>
void
moveToSensor(const Coordinates<NumberT>& points,
             const BoxT& box,
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

} // namespace

void
DirectionDepths::add(const Batch& points, std::size_t count, float least_depth)
{
  std::array<std::uint32_t, batch_size> squares;
  std::array<float, batch_size> depths;
  // Of all, as loops of a fixed length are vectorized.
  for (std::size_t i = 0; i < batch_size; ++i) {
    const Direction direction = directionOf(points[0][i], points[1][i], points[2][i]);
    squares[i] = direction.square;
    depths[i] = direction.depth;
  }
  io::ensureSize(squares_, count_ + count);
  std::uint32_t* const seen = squares_.data();
  std::size_t seen_count = count_;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(depths[i] >= least_depth))
      continue;
    std::vector<float>& face = faces_[squares[i] / face_size];
    if (face.empty())
      face.assign(face_size, unseen);
    float& depth = face[squares[i] % face_size];
    // Without a branch, which would be mispredicted.
    seen[seen_count] = squares[i];
    seen_count += depth < unseen ? 0 : 1;
    depth = std::min(depth, depths[i]);
  }
  count_ = seen_count;
}

void
DirectionDepths::addBeyond(io::PointBatches& points,
                           const io::BoundingBox& box,
                           const std::array<double, 3>& position)
{
  const auto add_all =
      [&](const io::PointView& view, const auto* point, const auto& ends) {
        Coordinates<std::decay_t<decltype(*point)>> batch{};
        Batch moved;
        for (std::size_t first = 0; first < view.count; first += batch_size) {
          const std::size_t count = std::min(view.count - first, batch_size);
          for (std::size_t i = 0; i < count; ++i) {
            batch[0][i] = point[0];
            batch[1][i] = point[1];
            batch[2][i] = point[2];
            point = io::detail::atOffset(point, view.coordinate_stride);
          }
          moveToSensor(batch, ends, position, moved);
          add(moved, count, least_ray);
        }
      };
  points.restart();
  for (io::PointView view; points.next(view);)
    if (view.double_coordinates != nullptr)
      add_all(view, view.double_coordinates, box);
    else
      add_all(view, view.coordinates, io::BoxOfFloats(box));
}

} // namespace pcl_ext::PCL_EXT_ABI

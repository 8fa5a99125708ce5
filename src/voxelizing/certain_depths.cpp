// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/certain_depths.h"

#include "codec/scan/scan_rays.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief A place of whole numbers differs from one that is computed here by less, edges,
 * but for what rays are rounded by. */
constexpr double least_place_error = 0x1p-20;

/** \brief Bounds of what a direction of length 1 is rounded by, to 2^-30, and a step of
 * depth, to 2^-32. */
constexpr double direction_error = 0x1p-29;
constexpr double least_step_error = 0x1p-31;

/** \brief Numbers of whole units. */
std::array<double, 3>
numbersOf(const scan::Triple& numbers, double unit)
{
  return {static_cast<double>(numbers[0]) * unit,
          static_cast<double>(numbers[1]) * unit,
          static_cast<double>(numbers[2]) * unit};
}

/** \brief Places here are from 0 to less than it, and no ray leads to `beyond`, edges. */
constexpr double farthest_place = 0x1p26;
constexpr double beyond = 0x1p30;

double
highest(double x, double y, double z)
{
  const double higher = x > y ? x : y;
  return z > higher ? z : higher;
}

} // namespace

CertainDepths::CertainDepths(const scan::ScanFrame& frame,
                             const scan::ScanRayReader& rays)
: frame_(frame)
, sensor_(numbersOf(frame.rays.pose.origin, 0x1p-16))
, scale_(1.0 / frame.grid.resolution)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    corner_[axis] = frame.grid.lowerCorner(axis);
  columns_.reserve(rays.columns().size());
  for (const scan::ScanRayReader::Column& column : rays.columns())
    columns_.push_back({numbersOf(column.origin, 0x1p-32),
                        numbersOf(column.ahead, 0x1p-30),
                        numbersOf(column.left, 0x1p-30),
                        numbersOf(column.up, 0x1p-30)});
}

void
CertainDepths::find(std::uint32_t row,
                    const std::vector<std::uint32_t>& columns,
                    const std::array<double, 3>* positions,
                    const std::uint32_t* points,
                    std::uint32_t* depths)
{
  for (std::size_t begin = 0; begin < columns.size(); begin += most_points) {
    const std::size_t count = std::min(columns.size() - begin, most_points);
    setPlaces(positions, points + begin, count);
    if (frame_.rays.shape == scan::RayShape::Planar)
      setPlanarRays(row, &columns[begin], count);
    else
      setSpinningRays(row, &columns[begin], count);
    findDepths(count, depths + begin);
  }
}

void
CertainDepths::setPlaces(const std::array<double, 3>* positions,
                         const std::uint32_t* points,
                         std::size_t count)
{
  auto& [xs, ys, zs] = points_.place;
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<double, 3>& position = positions[points[i]];
    xs[i] = position[0];
    ys[i] = position[1];
    zs[i] = position[2];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double x = (xs[i] - corner_[0]) * scale_;
    const double y = (ys[i] - corner_[1]) * scale_;
    const double z = (zs[i] - corner_[2]) * scale_;
    const double from_sensor = highest(
        std::abs(x - sensor_[0]), std::abs(y - sensor_[1]), std::abs(z - sensor_[2]));
    // Whole numbers tell whether it is at the sensor.
    // Each by itself, as one may be no number.
    const bool is_known = x >= 0.0 && x < farthest_place && y >= 0.0 &&
                          y < farthest_place && z >= 0.0 && z < farthest_place &&
                          from_sensor > 1.0;
    xs[i] = is_known ? x : beyond;
    ys[i] = is_known ? y : beyond;
    zs[i] = is_known ? z : beyond;
  }
  if (frame_.is_on_lattice)
    for (Lane& lane : points_.place)
      for (std::size_t i = 0; i < count; ++i) // the centre of its voxel
        lane[i] = static_cast<std::int32_t>(lane[i]) + 0.5;
}

void
CertainDepths::setPlanarRays(std::uint32_t row,
                             const std::uint32_t* columns,
                             std::size_t count)
{
  const auto& vectors = frame_.rays.pose.vectors;
  const double first_depth = frame_.rays.has_half_depths ? 0.5 : 0.0;
  place_error_ = least_place_error;
  step_error_ = least_step_error;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double first =
        0x1p-40 * static_cast<double>(vectors[0][axis] + vectors[2][axis] * row);
    const double change = 0x1p-40 * static_cast<double>(vectors[1][axis]);
    const double start = sensor_[axis];
    for (std::size_t i = 0; i < count; ++i) {
      const double step =
          first + change * static_cast<double>(static_cast<std::int32_t>(columns[i]));
      points_.start[axis][i] = start + first_depth * step;
      points_.step[axis][i] = step;
    }
  }
}

void
CertainDepths::setSpinningRays(std::uint32_t row_index,
                               const std::uint32_t* columns,
                               std::size_t count)
{
  const scan::RayRow& row = frame_.rays.rows[row_index];
  const double cosine = 0x1p-30 * row.cosine;
  const double sine = 0x1p-30 * row.sine;
  const double along = 0x1p-16 * row.along;
  const double across = 0x1p-16 * row.across;
  const double run = 0x1p-24 * row.run;
  place_error_ =
      least_place_error + direction_error * (std::abs(along) + std::abs(across));
  step_error_ = least_step_error + direction_error * std::abs(run);
  const Numbers start{
      along * cosine - across * sine, along * sine + across * cosine, 0x1p-16 * row.up};
  const Numbers step{run * cosine, run * sine, 0x1p-24 * row.rise};
  for (std::size_t i = 0; i < count; ++i) {
    const Column& column = columns_[columns[i]];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      points_.start[axis][i] = column.origin[axis] + start[0] * column.ahead[axis] +
                               start[1] * column.left[axis] +
                               start[2] * column.up[axis];
      points_.step[axis][i] = step[0] * column.ahead[axis] +
                              step[1] * column.left[axis] + step[2] * column.up[axis];
    }
  }
}

/** \brief Finds the depths of the points whose places and rays are set, each along the
 * axis that its ray is most along. Without branches, so that compilers use vectors. */
void
CertainDepths::findDepths(std::size_t count, std::uint32_t* depths) const
{
  constexpr double last = scan::depth_end - 1;
  const auto& [xs, ys, zs] = points_.place;
  const auto& [start_xs, start_ys, start_zs] = points_.start;
  const auto& [step_xs, step_ys, step_zs] = points_.step;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = xs[i] - start_xs[i];
    const double y = ys[i] - start_ys[i];
    const double z = zs[i] - start_zs[i];
    const double step_x = step_xs[i];
    const double step_y = step_ys[i];
    const double step_z = step_zs[i];
    const bool is_y = std::abs(step_y) > std::abs(step_x);
    const double way_xy = is_y ? y : x;
    const double step_xy = is_y ? step_y : step_x;
    const bool is_z = std::abs(step_z) > std::abs(step_xy);
    const double quotient = (is_z ? z : way_xy) / (is_z ? step_z : step_xy) + 0.5;
    const double positive = quotient > 0.0 ? quotient : 0.0; // also if it is no number
    const auto depth = static_cast<std::int32_t>(positive < last ? positive : last);
    const double off = highest(std::abs(x - depth * step_x),
                               std::abs(y - depth * step_y),
                               std::abs(z - depth * step_z));
    depths[i] = off < 0.5 - place_error_ - depth * step_error_
                    ? static_cast<std::uint32_t>(depth)
                    : uncertain;
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_rays.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

ScanRayReader::ScanRayReader(const ScanRays& rays) : rays_(rays)
{
  if (rays_.shape != RayShape::Spinning)
    return;
  columns_.reserve(rays.columns.size());
  for (std::size_t column = 0; column < rays.columns.size(); ++column)
    columns_.push_back(columnAt(column));
}

ScanRayReader::Direction
ScanRayReader::sum(const Direction& first, const Direction& second)
{
  constexpr std::int64_t half = direction_length / 2;
  return {(first.cosine * second.cosine - first.sine * second.sine + half) >> 30,
          (first.sine * second.cosine + first.cosine * second.sine + half) >> 30};
}

ScanRayReader::Direction
ScanRayReader::directionOf(std::int32_t steps) const
{
  Direction direction{direction_length, 0};
  const auto size =
      static_cast<std::uint32_t>(steps < 0 ? -std::int64_t{steps} : steps);
  for (std::size_t bit = 0; bit < rays_.turns.size(); ++bit)
    if ((size >> bit & 1) != 0)
      direction = sum(direction, {rays_.turns[bit][0], rays_.turns[bit][1]});
  if (steps < 0)
    direction.sine = -direction.sine;
  return direction;
}

ScanRayReader::Direction
ScanRayReader::directionOf(const RayRow& row, std::int32_t turn) const
{
  const Direction direction{row.cosine, row.sine};
  return turn == 0 ? direction : sum(direction, directionOf(turn));
}

ScanRayReader::Column
ScanRayReader::columnAt(std::size_t index) const
{
  const auto place = static_cast<std::int64_t>(index);
  const Direction direction = directionOf(rays_.columns[index]);
  Column column;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    column.origin[axis] =
        rays_.pose.origin[axis] * (1 << 16) + rays_.motion.origin[axis] * place;
    std::array<std::int64_t, 3> axes;
    for (std::size_t i = 0; i < 3; ++i)
      axes[i] =
          rays_.pose.vectors[i][axis] + (rays_.motion.vectors[i][axis] * place >> 16);
    column.ahead[axis] = (direction.cosine * axes[0] + direction.sine * axes[1]) >> 30;
    column.left[axis] = (direction.cosine * axes[1] - direction.sine * axes[0]) >> 30;
    column.up[axis] = axes[2];
  }
  return column;
}

Ray
ScanRayReader::spinningRay(std::uint32_t column_index, std::int32_t turn) const
{
  const Column& column = columns_[column_index];
  const Direction direction = directionOf(row_, turn);
  Ray ray;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t ahead =
        (direction.cosine * column.ahead[axis] + direction.sine * column.left[axis]) >>
        30;
    const std::int64_t left =
        (direction.cosine * column.left[axis] - direction.sine * column.ahead[axis]) >>
        30;
    ray.start[axis] =
        column.origin[axis] +
        ((row_.along * ahead + row_.across * left + row_.up * column.up[axis]) >> 14);
    ray.step[axis] = (row_.run * ahead + row_.rise * column.up[axis]) >> 22;
  }
  return ray;
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxels/rays.h"

#include <algorithm>
#include <cstdlib>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::int64_t fixed_one = std::int64_t{1} << 30;

/** \brief Whether a pair is a direction of a length of 1, but for rounding. */
bool
isDirection(std::int64_t cosine, std::int64_t sine)
{
  return std::abs(cosine) <= fixed_one && std::abs(sine) <= fixed_one &&
         cosine * cosine + sine * sine <= fixed_one * (fixed_one + 2);
}

bool
isWithin(std::int64_t number, std::int64_t most)
{
  return number >= -most && number <= most;
}

bool
isPlane(const PointImage& image)
{
  // Steps of up to 64 voxels.
  constexpr std::int64_t most = std::int64_t{1} << 46;
  const auto& plane = image.rays.pose.vectors;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!isWithin(plane[0][axis], most) ||
        !isWithin(plane[1][axis], most / image.width) ||
        !isWithin(plane[2][axis], most / image.height))
      return false;
    const std::int64_t right = plane[1][axis] * (image.width - 1);
    const std::int64_t down = plane[2][axis] * (image.height - 1);
    for (const std::int64_t corner : {right, down, right + down})
      if (!isWithin(plane[0][axis] + corner, most))
        return false;
  }
  return true;
}

bool
isRow(const RayRow& row)
{
  return isDirection(row.cosine, row.sine) && isWithin(row.run, fixed_one) &&
         isWithin(row.rise, fixed_one) && isWithin(row.along, fixed_one) &&
         isWithin(row.across, fixed_one) && isWithin(row.up, fixed_one);
}

} // namespace

bool
isConsistent(const PointImage& image)
{
  const RayModel& rays = image.rays;
  constexpr std::int64_t farthest = std::int64_t{1} << 38;
  if (image.width < 1 || image.height < 1 || image.width > most_image_side ||
      image.height > most_image_side || image.pixelCount() > most_image_pixels ||
      !std::all_of(rays.pose.origin.begin(),
                   rays.pose.origin.end(),
                   [](std::int64_t position) { return isWithin(position, farthest); }))
    return false;
  if (rays.shape == RayShape::Planar)
    return isPlane(image) && rays.turns.empty() && rays.rows.empty();
  for (const auto& axis : rays.pose.vectors)
    for (const std::int64_t element : axis)
      if (!isWithin(element, fixed_one))
        return false;
  return rays.shape == RayShape::Spinning && rays.rows.size() == image.height &&
         rays.turns.size() == columnBits(image.width) &&
         std::all_of(rays.turns.begin(),
                     rays.turns.end(),
                     [](const auto& turn) { return isDirection(turn[0], turn[1]); }) &&
         std::all_of(rays.rows.begin(), rays.rows.end(), isRow);
}

RayReader::RayReader(const PointImage& image) : rays_(image.rays)
{
  if (rays_.shape == RayShape::Planar)
    return;
  columns_.reserve(image.width);
  columns_.push_back({fixed_one, 0});
  for (std::size_t bit = 0; columns_.size() < image.width; ++bit) {
    const Direction turn{rays_.turns[bit][0], rays_.turns[bit][1]};
    for (std::size_t i = 0, end = columns_.size();
         i < end && columns_.size() < image.width;
         ++i)
      columns_.push_back(turned(columns_[i], turn));
  }
}

void
RayReader::moveTo(std::uint32_t row)
{
  row_ = row;
}

RayReader::Direction
RayReader::turned(const Direction& first, const Direction& second)
{
  constexpr std::int64_t half = fixed_one / 2;
  return {(first.cosine * second.cosine - first.sine * second.sine + half) >> 30,
          (first.sine * second.cosine + first.cosine * second.sine + half) >> 30};
}

Ray
RayReader::planarRay(std::uint32_t column) const
{
  const auto& vectors = rays_.pose.vectors;
  Ray ray;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.start[axis] = rays_.pose.origin[axis] * (1 << 16);
    ray.step[axis] =
        (vectors[0][axis] + vectors[1][axis] * column + vectors[2][axis] * row_) >> 8;
  }
  return ray;
}

Ray
RayReader::spinningRay(std::uint32_t column) const
{
  const RayRow& row = rays_.rows[row_];
  const Direction direction = turned(columns_[column], {row.cosine, row.sine});
  Ray ray;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t x = rays_.pose.vectors[0][axis];
    const std::int64_t y = rays_.pose.vectors[1][axis];
    const std::int64_t z = rays_.pose.vectors[2][axis];
    const std::int64_t ahead = (direction.cosine * x + direction.sine * y) >> 30;
    const std::int64_t left = (direction.cosine * y - direction.sine * x) >> 30;
    ray.start[axis] = rays_.pose.origin[axis] * (1 << 16) +
                      ((row.along * ahead + row.across * left + row.up * z) >> 14);
    ray.step[axis] = (row.run * ahead + row.rise * z) >> 22;
  }
  return ray;
}

} // namespace io
} // namespace pcl_ext

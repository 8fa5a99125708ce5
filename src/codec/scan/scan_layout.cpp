// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_frame.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

namespace {

/** \brief Steps of depth have up to 32 edges, so that the last depth is 2^29 edges
 * away. */
constexpr std::int64_t most_step = 32;
/** \brief Sensors are at most 2^26 edges from the grid's corner. */
constexpr std::int64_t farthest_sensor = std::int64_t{1} << 42;
/** \brief Sensors move by at most 2^10 edges from a column to the next, and their axes by
 * half a unit in all. */
constexpr std::int64_t farthest_motion = std::int64_t{1} << 42;
constexpr std::int64_t most_spin = std::int64_t{1} << 45;

bool
isWithin(std::int64_t number, std::int64_t most)
{
  return number >= -most && number <= most;
}

template <typename NumbersT>
bool
areWithin(const NumbersT& numbers, std::int64_t most)
{
  return std::all_of(numbers.begin(), numbers.end(), [most](std::int64_t number) {
    return isWithin(number, most);
  });
}

/** \brief Whether a pair is a direction of a length of 1, but for rounding. */
bool
isDirection(std::int64_t cosine, std::int64_t sine)
{
  return isWithin(cosine, direction_length) && isWithin(sine, direction_length) &&
         cosine * cosine + sine * sine <= direction_length * (direction_length + 2);
}

bool
isPlane(const ScanLayout& layout)
{
  constexpr std::int64_t most = most_step << 40;
  const auto& plane = layout.rays.pose.vectors;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!isWithin(plane[0][axis], most) ||
        !isWithin(plane[1][axis], most / layout.width) ||
        !isWithin(plane[2][axis], most / layout.height))
      return false;
    const std::int64_t right = plane[1][axis] * (layout.width - 1);
    const std::int64_t down = plane[2][axis] * (layout.height - 1);
    for (const std::int64_t corner : {right, down, right + down})
      if (!isWithin(plane[0][axis] + corner, most))
        return false;
  }
  return true;
}

bool
isRow(const RayRow& row)
{
  constexpr std::int64_t most = most_step << 24;
  constexpr std::int64_t most_offset = std::int64_t{1} << 30;
  return isDirection(row.cosine, row.sine) && isWithin(row.run, most) &&
         isWithin(row.rise, most) &&
         std::int64_t{row.run} * row.run + std::int64_t{row.rise} * row.rise <=
             most * most &&
         isWithin(row.along, most_offset) && isWithin(row.across, most_offset) &&
         isWithin(row.up, most_offset);
}

bool
isSpinning(const ScanLayout& layout)
{
  constexpr std::size_t most_turns = 31; // an angle is below 2^31 steps
  const ScanRays& rays = layout.rays;
  return std::all_of(
             rays.pose.vectors.begin(),
             rays.pose.vectors.end(),
             [](const Triple& axis) { return areWithin(axis, direction_length); }) &&
         areWithin(rays.motion.origin, farthest_motion) &&
         std::all_of(rays.motion.vectors.begin(),
                     rays.motion.vectors.end(),
                     [&](const Triple& change) {
                       return areWithin(change, most_spin / layout.width);
                     }) &&
         !rays.turns.empty() && rays.turns.size() <= most_turns &&
         rays.rows.size() == layout.height &&
         std::all_of(rays.turns.begin(),
                     rays.turns.end(),
                     [](const auto& turn) { return isDirection(turn[0], turn[1]); }) &&
         std::all_of(rays.rows.begin(), rays.rows.end(), isRow);
}

bool
areShifts(const ScanLayout& layout)
{
  return layout.row_shifts.empty() ||
         (layout.row_shifts.size() == layout.height &&
          std::all_of(layout.row_shifts.begin(),
                      layout.row_shifts.end(),
                      [&](std::uint16_t shift) { return shift < layout.width; }));
}

/** \brief Whether rows are all there, once, where they have to be, and else none. */
bool
isFiringOrder(const ScanLayout& layout)
{
  if (layout.order != PointOrder::ColumnByColumn)
    return layout.firing_order.empty() && layout.row_shifts.empty();
  std::vector<bool> is_there(layout.height);
  for (const std::uint16_t row : layout.firing_order)
    if (row < layout.height)
      is_there[row] = true;
  return layout.firing_order.size() == layout.height &&
         std::find(is_there.begin(), is_there.end(), false) == is_there.end();
}

} // namespace

bool
isConsistent(const ScanLayout& layout)
{
  const ScanRays& rays = layout.rays;
  if (rays.has_half_depths && rays.shape != RayShape::Planar)
    return false;
  const std::uint32_t longest = layout.isSequence() ? most_pixels : most_side;
  if (layout.width < 1 || layout.height < 1 || layout.width > longest ||
      layout.height > longest || layout.pixelCount() > most_pixels ||
      layout.order > PointOrder::ColumnByColumn || !isFiringOrder(layout) ||
      !areShifts(layout) || !areWithin(rays.pose.origin, farthest_sensor))
    return false;
  if (rays.shape == RayShape::Spinning)
    return isSpinning(layout);
  if (rays.motion != RayPose() || !rays.turns.empty() || !rays.rows.empty())
    return false;
  if (rays.shape == RayShape::Free)
    return rays.pose.vectors == RayPose().vectors &&
           layout.order != PointOrder::ColumnByColumn;
  return rays.shape == RayShape::Planar && isPlane(layout);
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

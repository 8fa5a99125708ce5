// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/scan_locator.h"

#include "codec/scan/point_places.h"
#include "platforms/run_at_once.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Units of an edge. */
constexpr double edge_units = 0x1p32;
constexpr std::int64_t edge_in_units = std::int64_t{1} << 32;

/** \brief Places are nearer to the grid's lowest corner than 2^26 edges, so that there
 * are fewer than scan::most_steps between one and a ray. */
constexpr double farthest = 0x1p58;

/** \brief Whole steps of an edge from one place to near another: to half an edge or less
 * below it on each axis, or to less than half an edge above it.
 * \return whether there are any
 */
bool
stepsBetween(const scan::Triple& from,
             const scan::Triple& to,
             std::array<std::int32_t, 3>& steps)
{
  std::int32_t any = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr std::int64_t half = std::int64_t{1} << 31;
    steps[axis] = static_cast<std::int32_t>(-((from[axis] - to[axis] + half) >> 32));
    any |= steps[axis];
  }
  return any != 0;
}

/** \brief The depth of a ray whose place is nearest along the axis that the ray is most
 * along; of two the lower place, from which stepsBetween() has no steps. */
std::uint32_t
nearestDepth(const scan::Ray& ray, const scan::Triple& place)
{
  std::size_t axis = 0;
  for (const std::size_t other : {1u, 2u})
    if (std::abs(ray.step[other]) > std::abs(ray.step[axis]))
      axis = other;
  constexpr auto last = static_cast<double>(scan::depth_end - 1);
  const double depth = static_cast<double>(place[axis] - ray.start[axis]) /
                       static_cast<double>(ray.step[axis]);
  const double nearest =
      ray.step[axis] > 0 ? std::ceil(depth - 0.5) : std::floor(depth + 0.5);
  return nearest > 0.0 ? static_cast<std::uint32_t>(std::min(nearest, last)) : 0;
}

} // namespace

ScanLocator::ScanLocator(scan::ScanFrame& frame, bool may_turn)
: frame_(frame)
, rays_(frame.rays)
, certain_depths_(frame, rays_)
, sensor_(scan::sensorPlace(frame.rays.pose))
, scale_(edge_units / frame.grid.resolution)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    corner_[axis] = frame.grid.lowerCorner(axis);
  if (may_turn) {
    const auto& [cosine, sine] = frame.rays.turns.front();
    turn_step_ = std::atan2(sine, cosine);
  }
}

bool
ScanLocator::append(std::uint32_t row,
                    const std::vector<std::uint32_t>& columns,
                    const std::vector<std::array<double, 3>>& positions,
                    const std::uint32_t* points)
{
  const std::size_t begin = frame_.depths.size();
  const std::size_t end = begin + columns.size();
  frame_.depths.resize(end, CertainDepths::uncertain);
  frame_.pixels.resize(end);
  if (!frame_.turns.empty())
    frame_.turns.resize(end);
  std::uint32_t* const depths = frame_.depths.data() + begin;
  if (frame_.rays.shape != scan::RayShape::Free)
    certain_depths_.find(row, columns, positions.data(), points, depths);
  rays_.moveTo(row);
  const std::uint32_t first = row * frame_.width + frame_.shiftOf(row);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const std::uint32_t pixel = first + columns[i];
    frame_.pixels[begin + i] = pixel;
    if (depths[i] != CertainDepths::uncertain)
      continue;
    const std::optional<scan::Triple> place = placeOf(positions[points[i]]);
    if (!place)
      return false;
    const std::int32_t turn =
        turn_step_ != 0.0 && !isAtSensor(*place) ? turnOf(row, columns[i], *place) : 0;
    if (turn != 0) {
      frame_.turns.resize(end);
      frame_.turns[begin + i] = turn;
    }
    locate({pixel, columns[i], turn}, *place, depths[i]);
  }
  return true;
}

/** \brief Position as a place; none: it is too far away, or not finite. */
std::optional<scan::Triple>
ScanLocator::placeOf(const std::array<double, 3>& position) const
{
  scan::Triple place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double number = (position[axis] - corner_[axis]) * scale_;
    if (!(std::abs(number) < farthest))
      return std::nullopt;
    place[axis] = static_cast<std::int64_t>(number);
    if (frame_.is_on_lattice) // the centre of its voxel
      place[axis] = ((place[axis] >> 32) * (std::int64_t{1} << 32)) + (1u << 31);
  }
  return place;
}

/** \brief How far a place is turned from the ray of a column, in steps of the angle; 0
 * where that is half an edge or less. */
std::int32_t
ScanLocator::turnOf(std::uint32_t row_index,
                    std::uint32_t column_index,
                    const scan::Triple& place) const
{
  const scan::RayRow& row = frame_.rays.rows[row_index];
  const scan::ScanRayReader::Column& column = rays_.columns()[column_index];
  double column_ahead = 0.0;
  double column_left = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edges =
        static_cast<double>(place[axis] - column.origin[axis]) / edge_units;
    column_ahead += edges * 0x1p-30 * static_cast<double>(column.ahead[axis]);
    column_left += edges * 0x1p-30 * static_cast<double>(column.left[axis]);
  }
  const double cosine = 0x1p-30 * row.cosine;
  const double sine = 0x1p-30 * row.sine;
  const double ahead = cosine * column_ahead + sine * column_left;
  const double left = cosine * column_left - sine * column_ahead;
  // The points of its ray are beside the axis.
  const double square = ahead * ahead + left * left;
  const double across = 0x1p-16 * row.across;
  const double ray = std::sqrt(std::max(square - across * across, 0.0));
  const double turn =
      std::remainder(std::atan2(left, ahead) - std::atan2(across, ray), two_pi);
  return std::abs(turn) * std::sqrt(square) > 0.5
             ? static_cast<std::int32_t>(std::llround(turn / turn_step_))
             : 0;
}

bool
ScanLocator::isAtSensor(const scan::Triple& place) const
{
  std::array<std::int32_t, 3> steps;
  // Mostly one axis tells that it is not.
  return std::abs(place[0] - sensor_[0]) <= edge_in_units &&
         !stepsBetween(sensor_, place, steps);
}

/** \brief Finds the depth of a place in whole numbers. */
void
ScanLocator::locate(const Place& where, const scan::Triple& place, std::uint32_t& depth)
{
  depth = scan::at_sensor;
  std::array<std::int32_t, 3> steps;
  const bool is_at_sensor = isAtSensor(place);
  if (frame_.rays.shape == scan::RayShape::Free) {
    depth = is_at_sensor && !frame_.isSequence() ? scan::at_sensor : 0;
    if (stepsBetween(sensor_, place, steps))
      frame_.beside.push_back({where.pixel, steps});
  }
  else if (!is_at_sensor) {
    const scan::Ray ray = rays_.at(where.column, where.turn);
    depth = nearestDepth(ray, place);
    if (stepsBetween(
            {ray.at(depth, 0), ray.at(depth, 1), ray.at(depth, 2)}, place, steps))
      frame_.beside.push_back({where.pixel, steps});
  }
}

namespace {

/** \brief Puts some of the points on the rays of a scan, in their order. */
bool
locatePart(const ScanPoints& points,
           std::size_t first,
           std::size_t last,
           scan::ScanFrame& scan)
{
  ScanLocator locator(scan, points.may_turn);
  // Rows are not wide, but sequences may be one.
  constexpr std::size_t points_at_once = 4096;
  const std::uint32_t width = scan.rayColumns();
  std::vector<std::uint32_t> row_columns;
  for (std::size_t begin = first; begin < last; begin += row_columns.size()) {
    const std::uint32_t row = points.pixels[points.order[begin]] / width;
    const std::uint32_t row_begin = row * width;
    const std::size_t end = std::min(last, begin + points_at_once);
    row_columns.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t column = points.pixels[points.order[i]] - row_begin;
      if (column >= width)
        break;
      row_columns.push_back(column);
    }
    if (!locator.append(row, row_columns, points.positions, &points.order[begin]))
      return false;
  }
  return true;
}

/** \brief Appends points to those of a scan. */
void
appendPoints(const scan::ScanFrame& points, scan::ScanFrame& scan)
{
  if (!points.turns.empty())
    scan.turns.resize(scan.pixels.size());
  scan.turns.insert(scan.turns.end(), points.turns.begin(), points.turns.end());
  scan.pixels.insert(scan.pixels.end(), points.pixels.begin(), points.pixels.end());
  scan.depths.insert(scan.depths.end(), points.depths.begin(), points.depths.end());
  scan.beside.insert(scan.beside.end(), points.beside.begin(), points.beside.end());
  if (!scan.turns.empty())
    scan.turns.resize(scan.pixels.size());
}

} // namespace

bool
locateScan(const ScanPoints& points, std::size_t threads, scan::ScanFrame& scan)
{
  scan.pixels.clear();
  scan.depths.clear();
  scan.turns.clear();
  scan.beside.clear();
  const std::size_t count = points.order.size();
  scan.pixels.reserve(count);
  scan.depths.reserve(count);
  const std::size_t parts = std::min(threads, count / least_points_per_part);
  if (parts < 2)
    return locatePart(points, 0, count, scan);
  std::vector<scan::ScanFrame> others(parts - 1, scan);
  std::atomic<bool> are_all_near{true};
  runAtOnce(parts, [&](std::size_t i) {
    scan::ScanFrame& part = i == 0 ? scan : others[i - 1];
    if (!locatePart(points, count * i / parts, count * (i + 1) / parts, part))
      are_all_near = false;
  });
  for (const scan::ScanFrame& other : others)
    appendPoints(other, scan);
  return are_all_near;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

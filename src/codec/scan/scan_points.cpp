// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_points.h"

#include "codec/scan/point_places.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

namespace {

/** \brief The middle one, or of an even number the lower one of two; 0: there is none. */
double
lowerMedian(std::vector<double>& numbers)
{
  if (numbers.empty())
    return 0.0;
  const auto middle =
      numbers.begin() + static_cast<std::ptrdiff_t>((numbers.size() - 1) / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

/** \brief Usual distance of the elevations of rows, radians: the median, as rows may be
 * denser at the horizon. 0 if all are the same. */
double
elevationStep(const std::vector<RayRow>& rows)
{
  constexpr double same_elevation = 0.0001; // rows of one ring
  std::vector<double> elevations;
  for (const RayRow& row : rows)
    elevations.push_back(std::atan2(row.rise, row.run));
  std::sort(elevations.begin(), elevations.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < elevations.size(); ++i)
    if (const double step = elevations[i] - elevations[i - 1]; step > same_elevation)
      steps.push_back(step);
  return lowerMedian(steps);
}

/** \brief Usual angle between columns, radians. */
double
azimuthStep(const ScanRays& rays)
{
  std::vector<double> steps;
  for (std::size_t i = 1; i < rays.columns.size(); ++i)
    if (rays.columns[i] != rays.columns[i - 1])
      steps.push_back(std::abs(static_cast<double>(rays.columns[i]) -
                               static_cast<double>(rays.columns[i - 1])));
  return lowerMedian(steps) *
         std::abs(std::atan2(rays.turns.front()[1], rays.turns.front()[0]));
}

std::optional<SpinningSensor>
sensorOf(const ScanRays& rays)
{
  if (rays.shape != RayShape::Spinning)
    return std::nullopt;
  SpinningSensor sensor;
  sensor.azimuth_step = azimuthStep(rays);
  sensor.elevation_step = elevationStep(rays.rows);
  std::array<double, 3> up;
  double square = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sensor.origin[axis] = 0x1p-16 * static_cast<double>(rays.pose.origin[axis]);
    up[axis] = 0x1p-30 * static_cast<double>(rays.pose.vectors[2][axis]);
    square += up[axis] * up[axis];
  }
  constexpr double shortest = 0.25;
  if (sensor.azimuth_step <= 0.0 || sensor.elevation_step <= 0.0 || square < shortest)
    return std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis)
    sensor.up[axis] = up[axis] / std::sqrt(square);
  return sensor;
}

/** \brief Computes the positions of all points.
 * \param[in] put called with the position of each
 * \return how far the farthest coordinate is from the world's origin, metres
 */
template <class PutT>
double
visitPositions(const ScanFrame& scan, const PutT& put)
{
  const VoxelGrid& grid = scan.grid;
  const bool is_on_lattice = scan.is_on_lattice;
  const double resolution = grid.resolution;
  const std::array<double, 3> origin = grid.origin;
  const std::array<double, 3> first_index = {static_cast<double>(grid.first_index[0]),
                                             static_cast<double>(grid.first_index[1]),
                                             static_cast<double>(grid.first_index[2])};
  double farthest = 0.0;
  visitPlaces(scan, [&](const Triple& place) {
    std::array<double, 3> position;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // In edges first, as that product is exact: machines that round a product and a
      // sum at once compute the same, but for the origin of another lattice.
      const double edges = is_on_lattice ? static_cast<double>(place[axis] >> 32) + 0.5
                                         : 0x1p-32 * static_cast<double>(place[axis]);
      position[axis] = (first_index[axis] + edges) * resolution + origin[axis];
    }
    farthest = std::max({farthest,
                         std::abs(position[0]),
                         std::abs(position[1]),
                         std::abs(position[2])});
    put(position);
  });
  return farthest;
}

/** \param[in] indices of the points in the cloud; empty: they are in its order */
void
setPositions(const ScanFrame& scan,
             const std::vector<std::uint32_t>& indices,
             FramePoints& points)
{
  std::vector<std::array<double, 3>>& positions = points.positions;
  points.need_doubles = false;
  positions.clear();
  if (scan.pixels.empty()) // then there are no columns
    return;
  double farthest = 0.0;
  if (indices.empty()) {
    // Not filled before, as there may be many.
    positions.reserve(scan.pixels.size());
    farthest = visitPositions(scan, [&](const auto& at) { positions.push_back(at); });
  }
  else {
    positions.resize(scan.pixels.size());
    auto index = indices.begin();
    farthest = visitPositions(scan, [&](const auto& at) { positions[*index++] = at; });
  }
  points.need_doubles = farthest > scan.grid.farthestFloat();
}

/** \brief The indices of points in the order of their columns of rays, each in the
 * order of its rows. */
void
setColumnByColumn(const ScanFrame& scan, std::vector<std::uint32_t>& indices)
{
  std::vector<std::uint32_t> begins(scan.rayColumns() + std::size_t{1});
  std::vector<std::uint32_t> row_begins(scan.height + std::size_t{1});
  const auto column_of = [&](std::uint32_t pixel, std::uint32_t row) {
    return pixel - row * scan.width - scan.shiftOf(row);
  };
  std::uint32_t row = 0;
  for (const std::uint32_t pixel : scan.pixels) {
    while (pixel >= (row + 1) * scan.width)
      ++row;
    ++begins[column_of(pixel, row) + 1];
    ++row_begins[row + 1];
  }
  for (std::size_t column = 0; column + 1 < begins.size(); ++column)
    begins[column + 1] += begins[column];
  for (row = 0; row < scan.height; ++row)
    row_begins[row + 1] += row_begins[row];
  for (const std::uint16_t fired : scan.firing_order)
    for (std::uint32_t point = row_begins[fired]; point < row_begins[fired + 1u];
         ++point)
      indices[point] = begins[column_of(scan.pixels[point], fired)]++;
}

/** \brief Puts what points have to their indices.
 * \param[in] count values of a point
 */
template <typename ValueT>
void
arrange(const std::vector<std::uint32_t>& indices,
        std::size_t count,
        std::vector<ValueT>& values)
{
  if (values.empty())
    return;
  std::vector<ValueT> arranged(values.size());
  auto value = values.begin();
  for (const std::uint32_t index : indices)
    for (std::size_t i = 0; i < count; ++i)
      arranged[index * count + i] = *value++;
  values.swap(arranged);
}

} // namespace

void
movePoints(ScanFrame& scan, VoxelFrame& frame)
{
  frame.clearVoxels();
  frame.grid = scan.grid;
  frame.intensity_scale = scan.intensity_scale;
  frame.depth_model.reset();
  frame.colour_bits = scan.colour_bits;
  frame.has_point_counts = true;
  FramePoints& points = frame.points;
  points.intensities.swap(scan.intensities);
  points.colours.swap(scan.colours);
  frame.fields.swap(scan.fields);
  points.sensor = sensorOf(scan.rays);
  const auto count = static_cast<std::uint32_t>(scan.pixels.size());
  std::vector<std::uint32_t> indices;
  if (scan.order == PointOrder::ColumnByColumn) {
    indices.resize(count);
    setColumnByColumn(scan, indices);
    arrange(indices, 1, points.intensities);
    arrange(indices, 1, points.colours);
    for (FrameField& field : frame.fields)
      arrange(indices, field.count, field.numbers);
  }
  setPositions(scan, indices, points);
  if (scan.order == PointOrder::Organised) {
    points.width = scan.width;
    points.height = scan.height;
    points.indices.swap(scan.pixels);
    return;
  }
  points.width = count;
  points.height = 1;
  points.indices.resize(count);
  std::iota(points.indices.begin(), points.indices.end(), 0u);
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

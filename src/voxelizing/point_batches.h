// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/status.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Checks that a view of several points says where they are.
 * \return Ok, or InvalidInput
 */
CompressionStatus
checkView(const PointView& points);

/** \brief A cloud that is in memory, as one batch. */
class SingleBatch : public PointBatches {
public:
  explicit SingleBatch(const PointView& points, std::size_t points_behind_sensor = 0)
  : points_(points), points_behind_sensor_(points_behind_sensor)
  {}

  std::size_t
  size() const override
  {
    return points_.count;
  }

  bool
  hasIntensities() const override
  {
    return points_.intensities != nullptr;
  }

  bool
  hasColours() const override
  {
    return points_.colours != nullptr;
  }

  std::vector<FieldDescription>
  fields() const override
  {
    std::vector<FieldDescription> descriptions;
    for (const FieldView& field : points_.fields)
      descriptions.push_back(field.description);
    return descriptions;
  }

  ImageSize
  imageSize() const override
  {
    return points_.image;
  }

  void
  restart() override
  {
    is_read_ = false;
  }

  bool
  next(PointView& points) override
  {
    if (is_read_)
      return false;
    is_read_ = true;
    points = points_;
    return true;
  }

  std::size_t
  pointsBehindSensor() const override
  {
    return points_behind_sensor_;
  }

  std::vector<PointBatches*>
  split(std::size_t parts) override
  {
    parts_.clear();
    parts_.reserve(parts);
    std::vector<PointBatches*> pointers;
    for (std::size_t i = 0; i < parts; ++i) {
      parts_.emplace_back(
          slice(i * points_.count / parts, (i + 1) * points_.count / parts),
          i == 0 ? points_behind_sensor_ : 0);
      pointers.push_back(&parts_.back());
    }
    return pointers;
  }

private:
  PointView
  slice(std::size_t begin, std::size_t end) const
  {
    PointView view = points_;
    view.fields.clear(); // they are not read in parts, nor are pixels
    if (points_.double_coordinates != nullptr)
      view.double_coordinates = detail::atOffset(points_.double_coordinates,
                                                 begin * points_.coordinate_stride);
    else
      view.coordinates =
          detail::atOffset(points_.coordinates, begin * points_.coordinate_stride);
    if (points_.intensities != nullptr)
      view.intensities =
          detail::atOffset(points_.intensities, begin * points_.intensity_stride);
    if (points_.colours != nullptr)
      view.colours = static_cast<const unsigned char*>(points_.colours) +
                     begin * points_.colour_stride;
    view.count = end - begin;
    return view;
  }

  PointView points_;
  std::size_t points_behind_sensor_;
  bool is_read_ = false;
  std::vector<SingleBatch> parts_;
};

/** \brief True if x, y and z are finite. */
template <typename NumberT>
bool
isFinite(const NumberT* point)
{
  return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

/** \brief True if x, y and z are in a box; they are not where one is NaN. */
template <typename NumberT>
bool
isInside(const BoundingBox& box, const NumberT* point)
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto coordinate = static_cast<double>(point[axis]);
    if (!(coordinate >= box.min[axis] && coordinate <= box.max[axis]))
      return false;
  }
  return true;
}

/** \brief Calls a function with a pointer to x of every point, a float or a double. */
template <typename VisitT>
void
visitPoints(const PointView& points, VisitT&& visit)
{
  const auto visit_all = [&](const auto* point) {
    for (std::size_t i = 0; i < points.count;
         ++i, point = detail::atOffset(point, points.coordinate_stride))
      visit(point);
  };
  if (points.double_coordinates != nullptr)
    visit_all(points.double_coordinates);
  else
    visit_all(points.coordinates);
}

/** \brief The same for the points of all batches. */
template <typename VisitT>
void
visitPoints(PointBatches& batches, VisitT&& visit)
{
  batches.restart();
  for (PointView points; batches.next(points);)
    visitPoints(points, visit);
}

/** \brief The lowest and the highest coordinates of some points; of none lowest is above
 * highest. */
struct CoordinateEnds {
  std::array<double, 3> lowest;
  std::array<double, 3> highest;

  CoordinateEnds()
  {
    lowest.fill(std::numeric_limits<double>::max());
    highest.fill(std::numeric_limits<double>::lowest());
  }

  /** \brief Adds a finite point. */
  template <typename NumberT>
  void
  add(const NumberT* point)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto coordinate = static_cast<double>(point[axis]);
      lowest[axis] = std::min(lowest[axis], coordinate);
      highest[axis] = std::max(highest[axis], coordinate);
    }
  }
};

/** \brief The ends of the finite points of a cloud. */
inline CoordinateEnds
coordinateEnds(PointBatches& batches)
{
  CoordinateEnds ends;
  visitPoints(batches, [&ends](const auto* point) {
    if (isFinite(point))
      ends.add(point);
  });
  return ends;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/cloud_voxelizer.h"

#include "voxelizing/coordinate_step.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/scan_collector.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief How often a resolution has to be doubled until a grid may hold all points;
 * above most_doublings if that is not enough. */
unsigned int
doublingsForAll(PointBatches& points, double resolution)
{
  const CoordinateEnds ends = coordinateEnds(points);
  double width = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    width = std::max(width, ends.highest[axis] - ends.lowest[axis]);
  const double most_voxels = std::exp2(max_grid_depth) - 2.0;
  unsigned int doublings = 0;
  while (doublings <= most_doublings &&
         width > most_voxels * std::ldexp(resolution, static_cast<int>(doublings)))
    ++doublings;
  return doublings;
}

/** \brief The ends of the points that are to be in the grid. */
CoordinateEnds
endsInBox(PointBatches& points, const std::optional<BoundingBox>& box)
{
  CoordinateEnds ends = coordinateEnds(points);
  for (std::size_t axis = 0; box && axis < 3; ++axis) {
    ends.lowest[axis] = std::max(ends.lowest[axis], box->min[axis]);
    ends.highest[axis] = std::min(ends.highest[axis], box->max[axis]);
  }
  return ends;
}

/** \param[in] side of the grid that a wider one is to have, edges */
WiderGrid
widerGridFor(PointBatches& points, const EncoderSettings& settings, double side)
{
  const CoordinateEnds ends = endsInBox(points, settings.bounding_box);
  const bool has_fixed_origin =
      settings.origin || settings.format == StreamFormat::Published;
  const std::array<double, 3> origin = settings.origin.value_or(VoxelGrid().origin);
  WiderGrid wider;
  double farthest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    wider.width = std::max(wider.width, ends.highest[axis] - ends.lowest[axis]);
    farthest = std::max({farthest,
                         ends.highest[axis] - origin[axis],
                         origin[axis] - ends.lowest[axis]});
  }
  // One voxel less, so that a point at the end is inside.
  wider.resolution =
      has_fixed_origin ? farthest / (side / 2.0 - 1.0) : wider.width / (side - 2.0);
  return wider;
}

} // namespace

CloudVoxelizer::CloudVoxelizer(const EncoderSettings& settings, IntensityUnit unit)
: settings_(settings), unit_(unit), voxelizer_(settings, unit)
{}

VoxelizationStatistics
CloudVoxelizer::voxelize(PointBatches& points,
                         bool is_i_frame_due,
                         bool may_refit,
                         VoxelFrame& frame)
{
  is_i_frame_due_ = is_i_frame_due;
  has_changed_ = false;
  may_refit_ = may_refit;
  if (fitCoordinateStep(points) || !settings_.coarsen_wide_clouds ||
      unit_ == IntensityUnit::Share)
    voxelizeAsBefore(points, frame);
  else
    voxelizeWide(points, frame);
  wider_grid_.reset();
  if (statistics_.points_outside_grid > 0)
    wider_grid_ = widerGridFor(points,
                               settings_,
                               ScanCollector::isPossible(settings_, unit_)
                                   ? scan_side
                                   : std::exp2(max_grid_depth));
  return statistics_;
}

/** \brief Voxelizes from now on with an edge and an origin, or with those of the
 * settings. */
void
CloudVoxelizer::takeEdge(double resolution,
                         const std::optional<std::array<double, 3>>& origin)
{
  EncoderSettings settings = settings_;
  settings.resolution = resolution;
  settings.origin = origin;
  voxelizer_ = Voxelizer(settings, unit_);
  has_changed_ = true;
}

void
CloudVoxelizer::voxelizeAsBefore(PointBatches& points, VoxelFrame& frame)
{
  statistics_ = voxelizer_.voxelize(points, takesIFrame() && may_refit_, frame);
}

/** \brief Centres voxels on the multiples of a step, if all coordinates of a cloud are
 * such multiples. The step is the resolution, or a larger one if that is asked for.
 * \return false if they are not
 */
bool
CloudVoxelizer::fitCoordinateStep(PointBatches& points)
{
  if (unit_ == IntensityUnit::Share || settings_.format != StreamFormat::Version1 ||
      settings_.origin || settings_.bounding_box)
    return false;
  const std::array<double, 3> middle = middle_;
  const double step = findStep(points);
  if (!std::isnan(step) && (step != coordinate_step_ || middle != middle_)) {
    std::array<double, 3> origin;
    for (std::size_t axis = 0; step > 0.0 && axis < 3; ++axis)
      origin[axis] = (std::round(middle_[axis] / step) - 0.5) * step;
    if (step > 0.0)
      takeEdge(step, origin);
    else
      takeEdge(settings_.resolution, settings_.origin);
    coordinate_step_ = step;
    doublings_ = 0;
  }
  return coordinate_step_ > 0.0;
}

/** \brief The step whose multiples the coordinates are, see findCoordinateStep(). Where an
 * I-frame is due multiples may be counted from near the cloud, if it is far away. */
double
CloudVoxelizer::findStep(PointBatches& points)
{
  // Not changed to and fro, as a change takes an I-frame.
  const double largest =
      is_i_frame_due_ ? std::numeric_limits<double>::infinity() : coordinate_step_;
  constexpr auto most_multiples = static_cast<double>(lattice_end - 1);
  const auto step_around = [&](const std::array<double, 3>& middle) {
    return findCoordinateStep(points,
                              settings_.resolution,
                              settings_.use_coordinate_step,
                              largest,
                              most_multiples,
                              middle);
  };
  const double step = step_around(middle_);
  if (step != 0.0 || !is_i_frame_due_) // also NaN
    return step;
  std::array<double, 3> middle = anyPoint(points);
  for (double& along : middle)
    if (std::abs(along) < most_multiples / 2.0 * settings_.resolution)
      along = 0.0;
  if (middle == middle_)
    return step;
  const double of_far_cloud = step_around(middle);
  if (of_far_cloud > 0.0)
    middle_ = middle;
  return of_far_cloud;
}

/** \brief Voxelizes with so few doublings that all points are on the grid, or, if some
 * are far out, all but a sixteenth; if there are none such with the most ones, where they
 * keep many more points, else without. */
void
CloudVoxelizer::voxelizeWide(PointBatches& points, VoxelFrame& frame)
{
  const bool is_i_frame_due = takesIFrame();
  if (doublings_ == 0) {
    voxelizeAsBefore(points, frame);
    if (statistics_.points_outside_grid == 0)
      return;
  }
  const unsigned int for_all = doublingsForAll(points, settings_.resolution);
  const auto are_many_outside = [&] {
    return 16 * statistics_.points_outside_grid > statistics_.points;
  };
  // A change takes an I-frame; without one that is due a factor of four is worth it.
  if (doublings_ > 0 && (is_i_frame_due || for_all + 2 <= doublings_))
    voxelizeCoarsened(points, for_all <= most_doublings ? for_all : 0, frame);
  else if (doublings_ > 0)
    voxelizeAsBefore(points, frame);
  if (for_all <= most_doublings)
    for (unsigned int doublings = std::max(for_all, doublings_);
         statistics_.points_outside_grid > 0 && doublings <= most_doublings;
         ++doublings)
      voxelizeCoarsened(points, doublings, frame);
  else
    while (are_many_outside() && doublings_ < most_doublings)
      voxelizeCoarsened(points, doublings_ + 1, frame);
  if (!are_many_outside() || doublings_ == 0 || !takesIFrame())
    return;
  const std::size_t kept = statistics_.points_used;
  voxelizeCoarsened(points, 0, frame);
  if (kept > 2 * statistics_.points_used)
    voxelizeCoarsened(points, most_doublings, frame);
}

/** \brief Voxelizes a cloud and the following ones with another edge. */
void
CloudVoxelizer::voxelizeCoarsened(PointBatches& points,
                                  unsigned int doublings,
                                  VoxelFrame& frame)
{
  takeEdge(std::min(std::ldexp(settings_.resolution, static_cast<int>(doublings)),
                    largest_resolution),
           settings_.origin);
  doublings_ = doublings;
  statistics_ = voxelizer_.voxelize(points, true, frame);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/scan_grid.h"

#include "voxelizing/coordinate_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Places are nearer to the origin of a lattice, edges. */
constexpr double farthest_steps = 0x1p40;

/** \brief How far a place is from another one on the axis where it is farthest, edges. */
double
farthestAxis(const std::array<double, 3>& one,
             const std::array<double, 3>& other,
             double edge)
{
  double farthest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    farthest = std::max(farthest, std::abs(one[axis] - other[axis]) / edge);
  return farthest;
}

/** \brief The grid around a place, or around the origin of its lattice if that is near.
 * \return none if the place is too far away
 */
std::optional<VoxelGrid>
gridAround(const std::array<double, 3>& place,
           double resolution,
           const std::array<double, 3>& origin)
{
  constexpr double near = 0x1p19;
  const double distance = farthestAxis(place, origin, resolution);
  if (!(distance < farthest_steps))
    return std::nullopt;
  VoxelGrid grid;
  grid.resolution = resolution;
  grid.origin = origin;
  grid.depth = max_grid_depth;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid.first_index[axis] = -(1 << (max_grid_depth - 1));
    if (distance >= near)
      grid.origin[axis] +=
          resolution * std::round((place[axis] - origin[axis]) / resolution);
  }
  return grid;
}

} // namespace

ScanGrid::ScanGrid(const EncoderSettings& settings)
: resolution_(settings.resolution)
, may_coarsen_(settings.coarsen_wide_clouds)
, origin_(settings.origin)
, may_have_step_(!settings.origin && !settings.bounding_box)
{}

void
ScanGrid::findStep(PointBatches& points, bool is_i_frame_due)
{
  if (!may_have_step_)
    return;
  // Not changed to and fro, as a change takes an I-frame.
  const double largest =
      is_i_frame_due ? std::numeric_limits<double>::infinity() : step_;
  const double step =
      findCoordinateStep(points, resolution_, true, largest, farthest_steps);
  if (!std::isnan(step))
    step_ = step;
}

bool
ScanGrid::coarsen()
{
  if (!may_coarsen_ || hasStep() || doublings_ == most_doublings)
    return false;
  ++doublings_;
  return true;
}

bool
ScanGrid::setAround(const WorldPose& sensor_pose, const SensorCloud& cloud)
{
  const double edge =
      hasStep() ? step_
                : std::min(std::ldexp(resolution_, static_cast<int>(doublings_)),
                           largest_resolution);
  std::array<double, 3> origin = origin_.value_or(VoxelGrid().origin);
  if (!origin_ && hasStep())
    origin.fill(-edge / 2.0);
  // Around the sensor, unless points are in other coordinates.
  constexpr double farthest = 0x1p24;
  std::array<double, 3> place;
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[axis] = sensor_pose.translation()[static_cast<Eigen::Index>(axis)];
  double near = 0x1p19;
  // Not by points that are too far away anyway, as drivers write missing ones.
  const auto first =
      std::find_if(cloud.positions.begin(),
                   cloud.positions.end(),
                   [&](const std::array<double, 3>& position) {
                     return farthestAxis(position, origin, edge) < farthest_steps;
                   });
  if (first != cloud.positions.end() &&
      !(farthestAxis(place, *first, edge) < farthest)) {
    place = *first;
    near = farthest; // any point may be the first one
  }
  if (grid_.resolution == edge && lattice_origin_ == origin &&
      farthestAxis(place, grid_.origin, edge) < near)
    return true;
  const std::optional<VoxelGrid> grid = gridAround(place, edge, origin);
  if (grid)
    grid_ = *grid;
  lattice_origin_ = origin;
  return grid.has_value();
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/locate_points.h"

#include "voxelizing/box_of_floats.h"
#include "voxelizing/point_locator.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Bound of the difference, in voxels, between the position computed here and
 * the quotient in double precision, for points in the grid.
 *
 * The inverse, the product, the first centre, the difference and a rounded coordinate
 * have a relative error of at most 2^-24 each. The terms of second order and the errors
 * of the quotient and of the bound are below the one voxel more.
 */
float
maxError(const VoxelGrid& grid, std::size_t axis, bool is_rounded)
{
  const auto size = static_cast<double>(grid.size());
  const auto first = static_cast<double>(grid.first_index[axis]);
  const double farthest = std::max(std::abs(first), std::abs(first + size)) +
                          std::abs(grid.origin[axis]) / grid.resolution + 1.0;
  const double roundings = is_rounded ? 4.0 : 3.0;
  return static_cast<float>((roundings * farthest + size) * 0x1p-24);
}

} // namespace

LocatorGrid::LocatorGrid(const VoxelGrid& grid,
                         const std::optional<BoundingBox>& box,
                         bool rounded)
: lattice(Lattice::within(grid))
, first_index(grid.first_index)
, size(static_cast<std::uint32_t>(grid.size()))
, inverse_resolution(static_cast<float>(1.0 / grid.resolution))
, beyond_grid(static_cast<std::int32_t>(-grid.size()))
, is_rounded(rounded)
, has_box(box)
{
  float error = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first_centre[axis] = static_cast<float>(grid.centre(axis, 0) / grid.resolution);
    error = std::max(error, maxError(grid, axis, is_rounded));
  }
  if (box) {
    const BoxOfFloats floats(*box);
    box_min = floats.min;
    box_max = floats.max;
  }
  certain = 0.5f - error;
  is_useful = error < 0.25f;
}

template void
locatePointsWith<ScalarLanes>(const LocatorGrid&,
                              const LocatorInput&,
                              LocatedPoints&,
                              CertainPoints&);
#if PCL_EXT_HAS_NATIVE_LANES
template void
locatePointsWith<NativeLanes>(const LocatorGrid&,
                              const LocatorInput&,
                              LocatedPoints&,
                              CertainPoints&);
#endif

void
locatePoints(const LocatorGrid& grid,
             const LocatorInput& points,
             LocatedPoints& located,
             CertainPoints& certain)
{
#if PCL_EXT_HAS_AVX2
  if (usesAvx2())
    return locatePointsWith<Avx2Lanes>(grid, points, located, certain);
#endif
  locatePointsWith<NativeLanes>(grid, points, located, certain);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

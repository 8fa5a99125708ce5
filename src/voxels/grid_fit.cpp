// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxels/grid_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

bool
isOrigin(const std::array<double, 3>& origin)
{
  // The end of the lattice at the largest resolution.
  constexpr double farthest = largest_resolution * 2.0 * lattice_end;
  return std::all_of(origin.begin(), origin.end(), [](double coordinate) {
    return std::abs(coordinate) <= farthest; // NaN fails
  });
}

bool
leavesLattice(const VoxelGrid& grid)
{
  for (const std::int32_t index : grid.first_index)
    if (index < -lattice_end || index + grid.size() > lattice_end)
      return true;
  return false;
}

bool
containsRange(const VoxelGrid& grid, const LatticeRange& range)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (range.lowest[axis] < grid.first_index[axis] ||
        range.highest[axis] >= grid.first_index[axis] + grid.size())
      return false;
  return true;
}

unsigned int
requiredDepth(const LatticeRange& range)
{
  std::int64_t extent = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    extent =
        std::max(extent, std::int64_t{range.highest[axis]} - range.lowest[axis] + 1);
  unsigned int depth = 1;
  while (std::int64_t{1} << depth < extent)
    ++depth;
  return depth;
}

LatticeRange
rangeOf(const VoxelGrid& grid)
{
  LatticeRange range;
  range.lowest = grid.first_index;
  for (std::size_t axis = 0; axis < 3; ++axis)
    range.highest[axis] =
        static_cast<std::int32_t>(grid.first_index[axis] + grid.size() - 1);
  return range;
}

LatticeRange
unite(const LatticeRange& first, const LatticeRange& second)
{
  LatticeRange range = first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    range.lowest[axis] = std::min(range.lowest[axis], second.lowest[axis]);
    range.highest[axis] = std::max(range.highest[axis], second.highest[axis]);
  }
  return range;
}

VoxelGrid
fitGrid(const VoxelGrid& lattice, const LatticeRange& range)
{
  VoxelGrid grid = lattice;
  grid.depth = requiredDepth(range);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t extent =
        std::int64_t{range.highest[axis]} - range.lowest[axis] + 1;
    const std::int64_t centred = range.lowest[axis] - (grid.size() - extent) / 2;
    grid.first_index[axis] = static_cast<std::int32_t>(
        std::clamp(centred, -lattice_end, lattice_end - grid.size()));
  }
  return grid;
}

VoxelGrid
adaptGrid(const VoxelGrid& grid,
          bool has_points,
          bool may_refit,
          const LatticeRange& range)
{
  // One level more than required is kept as a reserve. Two are due to an outlier in a
  // previous cloud.
  const bool is_far_too_large = may_refit && requiredDepth(range) + 2 <= grid.depth;
  if (!has_points || is_far_too_large)
    return fitGrid(grid, range);
  return containsRange(grid, range) ? grid : fitGrid(grid, unite(rangeOf(grid), range));
}

VoxelGrid
gridOfBox(const VoxelGrid& lattice, const BoundingBox& box)
{
  LatticeRange range;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto index = [&](double coordinate) {
      const double position = (coordinate - lattice.origin[axis]) / lattice.resolution;
      return static_cast<std::int32_t>(
          std::clamp(std::floor(position),
                     static_cast<double>(-lattice_end),
                     static_cast<double>(lattice_end - 1)));
    };
    range.lowest[axis] = index(box.min[axis]);
    range.highest[axis] = index(box.max[axis]);
  }
  return fitGrid(lattice, range);
}

std::array<double, 3>
originFor(double resolution, const BoundingBox& box)
{
  std::array<double, 3> origin{};
  const double end = static_cast<double>(lattice_end) * resolution;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (box.min[axis] < -end || box.max[axis] >= end)
      origin[axis] =
          std::round((box.min[axis] / 2.0 + box.max[axis] / 2.0) / resolution) *
          resolution;
  return origin;
}

VoxelGrid
pclGridOfBox(double resolution, const BoundingBox& box)
{
  // Arithmetic and tolerance of PCL's getKeyBitSize, so that PCL computes the same
  // voxels.
  constexpr double tolerance = std::numeric_limits<float>::epsilon();
  double voxels = 2.0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    voxels = std::max(
        voxels, std::ceil((box.max[axis] - box.min[axis] - tolerance) / resolution));
  VoxelGrid grid;
  grid.resolution = resolution;
  grid.depth = static_cast<unsigned int>(std::ceil(std::log2(voxels) - tolerance));
  const double side = static_cast<double>(grid.size()) * resolution;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double oversize = (side - (box.max[axis] - box.min[axis])) / 2.0;
    grid.origin[axis] = box.min[axis] - (oversize > tolerance ? oversize : 0.0);
  }
  return grid;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

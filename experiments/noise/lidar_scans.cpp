// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "lidar_scans.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pcl_ext {
namespace noise {

namespace {

using Index = std::array<std::int64_t, 3>;

/** \brief The voxel of a point, counted from the world's origin. */
Index
indexOf(const pcl::PointXYZI& point, double edge)
{
  Index index{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    index[axis] = static_cast<std::int64_t>(
        std::floor(static_cast<double>(point.data[axis]) / edge));
  return index;
}

/** \brief The smallest grid with some voxels. */
io::VoxelGrid
gridAround(const std::vector<Index>& indices, double edge)
{
  io::VoxelGrid grid;
  grid.resolution = edge;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [least, most] = std::minmax_element(
        indices.begin(), indices.end(), [axis](const Index& a, const Index& b) {
          return a[axis] < b[axis];
        });
    grid.first_index[axis] = static_cast<std::int32_t>((*least)[axis]);
    while ((*most)[axis] - (*least)[axis] >= grid.size())
      ++grid.depth;
  }
  return grid;
}

/** \brief What of a voxel's points decides: a surface before the person before noise. */
int
rank(VoxelTruth truth)
{
  return truth == VoxelTruth::Still ? 2 : truth == VoxelTruth::Person ? 1 : 0;
}

} // namespace

void
voxelizeReturns(double edge, LabelledScan& scan)
{
  io::VoxelFrame& frame = scan.voxels.of(Law::Count);
  frame = io::VoxelFrame();
  scan.voxels.truth.clear();
  scan.voxel_of_return.clear();
  if (scan.returns->empty())
    return;
  std::vector<Index> indices;
  for (const pcl::PointXYZI& point : *scan.returns)
    indices.push_back(indexOf(point, edge));
  frame.grid = gridAround(indices, edge);
  std::vector<std::uint64_t> keys;
  for (const Index& index : indices) {
    std::array<std::uint32_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<std::uint32_t>(index[axis] - frame.grid.first_index[axis]);
    keys.push_back(io::mortonKey({at[0], at[1], at[2]}));
  }
  frame.keys = keys;
  std::sort(frame.keys.begin(), frame.keys.end());
  frame.keys.erase(std::unique(frame.keys.begin(), frame.keys.end()), frame.keys.end());
  frame.intensities.assign(frame.keys.size(), 0);
  scan.voxels.truth.assign(frame.keys.size(), VoxelTruth::Noise);
  const auto most = static_cast<std::uint16_t>(frame.intensity_scale.maxSymbol());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto voxel = static_cast<std::size_t>(
        std::lower_bound(frame.keys.begin(), frame.keys.end(), keys[i]) -
        frame.keys.begin());
    scan.voxel_of_return.push_back(static_cast<std::uint32_t>(voxel));
    std::uint16_t& count = frame.intensities[voxel];
    count = count < most ? static_cast<std::uint16_t>(count + 1) : most;
    if (rank(scan.truth[i]) > rank(scan.voxels.truth[voxel]))
      scan.voxels.truth[voxel] = scan.truth[i];
  }
}

void
readScan(cell::RobotCell& cell,
         std::uint32_t revolution,
         double edge,
         LabelledScan& scan)
{
  cell.captureLidar(revolution, scan.frame);
  const std::vector<cell::Material>& materials =
      cell.lidarSurfaces(revolution).material;
  scan.returns->clear();
  scan.index_of_return.clear();
  scan.truth.clear();
  for (std::size_t i = 0; i < scan.frame.cloud.size(); ++i) {
    if (scan.frame.truth[i] == cell::PointTruth::None)
      continue;
    scan.returns->push_back(scan.frame.cloud[i]);
    scan.index_of_return.push_back(i);
    scan.truth.push_back(scan.frame.truth[i] != cell::PointTruth::Surface
                             ? VoxelTruth::Noise
                         : materials[i] == cell::Material::Cloth ? VoxelTruth::Person
                                                                 : VoxelTruth::Still);
  }
  voxelizeReturns(edge, scan);
}

} // namespace noise
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/labelled_lidar.h"

#include <limits>

namespace pcl_ext {
namespace noise {

LabelledLidar::LabelledLidar(std::uint32_t seed, double resolution)
: cell_(seed)
, native_(NativeIntensity(resolution), cell_.lidarPose())
, count_(CountIntensity(resolution), cell_.lidarPose())
{}

template <typename WantedT>
void
LabelledLidar::markTruth(const WantedT& wanted, VoxelTruth truth, LabelledFrame& frame)
{
  auto surfaces = captured_.cloud;
  surfaces.is_dense = false;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (captured_.truth[i] != cell::PointTruth::Surface || !wanted(i))
      surfaces[i].x = std::numeric_limits<float>::quiet_NaN();
  io::VoxelFrame voxels;
  count_.voxelize(surfaces, voxels);
  noise::markTruth(voxels, truth, frame);
}

void
LabelledLidar::read(std::uint32_t revolution, LabelledFrame& frame)
{
  cell_.captureLidar(revolution, captured_);
  native_.voxelize(captured_.cloud, frame.of(Law::Native));
  count_.voxelize(captured_.cloud, frame.of(Law::Count));
  const io::VoxelFrame& voxels = frame.of(Law::Count);
  frame.truth.assign(voxels.size(), VoxelTruth::Noise);
  const std::vector<cell::Material> materials =
      cell_.lidarSurfaces(revolution).material;
  const auto is_cloth = [&](std::size_t i) {
    return materials[i] == cell::Material::Cloth;
  };
  // The later ones replace the earlier ones, as in a camera's frame.
  markTruth(is_cloth, VoxelTruth::Person, frame);
  markTruth([&](std::size_t i) { return !is_cloth(i); }, VoxelTruth::Still, frame);
}

} // namespace noise
} // namespace pcl_ext

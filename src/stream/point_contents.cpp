// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/point_contents.h"

#include "voxelizing/voxel_locator.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief The voxel of a position, from which fields are predicted; far away it is at the
 * farthest one. */
std::array<std::int32_t, 3>
viewpointOf(const Eigen::Vector3d& position, const VoxelGrid& grid)
{
  std::array<std::int32_t, 3> viewpoint{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels =
        (position[static_cast<Eigen::Index>(axis)] - grid.origin[axis]) /
            grid.resolution -
        static_cast<double>(grid.first_index[axis]);
    constexpr double far = farthest_viewpoint;
    viewpoint[axis] =
        std::isfinite(voxels)
            ? static_cast<std::int32_t>(std::clamp(std::floor(voxels), -far, far))
            : 0;
  }
  return viewpoint;
}

} // namespace

CompressionStatus
PointContents::collect(PointBatches& points,
                       const WorldPose& sensor_pose,
                       const EncoderSettings& settings,
                       std::size_t points_used,
                       VoxelFrame& frame)
{
  frame.points = FramePoints();
  if (settings.fields.empty()) {
    frame.fields.clear();
    return {};
  }
  if (CompressionStatus status = fields_.select(points.fields(), true); !status.ok())
    return status;
  if (memory_rule_.shouldRelease(64 * points_used))
    fields_.releaseMemory();
  EncoderSettings of_voxels = settings;
  of_voxels.resolution = frame.grid.resolution;
  VoxelLocator locator(of_voxels);
  if (!settings.bounding_box)
    locator.setGrid(frame.grid);
  if (CompressionStatus status = fields_.collect(points, locator, frame); !status.ok())
    return status;
  frame.viewpoint = viewpointOf(sensor_pose.translation(), frame.grid);
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::io

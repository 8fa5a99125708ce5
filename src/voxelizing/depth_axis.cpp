// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/cloud_source.h>

namespace pcl_ext::PCL_EXT_ABI::io {

DepthAxis
depthAxisOf(const WorldPose& sensor_pose)
{
  const Eigen::Vector3d sensor = sensor_pose.translation();
  const Eigen::Vector3f direction = sensor_pose.linear().col(2).cast<float>();
  return {{sensor.x(), sensor.y(), sensor.z()},
          {direction.x(), direction.y(), direction.z()}};
}

} // namespace pcl_ext::PCL_EXT_ABI::io

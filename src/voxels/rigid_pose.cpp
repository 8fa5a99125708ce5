// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/rigid_pose.h>

namespace pcl_ext::PCL_EXT_ABI {

bool
isRigid(const io::SensorPose& pose)
{
  const Eigen::Matrix3f rotation = pose.linear();
  // Comparisons with NaN are false.
  return (rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).norm() <
             1e-3f &&
         rotation.determinant() > 0.0f && pose.translation().allFinite();
}

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <Eigen/Geometry>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief Pose of a sensor in the world: sensor -> global coordinate frame, metres.
 * Accepts an Eigen::Isometry3d. Not aligned, so that its layout does not depend on the
 * vector instructions that a program is built with. */
using WorldPose = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

namespace io {

/** \brief Pose of a sensor in the coordinate frame of its clouds: sensor -> cloud,
 * metres. Accepts an Eigen::Isometry3f. Not aligned, as WorldPose. */
using SensorPose = Eigen::Transform<float, 3, Eigen::Isometry, Eigen::DontAlign>;

} // namespace io

/** \brief True if a pose is a rotation and a translation, all finite. */
inline bool
isRigid(const Eigen::Isometry3f& pose)
{
  const Eigen::Matrix3f rotation = pose.linear();
  // Comparisons with NaN are false.
  return (rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).norm() <
             1e-3f &&
         rotation.determinant() > 0.0f && pose.translation().allFinite();
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <Eigen/Geometry>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup common
 * @{ */

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
PCL_EXT_CODEC_EXPORT bool
isRigid(const io::SensorPose& pose);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

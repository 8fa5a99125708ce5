// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/rigid_pose.h>

#include "voxelizing/ray_fit.h"
#include "voxelizing/spinning_fit.h"

#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The place at which several points are, as drivers write missing ones; not finite
 * if there is none. */
Eigen::Vector3d
repeatedPlace(const std::vector<PixelPoint>& points);

/** \brief Finds where a spinning sensor is whose clouds are in other coordinates than its
 * own: each row of it is a cone, or a hyperboloid, around the axis.
 * \param[in] points some thousands, with their rows; columns are not used
 * \param[in] place of missing points; at the sensor, if it is near
 * \return sensor -> coordinates of the points, the sensor's axis being z, metres; nothing
 * if they are on the rays of a sensor at the origin that turns about z, or on those of
 * none
 */
std::optional<WorldPose>
findSpinningPose(const std::vector<PixelPoint>& points, const Eigen::Vector3d& place);

/** \brief Turns such a pose about the axis to where the columns of points are those of
 * rays that were fitted: even ones, or such whose angles are multiples of a step.
 * \param[in] points with rows of the fit, and columns
 */
WorldPose
turnedToColumns(const WorldPose& pose,
                const std::vector<PixelPoint>& points,
                const SpinningFit& fit);

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief How sensors move in the robot cell.
 */
#pragma once

#include <Eigen/Geometry>

#include <functional>

namespace pcl_ext {
namespace cell {

/** \brief Pose of a sensor over time, sensor frame -> world; the time is in seconds
 * since the stream's start, >= 0. The same time always has the same pose. */
using SensorMotion = std::function<Eigen::Isometry3d(double time)>;

/** \brief A depth camera on the hand of the arm on the rail at x = 2.6 m. It is 40 cm
 * from the flange, so that it does not see the gripper. It looks 45 degrees higher than
 * the hand, which points at the work below. It rests while the arm does. */
Eigen::Isometry3d
handCamera(double time);

/** \brief A lidar on a mobile robot, 1 m above the floor, x ahead. It drives at 1 m/s
 * along the aisle at y = 0.7 m and back at y = 1.9 m: straights of 5.6 m and half
 * circles of 0.6 m radius. The robot itself is not in the scene. */
Eigen::Isometry3d
mobileLidar(double time);

} // namespace cell
} // namespace pcl_ext

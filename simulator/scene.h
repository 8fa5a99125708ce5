// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What stands and what moves in the robot cell.
 */
#pragma once

#include "simulator/shapes.h"

namespace pcl_ext {
namespace cell {

/** \brief Length of the work cycle after which all motion repeats, seconds. */
constexpr double work_cycle = 15.0;

/** \brief A stretch of each work cycle in which nothing moves at all, seconds from the
 * cycle's start. */
constexpr double standstill_start = 6.5;
constexpr double standstill_end = 8.0;

/** \brief The hall and all equipment that never moves.
 *
 * World frame: origin at a floor corner of the 10 x 10 x 4 m cell, z up, metres. The
 * hall's walls stand outside of the cell.
 */
Solids
staticEquipment();

/** \brief The two arms on floor rails and the arm on the gantry.
 * \param[in] time seconds since the stream's start, >= 0
 */
Solids
movingMachines(double time);

/** \brief Pose of the hand of the arm on the rail at x = 2.6 m, hand -> world: the
 * origin is the flange, z runs along the hand to the gripper, x is parallel to the
 * gripper's bar, and y points down while the hand is level.
 * \param[in] time seconds since the stream's start, >= 0
 */
Eigen::Isometry3d
handPose(double time);

/** \brief The walking person.
 * \param[in] time seconds since the stream's start, >= 0
 */
Solids
walkingPerson(double time);

} // namespace cell
} // namespace pcl_ext

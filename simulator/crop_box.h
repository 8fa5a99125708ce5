// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The robot cell's crop box in the form of the library's settings.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include "simulator/robot_cell.h"

namespace pcl_ext {
namespace cell {

/** \brief The cell's crop box; see RobotCell::cropMin(). */
inline io::BoundingBox
cropBox()
{
  io::BoundingBox box;
  Eigen::Map<Eigen::Vector3d>(box.min.data()) = RobotCell::cropMin();
  Eigen::Map<Eigen::Vector3d>(box.max.data()) = RobotCell::cropMax();
  return box;
}

} // namespace cell
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/rigid_pose.h>

#include "voxelizing/camera_pixels.h"
#include "voxelizing/elevation_rows.h"
#include "voxelizing/sensor_cloud.h"

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the rows of the clouds of one stream that have no rows and columns. */
class SensorRows {
public:
  /** \brief Makes rows of the rings of a cloud. Where it has none, finds its pixels if a
   * camera has seen it, else the rings of one that a lidar has, from the elevations of
   * its points.
   * \param[in] to_sensor world -> sensor, metres
   * \param[in] may_refit what was learnt of the clouds before may be learnt again
   * \param[in,out] cloud image and pixels, or rings, are set
   * \return false if there are none
   */
  bool
  find(const WorldPose& to_sensor, bool may_refit, SensorCloud& cloud);

private:
  bool
  number(bool may_learn, std::vector<std::uint32_t>& rings);

  bool
  findRings(const WorldPose& to_sensor, bool may_refit, SensorCloud& cloud);

  std::vector<std::uint32_t> rows_of_rings_; // empty: they are the same
  CameraPixels camera_;
  ElevationRows elevations_;
  unsigned int untried_clouds_ = 0; // that follow
  unsigned int next_untried_ = 0;   // after the next one without rows
};

} // namespace pcl_ext::PCL_EXT_ABI::io

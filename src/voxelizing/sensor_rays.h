// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/rigid_pose.h>

#include "codec/scan/scan_frame.h"
#include "voxelizing/ray_fit.h"
#include "voxelizing/scan_columns.h"
#include "voxelizing/sensor_cloud.h"
#include "voxelizing/spinning_fit.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The rays of a sensor, found in one of its clouds and kept for those that
 * follow. */
class SensorRays {
public:
  /** \brief Sensor -> world, where the sensor is not where it was told to be. */
  WorldPose
  poseOf(const WorldPose& told) const
  {
    return told * moved_;
  }

  /** \brief Whether the sensor was not where it was told to be. */
  bool
  haveMoved() const
  {
    return !moved_.isApprox(WorldPose::Identity());
  }

  /** \brief Finds where the spinning sensor of a cloud with rings is.
   * \param[in] told sensor -> world, metres
   */
  void
  findPose(const SensorCloud& cloud, const WorldPose& told);

  /** \brief Finds where a sensor is now that was not where it was told before.
   * \return false if it is not found, or if the columns of its cloud would change
   */
  bool
  followPose(const SensorCloud& cloud, const WorldPose& told);

  /** \brief Finds the rays of a cloud.
   * \param[in] cloud not empty, with the pixels of its scan
   * \param[in] columns of its points, if it has rings
   * \param[in] told sensor -> world, metres
   * \param[in] may_change_depths on them, which takes an I-frame
   * \param[in] layout size and order of its scan
   * \return whether there are any
   */
  bool
  fit(const SensorCloud& cloud,
      const ScanColumns& columns,
      const WorldPose& told,
      const VoxelGrid& grid,
      bool may_change_depths,
      const scan::ScanLayout& layout);

  /** \brief Whether rays were found that a scan of this size and order may be on. */
  bool
  areOf(const scan::ScanLayout& layout) const;

  /** \brief Whether they are those of a camera. */
  bool
  arePlanar() const
  {
    return planar_.has_value();
  }

  /** \brief Sets the rays of a cloud's scan.
   * \param[in,out] frame grid, size and order are given
   * \return whether they are within their ranges
   */
  bool
  set(const SensorCloud& cloud,
      const ScanColumns& columns,
      const WorldPose& told,
      scan::ScanFrame& frame);

  /** \brief Whether the rays of points may be turned from those of their pixels, see
   * ScanFrame::turns. */
  bool
  mayTurn() const
  {
    return spinning_ && !spinning_->is_even && spinning_->has_turn_step;
  }

private:
  double
  fitCamera(const std::vector<PixelPoint>& sample,
            const WorldPose& pose,
            const VoxelGrid& grid,
            bool may_change_depths,
            scan::ScanLayout layout);

  void
  fitImage(const std::vector<PixelPoint>& points,
           const Eigen::Vector3d& place,
           const WorldPose& pose,
           const VoxelGrid& grid,
           bool may_change_depths,
           const ImageSize& size);

  void
  findAngles(const SensorCloud& cloud,
             const std::vector<std::uint32_t>& columns,
             const WorldPose& pose,
             scan::ScanFrame& frame) const;

  void
  shiftRows(scan::ScanFrame& frame);

  std::vector<std::uint16_t>
  findShifts(const scan::ScanFrame& frame) const;

  scan::ScanLayout layout_;                 // of the fit, without rays
  WorldPose moved_ = WorldPose::Identity(); // sensor -> where it was told to be
  std::optional<PlanarFit> planar_;
  PlanarDepths planar_depths_; // of the last I-frame for which they were chosen
  std::optional<SpinningFit> spinning_;
  bool is_new_ = false;               // the cloud of the fit has no rays yet
  std::vector<std::uint16_t> shifts_; // of the rows of firings
};

} // namespace pcl_ext::PCL_EXT_ABI::io

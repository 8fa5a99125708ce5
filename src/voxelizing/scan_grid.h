// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/rigid_pose.h>

#include "voxelizing/point_batches.h"
#include "voxelizing/sensor_cloud.h"

#include <array>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Edges of wide clouds are at most 2^4 times as long as the settings say. */
constexpr unsigned int most_doublings = 4;

/** \brief Edges between the points of a scan and the first of them: places are less than
 * 2^26 edges from the lowest corner of a grid of 2^21 in whose middle it may be. */
constexpr double scan_side = 0x1p26 - 0x1p20;

/** \brief The grid in whose edges the places of a stream's scans are told, which changes
 * seldom, as each change takes an I-frame. */
class ScanGrid {
public:
  /** \param[in] settings as accepted by checkSettings() */
  explicit ScanGrid(const EncoderSettings& settings);

  /** \brief Finds the step that the coordinates of a cloud are multiples of.
   * \param[in] is_i_frame_due it may be larger than before
   */
  void
  findStep(PointBatches& points, bool is_i_frame_due);

  /** \brief Whether there is such a step, on whose multiples the grid is centred. */
  bool
  hasStep() const
  {
    return step_ > 0.0;
  }

  /** \brief Takes the edge of the settings again. */
  void
  refine()
  {
    doublings_ = 0;
  }

  /** \brief Doubles the edge for the next cloud.
   * \return false if the settings do not want it
   */
  bool
  coarsen();

  /** \brief Whether edges are longer than set, as clouds are too wide. */
  bool
  isCoarsened() const
  {
    return doublings_ > 0;
  }

  /** \brief Sets the grid for a cloud: that of the settings or of the step.
   * \param[in] sensor_pose sensor -> world, metres
   * \return false if the points are too far from the origin of its lattice
   */
  bool
  setAround(const WorldPose& sensor_pose, const SensorCloud& cloud);

  /** \brief Of the last cloud; its resolution is 0 before there is one. */
  const VoxelGrid&
  grid() const
  {
    return grid_;
  }

private:
  double resolution_;
  bool may_coarsen_;
  std::optional<std::array<double, 3>> origin_; // of the settings
  bool may_have_step_;
  double step_ = 0.0;
  unsigned int doublings_ = 0; // of resolution_
  VoxelGrid grid_;
  std::array<double, 3> lattice_origin_{}; // that it is a part of
};

} // namespace pcl_ext::PCL_EXT_ABI::io

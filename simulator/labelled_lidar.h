// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Voxels of the robot cell's lidar with the truth of each voxel.
 */
#pragma once

#include "simulator/labelled_stream.h"

namespace pcl_ext {
namespace noise {

/** \brief The voxels that the lidar's computer makes of the robot cell. */
class LabelledLidar {
public:
  /** \brief The lidar's stream.
   * \param[in] seed of the cell
   * \param[in] resolution voxel edge, metres
   */
  LabelledLidar(std::uint32_t seed, double resolution);

  /** \brief A revolution, from 0; they may be asked for in any order.
   * \param[out] frame in lidar_laws. What moves is not marked in a lidar's view:
   * all surfaces are Still, except what wears cloth, which only the person does.
   */
  void
  read(std::uint32_t revolution, LabelledFrame& frame);

private:
  template <typename WantedT>
  void
  markTruth(const WantedT& wanted, VoxelTruth truth, LabelledFrame& frame);

  cell::RobotCell cell_;
  CellVoxelizer<NativeIntensity> native_;
  CellVoxelizer<CountIntensity> count_;
  cell::LidarFrame captured_;
};

} // namespace noise
} // namespace pcl_ext

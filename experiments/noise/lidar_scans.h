// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Revolutions of the robot cell's lidar, as points and as voxels with their truth.
 */
#pragma once

#include "neighbour_scores.h"
#include "simulator/labelled_stream.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief A revolution. */
struct LabelledScan {
  cell::LidarFrame frame; ///< as the sensor has it, its points in rows and columns
  Centres::Ptr returns{new Centres};        ///< the points with a return
  std::vector<std::size_t> index_of_return; ///< their places in the frame
  /** \brief Of each return; only the person wears cloth, all else is Still. */
  std::vector<VoxelTruth> truth;
  /** \brief Counts of the points; a voxel is a surface if it holds at least one point
   * of a surface. In the lidar's frame, not cropped. */
  LabelledFrame voxels;
  std::vector<std::uint32_t> voxel_of_return;
};

/** \brief Takes a revolution.
 * \param[in] revolution its number, from 0
 * \param[in] edge of the voxels, metres
 */
void
readScan(cell::RobotCell& cell,
         std::uint32_t revolution,
         double edge,
         LabelledScan& scan);

/** \brief Divides the returns of a scan into voxels, with the truth of each. */
void
voxelizeReturns(double edge, LabelledScan& scan);

} // namespace noise
} // namespace pcl_ext

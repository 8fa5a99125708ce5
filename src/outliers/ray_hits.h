// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <array>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Where a lidar that turns is, and how dense its rays are. */
struct LidarRays {
  std::array<double, 3> origin{};             ///< voxels from position 0
  std::array<double, 3> up = {0.0, 0.0, 1.0}; ///< axis of its turns, of length 1
  double azimuth_step = 0.0;                  ///< between columns, radians
  double elevation_step = 0.0;                ///< between rows, radians
};

/** \brief Rays as settings have them, of a lidar that stands upright.
 * \param[in] unit of settings that checkSettings() accepts
 * \param[in] grid of the frame
 * \param[in] first position of the grid's first voxel
 */
LidarRays
raysOf(const RaysUnit& unit, const io::VoxelGrid& grid, const io::VoxelPosition& first);

/** \brief Rays of the sensor that the points of a frame tell.
 * \param[in] sensor of the points
 * \param[in] first position of the first voxel of the frame's grid
 * \return none if it has one column or one row only, so that a step is not known
 */
std::optional<LidarRays>
raysOf(const io::SpinningSensor& sensor, const io::VoxelPosition& first);

/** \brief How many points of a surface there would be in a voxel, and the evidence for
 * one: more than noise has, which has few points in few voxels wherever it is (unit Rays
 * in doc/outlier_removal.md). */
class RayHits {
public:
  RayHits() = default;

  /** \param[in] resolution edge of a voxel, metres
   * \param[in] levels coarse voxels are 2^levels voxels wide
   * \param[in] most points that a coarse voxel is expected to have
   */
  RayHits(const LidarRays& rays, double resolution, unsigned int levels, double most);

  /** \brief The number of points that a coarse voxel of a surface has without numbers of
   * points, in which each voxel counts as one: neighbours near the sensor are expected
   * to be occupied, but not more often than that.
   * \param[in] levels of the coarse voxel
   */
  static double
  mostWithoutPoints(unsigned int levels);

  /** \brief exp((log-odds - c) / weight), see Score.
   * \param[in] coarse position of a coarse voxel
   * \param[in] own points in it
   * \param[in] near points in the other 124 of the 5 x 5 x 5 around it
   */
  float
  evidence(const io::VoxelPosition& coarse, std::int32_t own, std::int32_t near) const;

private:
  LidarRays rays_;
  double resolution_ = 1.0;
  double width_ = 1.0; // of a coarse voxel, voxels
  double most_ = 1.0;
};

} // namespace pcl_ext::PCL_EXT_ABI

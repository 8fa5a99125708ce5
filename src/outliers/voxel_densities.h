// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/depth_model.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "outliers/ray_hits.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Computes the densities of the coarse voxels of a stream from its voxels: 1 to
 * 255, in 255ths of a face with the unit Faces, in points with Points, and 255 with
 * Voxels; with Rays points, 1 to DensityBlocks::most_points. A coarse voxel is 2^levels
 * voxels wide; with levels 0 it is a voxel.
 *
 * With a depth model a face counts as covered from
 * VoxelOutlierRemoval::sure_points_per_square_metre on, if there can be as many
 * points. */
class VoxelDensities {
public:
  explicit VoxelDensities(const DensityUnitSettings& unit);

  /** \brief Whether the frame has what the unit needs. */
  bool
  canJudge(const io::VoxelFrame& frame) const;

  /** \brief Prepares for the stream's next frame.
   * \param[in] frame that canJudge() accepts; without a depth model that of an earlier
   * frame is used
   * \param[in] first position of its grid's first voxel, below 2^23 on each axis.
   * Positions of earlier frames must still be valid; else call reset() first
   * \param[in] levels of the coarse voxels; the same since reset()
   * \return false if the unit of the densities has changed
   */
  bool
  follow(const io::VoxelFrame& frame,
         const io::VoxelPosition& first,
         unsigned int levels);

  /** \brief Prepares for a new stream. */
  void
  reset()
  {
    depth_model_.reset();
    sensor_rays_.reset();
    numbers_.clear();
    factors_.clear();
  }

  /** \brief Unit of the densities, as of the last frame: Faces, Points, Voxels or
   * Rays; at first that of the settings. */
  DensityUnit
  unit() const
  {
    return unit_;
  }

  /** \brief Rays of the sensor that the points of this frame or an earlier one tell, if
   * the unit may be Rays. */
  const std::optional<LidarRays>&
  sensorRays() const
  {
    return sensor_rays_;
  }

  /** \brief Whether numbers of points are known of the frame that follow() was called
   * with, for Rays. */
  bool
  hasPoints(const io::VoxelFrame& frame) const
  {
    return frame.has_point_counts ||
           (intensities_are_counts_ && frame.hasIntensities());
  }

  /** \brief What a voxel of the frame adds to the density of its coarse voxel, in
   * 256ths; with Rays in points.
   * \param[in] frame that of follow()
   * \param[in] voxel its index
   * \param[in] position its position in the grid plus that of the grid's first voxel
   */
  std::uint32_t
  operator()(const io::VoxelFrame& frame,
             std::size_t voxel,
             const io::VoxelPosition& position) const;

  /** \brief Density of a coarse voxel.
   * \param[in] sum over its voxels, as they add to it
   */
  std::int16_t
  density(std::uint64_t sum) const;

private:
  static constexpr unsigned int depth_bits = 10; // resolution of factors_

  void
  takeDepthModel(const io::VoxelFrame& frame, const io::VoxelPosition& first);

  void
  makeFactors();

  void
  makeNumbers(const io::IntensityScale& scale);

  std::uint32_t
  pointsOf(const io::VoxelFrame& frame, std::size_t voxel) const;

  DensityUnit
  unitOf(const io::VoxelFrame& frame) const;

  DensityUnit set_unit_;
  DensityUnit unit_;                          // of the last frame
  float full_intensity_ = 0.0f;               // with Faces
  bool intensities_are_counts_ = false;       // with Automatic and Rays
  std::optional<io::DepthModel> depth_model_; // the last one, relative to position 0
  std::optional<LidarRays> sensor_rays_;      // likewise
  double model_face_ = 0.0; // intensity of a covered face in that model
  io::IntensityScale scale_;
  double face_ = 0.0; // intensity of density 255
  /** \brief By symbol the density without factor, 2^8 is 1; with Rays points. */
  std::vector<std::uint16_t> numbers_;
  std::vector<std::uint64_t>
      factors_;               // by depth in coarse voxels' cut-off depths, 2^16 is 1
  unsigned int exponent_ = 0; // of factors_
  double resolution_ = 0.0;   // of the voxels
  unsigned int levels_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "voxelizing/voxelizer.h"

#include <array>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What would hold all points of a cloud, some of which are outside the grid. */
struct WiderGrid {
  double width = 0.0;      ///< of the cloud, along its widest axis, metres
  double resolution = 0.0; ///< edge of voxels with which no point is outside, metres
};

/** \brief How the voxels of a cloud suit it. */
struct VoxelFit {
  bool is_coarsened = false; ///< voxels are larger than set, as clouds are too wide
  std::optional<WiderGrid> wider_grid; ///< none if no point is outside the grid
};

/** \brief Voxelizes the clouds of one stream with voxels that suit them: centred on the
 * steps that their coordinates are multiples of, or larger ones where clouds are too wide
 * for the grid. Other voxels than before need an I-frame. */
class CloudVoxelizer {
public:
  /** \param[in] settings as accepted by checkSettings
   * \param[in] unit unit of the point intensities
   */
  CloudVoxelizer(const EncoderSettings& settings, IntensityUnit unit);

  /** \brief Voxelizes one cloud.
   * \param[in] points the cloud
   * \param[in] is_i_frame_due voxels may change without another I-frame
   * \param[in] may_refit where an I-frame is due ignore the previous clouds, see
   * Voxelizer::voxelize
   * \param[out] frame the occupied voxels; its memory is reused
   * \return counts of the points
   */
  VoxelizationStatistics
  voxelize(PointBatches& points,
           bool is_i_frame_due,
           bool may_refit,
           VoxelFrame& frame);

  /** \brief Whether the last cloud has other voxels, or another scale, than those before:
   * its frame has to be an I-frame. */
  bool
  hasChanged() const
  {
    return has_changed_;
  }

  /** \brief How the voxels suit the last cloud. */
  VoxelFit
  fit() const
  {
    return {doublings_ > 0, wider_grid_};
  }

private:
  bool
  takesIFrame() const
  {
    return is_i_frame_due_ || has_changed_;
  }

  void
  takeEdge(double resolution, const std::optional<std::array<double, 3>>& origin);

  void
  voxelizeAsBefore(PointBatches& points, VoxelFrame& frame);

  bool
  fitCoordinateStep(PointBatches& points);

  double
  findStep(PointBatches& points);

  void
  voxelizeWide(PointBatches& points, VoxelFrame& frame);

  void
  voxelizeCoarsened(PointBatches& points, unsigned int doublings, VoxelFrame& frame);

  EncoderSettings settings_;
  IntensityUnit unit_;
  Voxelizer voxelizer_;
  unsigned int doublings_ = 0;   // of the resolution of voxelizer_
  double coordinate_step_ = 0.0; // its resolution, metres, if above 0
  /** \brief Multiples of it are counted from near here, metres: from the world's origin,
   * if that is near. */
  std::array<double, 3> middle_{};
  // Of the last cloud:
  bool is_i_frame_due_ = true; // whether or not it has changed
  bool has_changed_ = false;
  bool may_refit_ = true;
  VoxelizationStatistics statistics_;
  std::optional<WiderGrid> wider_grid_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

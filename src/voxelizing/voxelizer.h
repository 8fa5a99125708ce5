// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <memory>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Converts clouds to the occupied voxels of a grid, each with an intensity, the
 * mean colour of its points and their number, as the settings say.
 *
 * Voxel (i, j, k) covers [i d_v, (i+1) d_v) x ... from the origin of the grid, computed
 * in double precision from the coordinates. Points more than 2^20 voxels from the
 * origin, outside the fixed box, or not finite are counted and left out. Memory and
 * time are at most proportional to the number of points, for any coordinates.
 *
 * The origin is the world's, unless the settings have another one or clouds lie
 * further out: then it is a corner of a voxel of the world's origin amid the points.
 *
 * Without a fixed box the grid is fitted to the points. It grows if later points
 * require it and does not change otherwise, as a changed grid requires an I-frame. The
 * scale of native intensities is adapted in the same way.
 */
class PCL_EXT_CODEC_EXPORT Voxelizer {
public:
  /** \brief A voxelizer for the clouds of one stream.
   * \param[in] settings as accepted by checkSettings
   * \param[in] unit unit of the point intensities
   */
  Voxelizer(const EncoderSettings& settings, IntensityUnit unit);
  ~Voxelizer();
  Voxelizer(Voxelizer&&) noexcept;
  Voxelizer&
  operator=(Voxelizer&&) noexcept;

  /** \brief Voxelizes one cloud.
   * \param[in] points the cloud
   * \param[in] may_refit ignore the previous clouds: a grid that is far too large and
   * the scale of native intensities are fitted again; requires an I-frame unless one is
   * due
   * \param[out] frame the occupied voxels; its memory is reused
   * \return counts of the points
   */
  VoxelizationStatistics
  voxelize(const PointView& points, bool may_refit, VoxelFrame& frame);

  /** \brief The same for a cloud in batches. What their functions throw is passed
   * on. */
  VoxelizationStatistics
  voxelize(PointBatches& points, bool may_refit, VoxelFrame& frame);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include "codec/scan/scan_frame.h"
#include "voxelizing/field_collector.h"
#include "voxelizing/intensity_quantiser.h"
#include "voxelizing/scan_columns.h"
#include "voxelizing/scan_grid.h"
#include "voxelizing/sensor_cloud.h"
#include "voxelizing/sensor_rays.h"
#include "voxelizing/sensor_rows.h"

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The status of a cloud whose points are not coded in their order. */
CompressionStatus
orderStatus(const std::string& reason);

/** \brief Makes scans of the clouds of one stream: on the rays of a sensor if there are
 * some, or near them, else as a sequence of points without rays. */
class ScanCollector {
public:
  /** \param[in] settings as accepted by checkSettings()
   * \param[in] unit of the point intensities
   */
  ScanCollector(const EncoderSettings& settings, IntensityUnit unit);

  /** \brief Whether settings and unit allow scans: points have an intensity of their own,
   * and are kept. */
  static bool
  isPossible(const EncoderSettings& settings, IntensityUnit unit);

  /** \brief Makes the scan of a cloud.
   * \param[in] fields that are selected
   * \param[in] sensor_pose sensor -> world, metres
   * \param[in] is_i_frame_due rays may change without another I-frame
   * \param[in,out] scan that of the last cloud; set to one of a consistent layout
   * \param[out] statistics counts of the points
   * \param[out] status InvalidInput for fields that cannot be kept; or why there is no
   * scan, if the cloud has points
   * \return false if there is none
   */
  bool
  collect(PointBatches& points,
          const FieldCollector& fields,
          const WorldPose& sensor_pose,
          bool is_i_frame_due,
          scan::ScanFrame& scan,
          VoxelizationStatistics& statistics,
          CompressionStatus& status);

  /** \brief Whether the rays of before fit the last cloud much worse than the one that
   * they were found in, so that the next frame had better be an I-frame. */
  bool
  wantsOtherRays() const
  {
    return wants_other_rays_;
  }

  /** \brief Whether the edges of the last cloud are longer than set, as it is wide. */
  bool
  isCoarsened() const
  {
    return grid_.isCoarsened();
  }

  void
  releaseMemory();

private:
  std::uint64_t
  mostPixels(const FieldCollector& fields) const;

  bool
  locateInGrid(const WorldPose& sensor_pose,
               bool is_i_frame_due,
               scan::ScanFrame& scan);

  bool
  locateOnRays(const WorldPose& sensor_pose,
               bool is_i_frame_due,
               scan::ScanFrame& scan);

  bool
  fitsLayout(const scan::ScanFrame& scan) const;

  bool
  setLayout(const WorldPose& sensor_pose, bool is_i_frame_due, scan::ScanFrame& scan);

  bool
  locateFree(const WorldPose& sensor_pose, bool is_i_frame_due, scan::ScanFrame& scan);

  bool
  orderPoints(const scan::ScanFrame& scan);

  bool
  locate(const WorldPose& sensor_pose, bool refits, scan::ScanFrame& scan);

  bool
  locateAll(scan::ScanFrame& scan) const;

  std::size_t
  setIntensities(bool may_refit, scan::ScanFrame& scan, std::size_t& vanished);

  void
  setColours(scan::ScanFrame& scan) const;

  CompressionStatus
  setFields(const FieldCollector& fields, scan::ScanFrame& scan) const;

  EncoderSettings settings_;
  IntensityUnit unit_;
  SensorCloudReader reader_;
  SensorRows rows_;
  unsigned int untried_i_frames_ = 0; // that follow: no rays are looked for
  unsigned int next_untried_ = 0;     // after the next one in which none are found
  std::size_t tried_points_ = 0;      // of the last cloud in which none were found
  ScanColumns columns_;
  SensorRays rays_;
  bool has_layout_ = false;  // the scan's layout is that of one that was collected
  bool was_free_ = false;    // the scan before had no rays
  bool was_on_rays_ = false; // the cloud before was
  std::uint32_t period_ = 0; // of its points; 0: none
  std::array<double, 3> phases_{}; // see findPhases()
  IntensityQuantiser quantiser_;
  ScanGrid grid_;
  double fitted_share_ = 0.0; // of points beside the rays that were fitted, or turned
  std::size_t fitted_points_ = 0; // that they were fitted to
  bool wants_other_rays_ = false;
  // Of the current cloud; members so that their memory is reused.
  SensorCloud cloud_;
  std::uint64_t most_pixels_ = 0;    // that its scan may have
  std::vector<std::uint32_t> order_; // points in the order of their pixels
  std::vector<std::uint32_t> by_pixel_;
  VoxelFrame symbols_; // scale and symbols of intensities, in the order of the cloud
};

} // namespace pcl_ext::PCL_EXT_ABI::io

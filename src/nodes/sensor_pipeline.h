// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/rate_control.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "filters/cloud_outliers.h"

#include <memory>
#include <optional>

namespace pcl_ext {
namespace nodes {

/** \brief The points of clouds, moved, cropped and with the intensities of a law. */
class SensorPoints {
public:
  virtual ~SensorPoints() = default;

  /** \brief See PreprocessedBatches::open. */
  virtual PreprocessingStatus
  open(const Eigen::Isometry3d& sensor_pose, const pcl::PCLPointCloud2& cloud) = 0;

  virtual io::PointBatches&
  batches() = 0;

  virtual PreprocessingStatistics
  statistics() const = 0;
};

/** \brief The law of the points' intensities at the resolution of the settings, if it
 * depends on the depth. */
std::optional<io::DepthLaw>
depthLaw(const SensorNodeSettings& settings);

/** \brief The stages before and after voxelizing. Created again after memory ran out in
 * them. */
struct SensorFilters {
  explicit SensorFilters(const SensorNodeSettings& settings);

  std::unique_ptr<SensorPoints> points;
  /** \brief All points, for the temporal filter; null where it stays off, and without a
   * crop box. */
  std::unique_ptr<SensorPoints> uncropped;
  std::optional<VoxelOutlierRemoval> outlier_removal;
  std::optional<PointOutlierRemoval> point_outlier_removal;
  CloudOutliers outliers;
  pcl::PCLPointCloud2 cloud; // without the outliers
};

/** \brief Members that exist only if the settings are valid. */
struct SensorPipeline {
  explicit SensorPipeline(const SensorNodeSettings& settings);

  io::CloudEncoder encoder;
  io::RateControl rate_control;
  std::optional<SensorFilters> filters;
  // Members so that their memory is reused.
  io::VoxelFrame frame;
  std::optional<io::FrameStamp> stamp;
};

} // namespace nodes
} // namespace pcl_ext

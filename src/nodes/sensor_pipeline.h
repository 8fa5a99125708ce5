// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "filters/cloud_outliers.h"

#include <memory>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::nodes {

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

/** \brief The stages before and after voxelizing. */
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

/** \brief The clouds of a SensorNode for io::CloudEncoder: moved to the world, cropped,
 * with the intensities of the law, and without outliers. */
class SensorSource : public io::CloudSource {
public:
  /** \param[in] settings as accepted by checkSettings() */
  explicit SensorSource(const SensorNodeSettings& settings);

  /** \brief Sets the next cloud. Both must stay until it is encoded. */
  void
  setCloud(const pcl::PCLPointCloud2& cloud, const WorldPose& sensor_to_world);

  std::optional<io::DepthLaw>
  takeStep(const io::EncoderSettings& step,
           const std::optional<float>& min_log_odds) override;

  /** \return InvalidInput for a cloud whose fields or sizes are invalid */
  io::CompressionStatus
  open(io::OpenedCloud& opened) override;

  bool
  removesNoise() const override
  {
    return filters_->outlier_removal && !judges_points_;
  }

  void
  removeNoise(io::VoxelFrame& frame) override;

  /** \brief Makes all stages again, after memory ran out in one of them. */
  void
  reset()
  {
    filters_.reset();
  }

  /** \brief Whether open() refused the last cloud. */
  bool
  isCloudInvalid() const
  {
    return is_cloud_invalid_;
  }

  /** \brief Whether outliers of the last cloud were to be removed, and neither its points
   * nor voxels of its edge could be judged. */
  bool
  doOutliersStay() const
  {
    return settings_.outlier_removal && !filters_->outlier_removal && !judges_points_;
  }

  /** \brief Sets what the statistics of a node tell of the last cloud. */
  void
  describe(SensorNodeStatistics& statistics) const;

private:
  OutlierRemovalStatus
  judgePoints();

  std::optional<VoxelOutlierRemovalSettings> removal_; // of the first step
  SensorNodeSettings settings_;                        // of the step
  std::optional<SensorFilters> filters_;
  // Of the current cloud:
  const pcl::PCLPointCloud2* cloud_ = nullptr;
  const WorldPose* sensor_to_world_ = nullptr;
  bool is_cloud_invalid_ = false;
  bool judges_points_ = false;
  std::size_t points_removed_ = 0;
  std::size_t voxels_removed_ = 0;
};

io::CloudEncoder
makeEncoder(const SensorNodeSettings& settings);

} // namespace pcl_ext::PCL_EXT_ABI::nodes

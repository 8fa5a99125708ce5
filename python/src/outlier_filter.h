// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/intensity/intensity_law.h>

#include "cloud_columns.h"
#include "shared_filter.h"
#include "temporal_filter.h"

#include <chrono>
#include <optional>
#include <vector>

namespace pcl_ext::python {

class OutlierFilter : public SharedFilter<VoxelOutlierRemoval, OutlierRemovalStatus> {
public:
  explicit OutlierFilter(const VoxelOutlierRemovalSettings& settings)
  : SharedFilter(settings), settings_(settings)
  {}

  /** \brief Tells what is known of the stream, before its first frame: the law of its
   * intensities and whether it is a lidar's, which the unit Automatic follows.
   * \throws std::invalid_argument if the unit cannot judge such intensities */
  void
  setStream(const std::optional<IntensityLaw>& law, bool is_of_lidar);

  void
  reset();

  /** \brief Filters the stream's next frame. */
  void
  filter(io::VoxelFrame& frame);

  /** \brief Log-odds of the voxels of the stream's next frame. */
  std::vector<float>
  score(const io::VoxelFrame& frame);

  /** \brief What the last frame was judged by. */
  DensityUnit
  unit() const;

private:
  VoxelOutlierRemovalSettings settings_;
  std::optional<IntensityLaw> law_; // of the stream
  bool is_of_lidar_ = false;
  bool is_begun_ = false; // the stream has had a frame
};

class PointFilter : public SharedFilter<PointOutlierRemoval, OutlierRemovalStatus> {
public:
  using SharedFilter::SharedFilter;

  /** \brief Log-odds of the points of the sensor's next cloud. */
  std::vector<float>
  score(const CloudColumns& cloud);

private:
  CloudMemory memory_;
};

/** \brief What to do with a decoded frame, in the order in which an encoder does it. */
struct Denoising {
  OutlierFilter* outliers = nullptr;         ///< applied first
  std::optional<float> min_intensity;        ///< voxels below are removed at last
  TemporalFilter* temporal_filter = nullptr; ///< applied after the outliers' removal

  /** \param[in] time see TemporalFilter::filter() */
  void
  apply(io::VoxelFrame& frame,
        const std::optional<std::chrono::nanoseconds>& time) const;
};

} // namespace pcl_ext::python

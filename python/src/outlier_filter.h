// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "cloud_columns.h"
#include "temporal_filter.h"

#include <mutex>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace python {

/** \brief A VoxelOutlierRemoval that any thread may use. Not to be called with the GIL
 * held, as a call may wait for another thread. */
class OutlierFilter {
public:
  explicit OutlierFilter(const VoxelOutlierRemovalSettings& settings)
  : removal_(settings)
  {}

  /** \brief Filters the stream's next frame. */
  void
  filter(io::VoxelFrame& frame);

  /** \brief Log-odds of the voxels of the stream's next frame. */
  std::vector<float>
  score(const io::VoxelFrame& frame);

  void
  reset();

  /** \brief What the last frame was judged by. */
  DensityUnit
  unit() const;

  /** \brief Outcome of the last call. */
  OutlierRemovalStatus
  status() const;

private:
  mutable std::mutex mutex_;
  VoxelOutlierRemoval removal_;
  OutlierRemovalStatus status_;
};

/** \brief A PointOutlierRemoval that any thread may use; likewise. */
class PointFilter {
public:
  explicit PointFilter(const PointOutlierRemovalSettings& settings) : removal_(settings)
  {}

  /** \brief Log-odds of the points of the sensor's next cloud. */
  std::vector<float>
  score(const CloudColumns& cloud);

  void
  reset();

  /** \brief Outcome of the last call. */
  OutlierRemovalStatus
  status() const;

private:
  mutable std::mutex mutex_;
  PointOutlierRemoval removal_;
  CloudMemory memory_;
  OutlierRemovalStatus status_;
};

/** \brief What to do with a decoded frame, in the order in which an encoder does it. */
struct Denoising {
  OutlierFilter* outliers = nullptr;         ///< applied first
  std::optional<float> min_intensity;        ///< voxels below are removed at last
  TemporalFilter* temporal_filter = nullptr; ///< applied after the outliers' removal

  void
  apply(io::VoxelFrame& frame) const;
};

} // namespace python
} // namespace pcl_ext

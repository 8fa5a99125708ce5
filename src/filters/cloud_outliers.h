// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <pcl/PCLPointCloud2.h>

#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Finds noise in the air in the clouds of a lidar. */
class CloudOutliers {
public:
  /** \brief Judges a cloud's points; see removeOutliers(). */
  OutlierRemovalStatus
  find(const pcl::PCLPointCloud2& cloud, PointOutlierRemoval& removal);

  /** \brief Sets the coordinates of the noise that was found to NaN. Those that are
   * whole numbers, or of several types, become real ones behind the other bytes of a
   * point. */
  void
  hide(pcl::PCLPointCloud2& cloud);

  /** \brief Erases the noise that was found; the cloud becomes one row. */
  void
  erase(pcl::PCLPointCloud2& cloud) const;

private:
  template <typename NumberT>
  void
  makeReal(pcl::PCLPointCloud2& cloud);

  template <typename NumberT>
  void
  hideAs(pcl::PCLPointCloud2& cloud);

  template <typename NumberT>
  const NumberT*
  readCoordinates(const pcl::PCLPointCloud2& cloud,
                  std::vector<NumberT>& coordinates) const;

  std::size_t
  offsetOf(const pcl::PCLPointCloud2& cloud, std::size_t point) const;

  PointLayout layout_;
  std::vector<bool> are_outliers_;
  // Members so that their memory is reused.
  std::vector<float> coordinates_;
  std::vector<double> double_coordinates_;
  std::vector<float> log_odds_;
};

} // namespace pcl_ext::PCL_EXT_ABI

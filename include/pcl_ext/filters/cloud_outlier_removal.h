// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/filters/point_outlier_removal.h>

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup filters
 * @{ */

/** \brief Removes noise in the air from a lidar's cloud: PointOutlierRemoval for users
 * of PCL. Call it once for each cloud of a sensor, in order, before they are moved into
 * another coordinate frame:
 * \code
 * const auto status = pcl_ext::removeOutliers(cloud, removal);
 * if (!status.ok())
 *   std::cerr << status.message() << '\n';
 * \endcode
 * \param[in,out] cloud in the sensor's coordinates, with rows and columns, or a field
 * `ring` of one value. An organised cloud keeps them, and the coordinates of noise
 * become NaN, for which whole numbers become real ones; from others noise is erased
 * \param[in,out] removal the filter of this sensor
 * \return that of PointOutlierRemoval::score(), or InvalidCloud; unless Ok the cloud is
 * not changed
 */
[[nodiscard]] PCL_EXT_EXPORT OutlierRemovalStatus
removeOutliers(pcl::PCLPointCloud2& cloud, PointOutlierRemoval& removal);

/** \brief The same for a typed cloud. */
template <typename PointT>
[[nodiscard]] OutlierRemovalStatus
removeOutliers(pcl::PointCloud<PointT>& cloud, PointOutlierRemoval& removal)
{
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  OutlierRemovalStatus status = removeOutliers(message, removal);
  if (status.ok() && status.removed > 0) {
    // Which belong to the cloud, not to its points.
    const auto origin = cloud.sensor_origin_;
    const auto orientation = cloud.sensor_orientation_;
    // Which PCL does not convert if there are none.
    if (message.width == 0)
      cloud.clear();
    else
      pcl::fromPCLPointCloud2(message, cloud);
    cloud.sensor_origin_ = origin;
    cloud.sensor_orientation_ = orientation;
  }
  return status;
}

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

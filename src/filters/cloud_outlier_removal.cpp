// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/cloud_outlier_removal.h>

#include "filters/cloud_outliers.h"

namespace pcl_ext::PCL_EXT_ABI {

OutlierRemovalStatus
removeOutliers(pcl::PCLPointCloud2& cloud, PointOutlierRemoval& removal)
{
  CloudOutliers outliers;
  OutlierRemovalStatus status = outliers.find(cloud, removal);
  if (status.removed == 0)
    return status;
  if (cloud.height > 1)
    outliers.hide(cloud);
  else
    outliers.erase(cloud);
  return status;
}

} // namespace pcl_ext::PCL_EXT_ABI

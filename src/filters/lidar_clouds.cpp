// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/lidar_clouds.h>

#include "filters/cloud_outliers.h"

#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI {

bool
isOfLidar(const pcl::PCLPointCloud2& cloud)
{
  constexpr std::uint64_t most_points = std::uint64_t{1} << 20;
  if (std::uint64_t{cloud.width} * cloud.height > most_points)
    return false;
  PointOutlierRemoval removal;
  return CloudOutliers().find(cloud, removal).ok();
}

} // namespace pcl_ext::PCL_EXT_ABI

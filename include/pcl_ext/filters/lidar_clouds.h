// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <pcl/PCLPointCloud2.h>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief Whether a cloud is that of a lidar that turns: its points have the rows by
 * which a PointOutlierRemoval judges them.
 * \param[in] cloud in the sensor's coordinates, with x, y, z as FLOAT32 or FLOAT64; of
 * more than 2^20 points, which such lidars do not have in a turn, the answer is false
 */
PCL_EXT_EXPORT bool
isOfLidar(const pcl::PCLPointCloud2& cloud);

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

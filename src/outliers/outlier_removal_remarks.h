// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/status.h>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Status of frames whose voxel edge, metres, is not supported. */
OutlierRemovalStatus
unsupportedResolution(double resolution);

/** \brief Status of frames without what a unit needs. */
OutlierRemovalStatus
noDensities(DensityUnit unit);

/** \brief Ok, with a message where the settings do not say what was done.
 * \param[in] set unit of the settings
 * \param[in] used unit that the frame was judged by
 */
OutlierRemovalStatus
judgement(const io::VoxelFrame& frame, DensityUnit set, DensityUnit used);

/** \brief A status with a warning of another one, too. */
OutlierRemovalStatus
withWarning(const OutlierRemovalStatus& status, const io::CompressionStatus& other);

} // namespace pcl_ext::PCL_EXT_ABI

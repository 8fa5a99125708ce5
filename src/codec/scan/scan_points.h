// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/scan/scan_frame.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Moves the points of a decoded scan into a frame, without voxels.
 * \param[in,out] scan isConsistent(); its points are given up
 * \param[in,out] frame its memory is reused
 */
void
movePoints(ScanFrame& scan, VoxelFrame& frame);

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

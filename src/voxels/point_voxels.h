// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Sets the voxels of a frame that has its points, if it has none: with the mean
 * intensity and colour of their points. Points and fields are put in the order of the
 * voxels; points outside the grid are left out and counted in FramePoints::outside_grid,
 * without gaps in a single row. */
PCL_EXT_CODEC_EXPORT void
setVoxels(VoxelFrame& frame);

/** \brief Ok; with a warning where setVoxels() has left points of the frame out. Without
 * memory for that there is no warning. */
PCL_EXT_CODEC_EXPORT CompressionStatus
statusOfVoxels(const VoxelFrame& frame);

/** \brief Numbers the points of a cloud of one row anew in their order, after some were
 * removed, as it has no missing points. */
PCL_EXT_CODEC_EXPORT void
closeGaps(FramePoints& points);

} // namespace pcl_ext::PCL_EXT_ABI::io

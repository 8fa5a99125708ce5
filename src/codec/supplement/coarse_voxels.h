// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief For how many of the lowest levels of the octree its voxels are better coded
 * within coarse voxels of 2^levels voxels along each axis.
 *
 * 0 unless most voxels are alone among their siblings, and voxels are no larger than
 * 5 mm: those are within the noise of sensors, and do not come again in the next frame.
 * \param[in] frame consistent
 * \return 0..depth of the grid - 1
 */
unsigned int
chooseRefinement(const VoxelFrame& frame);

/** \brief The coarse voxels of voxels.
 * \param[in] keys Morton keys of the voxels, ascending
 * \param[in] levels of the octree within a coarse voxel
 * \param[out] coarse_voxels their keys, strictly ascending
 */
void
coarseVoxelsOf(const std::vector<std::uint64_t>& keys,
               unsigned int levels,
               std::vector<std::uint64_t>& coarse_voxels);

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io

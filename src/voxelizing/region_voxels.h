#pragma once

#include <pcl_ext/compression/region_settings.h>
#include <pcl_ext/compression/voxel_regions.h>
#include <pcl_ext/rigid_pose.h>

#include "voxelizing/voxel_sums.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Most doublings that any region has; 0 without regions. */
unsigned int
mostDoublings(const RegionSettings& settings);

/** \brief Regions in the voxels of a grid.
 * \param[in] settings as accepted by checkSettings, with any region
 * \param[in] sensor_pose sensor -> world; what is too far away is taken as the farthest
 * that regions can be
 * \param[in] grid its lattice is that of the regions
 */
VoxelRegions
regionsOn(const VoxelGrid& grid,
          const RegionSettings& settings,
          const WorldPose& sensor_pose);

/** \brief Replaces voxels by the coarse ones that they are in.
 * \param[in] grid aligned to the regions
 * \param[in,out] keys ascending
 * \param[in] share_exponent of the law of intensities that are shares of a face, which
 * become those of the coarse voxel's; 0 for others
 * \param[in,out] sums of the points in each voxel
 * \return number of points that are left out
 */
std::size_t
mergeVoxels(const VoxelGrid& grid,
            const VoxelRegions& regions,
            unsigned int share_exponent,
            std::vector<std::uint64_t>& keys,
            VoxelSums& sums);

} // namespace io
} // namespace pcl_ext

#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <cstddef>

namespace pcl_ext {

/** \brief Takes voxels of little intensity for noise and removes them (section 2.7 of the
 * paper); what a PassThrough on `intensity` does to decoded clouds.
 * \param[in,out] frame as isConsistent() asks; the voxels that stay keep their order
 * \param[in] min_intensity voxels below it are removed, in the unit of the frame's
 * intensities
 * \return number of voxels removed
 */
PCL_EXT_EXPORT std::size_t
removeFaintVoxels(io::VoxelFrame& frame, float min_intensity);

/** \brief The same into another frame, where many streams share the memory that they decode
 * into and keep only what stays.
 * \param[in] frame as isConsistent() asks
 * \param[in] min_intensity as above
 * \param[out] kept the frame without its faint voxels; not `frame` itself
 * \return number of voxels left out
 */
PCL_EXT_EXPORT std::size_t
removeFaintVoxels(const io::VoxelFrame& frame,
                  float min_intensity,
                  io::VoxelFrame& kept);

} // namespace pcl_ext

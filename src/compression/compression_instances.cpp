// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Instances of the class with PCL's interface, for PCL's usual point types.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#if !PCL_EXT_USES_INSTANCES && !defined(PCL_EXT_NO_INSTANCES)
#error                                                                                 \
    "the flags have changed since CMake looked: delete PCL_EXT_HAS_INSTANCES in its cache"
#endif

#if PCL_EXT_USES_INSTANCES

namespace pcl_ext::PCL_EXT_ABI::io {

template class OctreePointCloudIntensityCompression<pcl::PointXYZ>;
template class OctreePointCloudIntensityCompression<pcl::PointXYZI>;
template class OctreePointCloudIntensityCompression<pcl::PointXYZRGB>;
template class OctreePointCloudIntensityCompression<pcl::PointXYZRGBA>;

} // namespace pcl_ext::PCL_EXT_ABI::io

#endif

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Instances of PCL's octrees with leaves of intensities, for PCL's point types.
 */
#include <pcl_ext/export.h>
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>
#include <pcl_ext/point_types.h>

#include <pcl/impl/instantiate.hpp>

#if PCL_EXT_USES_INSTANCES

namespace {

using Leaf = pcl_ext::octree::IntensityLeaf;
using Branch = pcl::octree::OctreeContainerEmpty;

} // namespace

template class PCL_EXT_EXPORT pcl::octree::OctreeBase<Leaf, Branch>;
template class PCL_EXT_EXPORT pcl::octree::Octree2BufBase<Leaf, Branch>;

#define PCL_INSTANTIATE_OctreesWithIntensity(PointT)                                   \
  template class PCL_EXT_EXPORT pcl::octree::                                          \
      OctreePointCloud<PointT, Leaf, Branch, pcl::octree::OctreeBase<Leaf, Branch>>;   \
  template class PCL_EXT_EXPORT                                                        \
      pcl::octree::OctreePointCloud<PointT,                                            \
                                    Leaf,                                              \
                                    Branch,                                            \
                                    pcl::octree::Octree2BufBase<Leaf, Branch>>;

PCL_INSTANTIATE(OctreesWithIntensity, PCL_XYZ_POINT_TYPES(pcl_ext::PointXYZRGBI))

#endif

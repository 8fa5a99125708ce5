// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What programs include that have a point type, leaf or branch of their own.
 */
#pragma once

#include <pcl_ext/octree/octree_pointcloud_intensity.h>

#include <pcl/octree/impl/octree2buf_base.hpp>
#include <pcl/octree/impl/octree_base.hpp>
#include <pcl/octree/impl/octree_pointcloud.hpp>

namespace pcl_ext::PCL_EXT_ABI::octree::detail {

template <typename PointT>
struct OctreeFunctions {};

} // namespace pcl_ext::PCL_EXT_ABI::octree::detail

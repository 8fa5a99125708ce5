// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Does not compile: mistakes with intensity models and point types, each of
 * which a static_assert answers with its remedy. The test compares the compiler's
 * messages.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <pcl/point_types.h>

namespace {

using pcl_ext::io::OctreePointCloudIntensityCompression;

template <typename PointT, typename... ArgumentsT>
void
construct()
{
  OctreePointCloudIntensityCompression<PointT, ArgumentsT...> compression;
}

struct DoublePoint {
  double x, y, z;
};

struct OwnPoint {
  float x, y, z;
};

} // namespace

void
makeMistakes()
{
  // PCL's order of template arguments.
  construct<pcl::PointXYZI, pcl_ext::octree::IntensityLeaf>();
  construct<pcl::PointXYZI, pcl_ext::KinectV2>();
  construct<pcl::PointXYZ, pcl_ext::NativeIntensity>();
  construct<pcl::PointXYZI, pcl_ext::QuadraticLaw>();
  construct<pcl::PointXYZI,
            pcl_ext::IntensityModel<pcl_ext::RuntimeSensor, pcl_ext::QuadraticLaw>>();
  construct<pcl::PointXYZI,
            pcl_ext::IntensityModel<pcl_ext::QuadraticLaw, pcl_ext::KinectV2>>();
  construct<pcl::PointXYZI,
            pcl_ext::IntensityModel<pcl_ext::UnspecifiedSensor, pcl_ext::LinearLaw>>();
  pcl_ext::octree::OctreePointCloudIntensity<OwnPoint> octree(0.1);
  pcl_ext::pointViewOf(pcl::PointCloud<DoublePoint>());
}

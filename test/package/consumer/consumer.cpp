// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// The class and the preprocessor, used by another project.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <iostream>
#include <sstream>

int
main()
{
  pcl::PointCloud<pcl::PointNormal>::Ptr cloud(new pcl::PointCloud<pcl::PointNormal>);
  cloud->resize(1000);
  for (std::size_t i = 0; i < cloud->size(); ++i)
    (*cloud)[i].x = 0.01f * static_cast<float>(i);
  pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointNormal> compression(
      pcl::io::MANUAL_CONFIGURATION, false, 0.1, 0.1, true);
  std::stringstream bytes;
  pcl::PointCloud<pcl::PointNormal>::Ptr decoded;
  const auto encoded = compression.encodePointCloud(cloud, bytes);
  const auto status = compression.decodePointCloud(bytes, decoded);
  std::cout << decoded->size() << " voxels " << encoded.message() << status.message()
            << '\n';
  return decoded->size() == 100 ? 0 : 1;
}

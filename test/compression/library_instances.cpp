// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Coding of clouds of PCL's usual point types, as a program of users: built with the
// library's instances of the class, and with -mavx2, where it has its own. Each frees
// memory of points that the class allocated, and the reverse. Ends with 1 where a cloud
// does not come back, and with 77 on a processor without AVX2.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <iostream>
#include <vector>

namespace {

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
cloudOf(std::size_t size)
{
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  for (std::size_t i = 0; i < size; ++i) {
    PointT point;
    point.x = 0.1f * (static_cast<float>(i) + 0.5f);
    point.y = point.z = 0.05f;
    cloud->push_back(point);
  }
  return cloud;
}

template <typename PointT>
bool
comesBack()
{
  pcl_ext::io::IntensityCompressionSettings settings;
  settings.resolution = 0.1;
  settings.retain_octree = true;
  pcl_ext::io::OctreePointCloudIntensityCompression<PointT> encoder(settings);
  pcl_ext::io::OctreePointCloudIntensityCompression<PointT> decoder(settings);
  typename pcl::PointCloud<PointT>::Ptr decoded(new pcl::PointCloud<PointT>);
  std::vector<std::uint8_t> bytes;
  for (const std::size_t size : {10u, 1000u, 3u}) {
    const auto cloud = cloudOf<PointT>(size);
    if (!encoder.encodePointCloud(cloud, bytes).ok() ||
        !decoder.decodePointCloud(bytes.data(), bytes.size(), decoded).ok() ||
        decoded->size() != size || decoder.getLeafCount() != size)
      return false;
    for (std::size_t i = 0; i < size; ++i)
      if (decoder.getVoxelDensityAtPoint((*cloud)[i]) != 1)
        return false;
    typename decltype(decoder)::Base::AlignedPointTVector centres;
    if (decoder.getOccupiedVoxelCenters(centres) != size)
      return false;
    decoded->insert(decoded->end(), 5000, PointT());
  }
  decoded.reset(); // the next one is allocated by the class
  return encoder.encodePointCloud(cloudOf<PointT>(7), bytes).ok() &&
         decoder.decodePointCloud(bytes.data(), bytes.size(), decoded).ok() &&
         decoded->size() == 7;
}

} // namespace

int
main()
{
#if defined(__AVX2__)
  if (!__builtin_cpu_supports("avx2"))
    return 77;
#endif
  const bool all_come_back =
      comesBack<pcl::PointXYZ>() && comesBack<pcl::PointXYZI>() &&
      comesBack<pcl::PointXYZRGB>() && comesBack<pcl::PointXYZRGBA>();
  std::cout << (all_come_back ? "all clouds came back\n" : "a cloud is another\n");
  return all_come_back ? 0 : 1;
}

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// A sensor that has no type in the library, one whose figures come from a parameter
// file, and an intensity model of one's own.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <cmath>
#include <iostream>
#include <sstream>

// Any type with these four members is a sensor.
struct WideCamera {
  static constexpr double fov_x_deg = 120.0;
  static constexpr double fov_y_deg = 120.0;
  static constexpr unsigned int columns = 1024;
  static constexpr unsigned int rows = 1024;
};

// Trusts a point the less, the further away it is: the contract of
// pcl_ext::IntensityModel, written out.
class FadingTrust {
public:
  static constexpr pcl_ext::IntensityUnit unit = pcl_ext::IntensityUnit::Share;
  static constexpr bool uses_depth = true;
  static constexpr bool uses_native = false;

  explicit FadingTrust(double /*resolution*/) {}

  float
  operator()(float depth, float /*native*/) const
  {
    return std::exp(-depth / 4.0f);
  }
};

int
main()
{
  const double resolution = 0.05; // m
  const pcl_ext::IntensityModel<WideCamera, pcl_ext::QuadraticLaw> known(resolution);
  const pcl_ext::RuntimeSensor from_file(120.0, 120.0, 1024, 1024);
  const pcl_ext::IntensityModel<pcl_ext::RuntimeSensor, pcl_ext::LinearLaw> read(
      resolution, from_file);
  const FadingTrust own(resolution);
  std::cout << "depth m  quadratic  linear  own\n";
  for (const float z : {1.0f, 2.0f, 4.0f, 8.0f})
    std::cout << z << "  " << known(z) << "  " << read(z) << "  " << own(z, 0.0f)
              << '\n';

  using PointT = pcl::PointXYZI;
  pcl_ext::io::IntensityCompressionSettings settings;
  settings.resolution = resolution;
  pcl_ext::io::OctreePointCloudIntensityCompression<PointT, FadingTrust> compression(
      settings);
  const pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  for (const float z : {1.0f, 2.0f, 4.0f, 8.0f})
    cloud->emplace_back(0.0f, 0.0f, z, 0.0f);

  std::stringstream bytes;
  pcl::PointCloud<PointT>::Ptr decoded(new pcl::PointCloud<PointT>);
  if (!compression.encodePointCloud(cloud, bytes).ok() ||
      !compression.decodePointCloud(bytes, decoded).ok())
    return 1;
  bool is_right = decoded->size() == cloud->size();
  for (const PointT& voxel : *decoded) {
    std::cout << "voxel at " << voxel.z << " m has intensity " << voxel.intensity
              << '\n';
    is_right &=
        std::abs(voxel.intensity - 255.0f * own(voxel.z, 0.0f)) < 0.5f + 255.0f * 0.01f;
  }
  return is_right ? 0 : 1;
}

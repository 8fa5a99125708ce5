// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// From a Kinect V2's cloud to bytes, and from bytes to a cloud without noise: what one
// sensor's computer does, and what the central one does.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/sensor_preprocessor.h>

#include <pcl/filters/passthrough.h>

#include <iostream>
#include <limits>
#include <sstream>

using KinectIntensity =
    pcl_ext::IntensityModel<pcl_ext::KinectV2, pcl_ext::QuadraticLaw>;
using Compression = pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

// A wall at 3 m, and one stray point every 500 in the air before it.
pcl::PointCloud<pcl::PointXYZ>
wallWithNoise()
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (int row = 0; row < 424; ++row)
    for (int column = 0; column < 512; ++column) {
      const bool is_noise = (row * 512 + column) % 500 == 0;
      const float z = is_noise ? 1.0f + 0.004f * static_cast<float>(row) : 3.0f;
      // 512 x 424 pixels over 70.6 x 60 degrees
      cloud.emplace_back(z * 0.7080f * (static_cast<float>(column) / 256.0f - 1.0f),
                         z * 0.5774f * (static_cast<float>(row) / 212.0f - 1.0f),
                         z);
    }
  return cloud;
}

int
main()
{
  const double resolution = 0.04; // m
  // At the sensor: each point gets its share of a voxel face, 255 being a full one.
  pcl_ext::SensorPreprocessor<KinectIntensity> preprocessor{
      KinectIntensity(resolution)};
  Eigen::Isometry3d sensor_to_world = Eigen::Isometry3d::Identity();
  sensor_to_world.translation() << 0.0, 0.0, 1.5;
  preprocessor.setSensorPose(sensor_to_world);
  preprocessor.setCropBox({-5.0, -5.0, 0.0}, {5.0, 5.0, 5.0});
  preprocessor.setIntensityScale(255.0f);
  const pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZI>);
  if (const auto status = preprocessor.process(wallWithNoise(), *cloud); !status.ok()) {
    std::cerr << status.message() << '\n';
    return 1;
  }

  pcl_ext::io::IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.aggregation = pcl_ext::io::Aggregation::Sum;
  settings.intensity_range = 255.0f; // oblique walls have more, which is said once
  settings.intensity_bits = 8;
  const double cut_off_depth = KinectIntensity(resolution).cutOffDepth();
  settings.depth_law = pcl_ext::io::DepthLaw{2, cut_off_depth, 255.0}; // fewer bytes
  Compression encoder(settings);
  std::stringstream bytes;
  if (!encoder.encodePointCloud(cloud, bytes).ok())
    return 1;

  // At the central computer: voxels that no wall fills are taken for noise.
  Compression decoder(settings);
  pcl::PointCloud<pcl::PointXYZI>::Ptr decoded(new pcl::PointCloud<pcl::PointXYZI>);
  if (!decoder.decodePointCloud(bytes, decoded).ok())
    return 1;
  pcl::PassThrough<pcl::PointXYZI> filter;
  filter.setInputCloud(decoded);
  filter.setFilterFieldName("intensity");
  filter.setFilterLimits(64.0f, std::numeric_limits<float>::max());
  pcl::PointCloud<pcl::PointXYZI> denoised;
  filter.filter(denoised);

  std::cout << cloud->size() << " points, " << encoder.statistics().coding.bytes
            << " bytes, " << decoded->size() << " voxels, " << denoised.size()
            << " of them not noise\n";
  return !denoised.empty() && denoised.size() < decoded->size() ? 0 : 1;
}

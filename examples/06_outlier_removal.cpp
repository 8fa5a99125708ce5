// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Removes the flying pixels before a wall: in a program that decodes clouds as with
// PCL, and in the central node, which does the same for each of its streams.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <iostream>
#include <random>
#include <sstream>

using namespace pcl_ext;

// A wall 3 m before a Kinect V2, in the sensor's frame; a few points hang in the air.
pcl::PCLPointCloud2
wallWithNoise(std::mt19937& random)
{
  pcl::PointCloud<pcl::PointXYZ> points;
  for (int row = 0; row < 424; ++row)
    for (int column = 0; column < 512; ++column) {
      const bool is_noise = random() % 1000 == 0;
      const float z =
          is_noise ? 1.0f + static_cast<float>(random() % 1900) / 1e3f : 3.0f;
      points.emplace_back(z * 0.7080f * (static_cast<float>(column) / 256.0f - 1.0f),
                          z * 0.5774f * (static_cast<float>(row) / 212.0f - 1.0f),
                          z);
    }
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(points, cloud);
  return cloud;
}

int
main()
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = 0.04; // m
  settings.law = IntensityLaw::Quadratic;
  settings.sensor = RuntimeSensor(70.6, 60.0, 512, 424);
  nodes::SensorNode sensor(settings);

  // Above 0 more noise goes, and the surfaces' fringes with it.
  VoxelOutlierRemovalSettings removal_settings;
  removal_settings.min_log_odds = 0.0f;
  // What the intensities are, which a frame says only where it has a depth model.
  removal_settings.unit = densityUnitSettings(densityUnitOf(settings.law));
  // One filter for one stream, as it remembers the last frames.
  io::OctreePointCloudIntensityCompression<pcl::PointXYZI> decoder;
  VoxelOutlierRemoval removal(removal_settings);

  nodes::CentralNode central{nodes::CentralNodeSettings()};
  central.addStream("kinect");
  if (!central.setOutlierRemoval("kinect", removal_settings).ok())
    return 1;

  std::mt19937 random(1);
  bool is_right = true;
  for (int frame = 0; frame < 5; ++frame) {
    std::vector<std::uint8_t> bytes;
    sensor.encode(wallWithNoise(random), WorldPose(WorldPose::Identity()), bytes);

    std::stringstream stream(std::string(bytes.begin(), bytes.end()));
    pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZI>);
    if (!decoder.decodePointCloud(stream, cloud).ok())
      return 1;
    const OutlierRemovalStatus status =
        removeOutliers(*cloud, decoder.voxelFrame(), removal);
    if (!status.ok()) {
      std::cerr << status.message() << '\n';
      return 1;
    }

    central.receive("kinect", bytes);
    central.waitUntilDecoded();
    const nodes::StreamHealth health = central.health().front();
    std::cout << health.voxels << " voxels, " << health.outliers_removed
              << " of them noise\n";
    is_right = is_right && health.outlier_removal.ok() &&
               status.removed == health.outliers_removed && status.removed > 0 &&
               cloud->size() == health.kept_voxels;
  }
  return is_right ? 0 : 1;
}

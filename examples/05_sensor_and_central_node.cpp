// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Two sensors beside each other before a wall, and the central computer that
// decodes both streams, asks for what it lost, and merges what they see.
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/conversions.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <atomic>
#include <iostream>

using namespace pcl_ext;

// A wall 3 m before a Kinect V2, in the sensor's frame.
pcl::PCLPointCloud2
wall()
{
  pcl::PointCloud<pcl::PointXYZ> points;
  for (int row = 0; row < 424; ++row)
    for (int column = 0; column < 512; ++column)
      points.emplace_back(3.0f * 0.7080f * (static_cast<float>(column) / 256.0f - 1.0f),
                          3.0f * 0.5774f * (static_cast<float>(row) / 212.0f - 1.0f),
                          3.0f);
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
  nodes::SensorNode left(settings);
  nodes::SensorNode right(settings);
  if (!left.settingsStatus().ok()) {
    std::cerr << left.settingsStatus().message() << '\n';
    return 1;
  }

  // The listener is called by the threads that decode.
  std::atomic<bool> left_is_wanted{false};
  nodes::CentralNodeSettings central_settings;
  central_settings.resolution = settings.compression.resolution;
  nodes::CentralNode central(central_settings, [&](const nodes::ReceivedFrame& frame) {
    if (frame.wants_i_frame && frame.stream == "left")
      left_is_wanted = true;
  });
  central.addStream("left", /* min_intensity */ 64.0f);
  central.addStream("right", 64.0f);

  WorldPose left_pose = WorldPose::Identity();
  WorldPose right_pose = WorldPose::Identity();
  right_pose.translation().x() = 2.0; // m
  std::vector<std::uint8_t> bytes;
  for (int frame = 0; frame < 5; ++frame) {
    if (left_is_wanted.exchange(false))
      left.requestIFrame();
    left.encode(wall(), left_pose, bytes);
    if (frame != 1) // which the network loses
      central.receive("left", bytes);
    right.encode(wall(), right_pose, bytes);
    central.receive("right", bytes);
    central.waitUntilDecoded();
  }

  for (const nodes::StreamHealth& stream : central.health())
    std::cout << stream.name << ": " << stream.frames_decoded << " of "
              << stream.frames_received << " frames decoded, " << stream.frames_lost
              << " lost, " << stream.voxels << " voxels\n";
  io::VoxelFrame merged;
  if (const nodes::MergeStatus status = central.merge(merged); !status.ok()) {
    std::cerr << status << '\n';
    return 1;
  }
  std::cout << merged.size() << " voxels of both\n";
  return merged.size() > central.health().front().voxels ? 0 : 1;
}

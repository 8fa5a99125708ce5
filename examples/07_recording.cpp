// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Records two sensors into one file, and reads it: all frames in the order of their
// times, and one from the middle. A bag of ROS 2 with compressed clouds is read in the
// same way.
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>

#include <pcl/point_types.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <string>
#include <vector>

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

/** \brief In place of a sensor: a surface whose waves move. */
Cloud::Ptr
capture(int sensor, int frame)
{
  Cloud::Ptr cloud(new Cloud);
  for (float x = -1; x < 1; x += 0.01f)
    for (float y = -1; y < 1; y += 0.01f) {
      const float phase = 5 * x + 0.1f * static_cast<float>(frame);
      cloud->emplace_back(
          x, y + 3 * static_cast<float>(sensor), 0.1f * std::sin(phase), 100 + 50 * y);
    }
  return cloud;
}

bool
record(const std::string& path)
{
  pcl_ext::io::IntensityCompressionSettings settings;
  settings.resolution = 0.02;
  Compression encoders[] = {Compression(settings), Compression(settings)};
  pcl_ext::recording::RecordingWriter writer;
  std::size_t streams[2];
  auto status = writer.open(path);
  for (int sensor = 0; sensor < 2 && status.ok(); ++sensor)
    status = writer.addStream({"/sensor_" + std::to_string(sensor), "world", {}},
                              streams[sensor]);
  std::vector<std::uint8_t> bytes;
  for (int frame = 0; frame < 100 && status.ok(); ++frame)
    for (int sensor = 0; sensor < 2 && status.ok(); ++sensor) {
      // Of a real cloud: header.stamp.
      const auto time = std::chrono::milliseconds(1'000'000 + 50 * frame + sensor);
      if (const auto encoded =
              encoders[sensor].encodePointCloud(capture(sensor, frame), bytes);
          !encoded.ok()) {
        std::cerr << encoded << '\n';
        return false;
      }
      status = writer.append(streams[sensor], time, bytes.data(), bytes.size());
    }
  if (status.ok())
    status = writer.finish();
  if (!status.ok())
    std::cerr << status << '\n';
  return status.ok();
}

} // namespace

int
main()
{
  const std::string path = "example_07.mcap";
  pcl_ext::recording::RecordingReader reader;
  if (!record(path))
    return 1;
  if (const auto status = reader.open(path); !status.ok()) {
    std::cerr << status << '\n';
    return 1;
  }

  std::map<std::size_t, std::size_t> bytes;
  pcl_ext::recording::RecordedFrame frame;
  while (reader.next(frame).ok())
    bytes[frame.stream] += frame.bytes.size();
  for (std::size_t i = 0; i < reader.streams().size(); ++i)
    std::cout << reader.streams()[i].name << ": " << reader.streams()[i].frames
              << " frames, " << bytes[i] << " bytes\n";

  // Any frame; those from the I-frame before it on are decoded.
  pcl_ext::recording::RecordedStreamDecoder decoder(reader, 1);
  pcl_ext::io::VoxelFrame voxels;
  const auto decoded = decoder.decode(57, voxels);
  std::cout << "frame 57: " << voxels.size() << " voxels, " << decoded << '\n';
  return decoded.ok() && bytes.size() == 2 ? 0 : 1;
}

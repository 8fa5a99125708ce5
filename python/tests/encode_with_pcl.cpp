// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Encodes a stream of clouds with OctreePointCloudIntensityCompression, for
 * test_bytes_of_cpp.py, which compares the frames with those of Python.
 *
 * Arguments: law, effort, format, resolution, and the sensor's x along the world's x,
 * as its position. Standard input: for each cloud its number of points (u32), whether
 * it has colours (u32), and for each point x, y, z, intensity (f32) and its colour
 * (u32). Standard output: for each frame its number of bytes (u32) and the bytes.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/point_types.h>

#include <pcl/point_cloud.h>

#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using Cloud = pcl::PointCloud<PointXYZRGBI>;

struct Point {
  float x;
  float y;
  float z;
  float intensity;
  std::uint32_t colour;
};

template <typename ValueT>
bool
readValues(ValueT* values, std::size_t count)
{
  const auto bytes = static_cast<std::streamsize>(count * sizeof(ValueT));
  std::cin.read(reinterpret_cast<char*>(values), bytes);
  return std::cin.gcount() == bytes;
}

bool
readCloud(Cloud& cloud, bool& has_colours)
{
  std::uint32_t head[2];
  if (!readValues(head, 2))
    return false;
  std::vector<Point> points(head[0]);
  if (!readValues(points.data(), points.size()))
    throw std::runtime_error("a cloud ends early");
  has_colours = head[1] != 0;
  cloud.clear();
  for (const Point& point : points) {
    PointXYZRGBI& made = cloud.points.emplace_back();
    made.x = point.x;
    made.y = point.y;
    made.z = point.z;
    made.intensity = point.intensity;
    setPackedColour(made, point.colour);
  }
  cloud.width = head[0];
  cloud.height = 1;
  return true;
}

template <typename ModelT>
void
encodeStream(const ModelT& model, io::IntensityCompressionSettings settings)
{
  const Cloud::Ptr cloud(new Cloud);
  bool has_colours = false;
  bool is_first = true;
  io::OctreePointCloudIntensityCompression<PointXYZRGBI, ModelT> encoder(settings,
                                                                         model);
  std::vector<std::uint8_t> frame;
  while (readCloud(*cloud, has_colours)) {
    // The type of the points has colours; clouds without leave them out.
    if (is_first && !has_colours) {
      settings.colour_bits = 0;
      encoder = {settings, model};
    }
    is_first = false;
    const io::CompressionStatus status = encoder.encodePointCloud(cloud, frame);
    if (!status.ok())
      throw std::runtime_error(status.message());
    const auto size = static_cast<std::uint32_t>(frame.size());
    std::cout.write(reinterpret_cast<const char*>(&size), sizeof(size));
    std::cout.write(reinterpret_cast<const char*>(frame.data()), size);
  }
}

void
run(const std::vector<std::string>& arguments)
{
  io::IntensityCompressionSettings settings;
  settings.effort = valueNamed(io::efforts, arguments.at(1)).value();
  settings.format = valueNamed(io::stream_formats, arguments.at(2)).value();
  settings.resolution = std::stod(arguments.at(3));
  settings.i_frame_rate = 4;
  io::SensorPose pose = io::SensorPose::Identity();
  pose.translation() << std::stof(arguments.at(4)), 0.0f, 0.0f;
  settings.sensor_pose = pose;
  visitIntensityModel(valueNamed(intensity_laws, arguments.at(0)).value(),
                      settings.resolution,
                      runtimeSensor(KinectV2()),
                      [&](const auto& model) { encodeStream(model, settings); });
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    run(std::vector<std::string>(argv + 1, argv + argc));
  }
  catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}

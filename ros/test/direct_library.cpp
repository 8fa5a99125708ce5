#include "direct_library.h"

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/central_node.h>

#include <gtest/gtest.h>

#include <pcl_conversions/pcl_conversions.h>

#include <cstring>

namespace pcl_ext_ros1 {
namespace test {

namespace io = pcl_ext::io;

Voxels
voxelsIn(const sensor_msgs::PointCloud2& message)
{
  const char* const names[] = {"x", "y", "z", "intensity", "rgb"};
  const std::size_t fields = message.fields.size();
  Voxels voxels(std::size_t{message.width} * message.height);
  EXPECT_TRUE(fields == 4 || fields == 5) << fields;
  for (std::size_t i = 0; i < fields; ++i) {
    EXPECT_EQ(message.fields[i].name, names[i % 5]);
    EXPECT_EQ(message.fields[i].offset, 4 * i);
    EXPECT_EQ(message.fields[i].datatype, sensor_msgs::PointField::FLOAT32);
    EXPECT_EQ(message.fields[i].count, 1u);
  }
  EXPECT_EQ(message.height, 1u);
  EXPECT_EQ(message.point_step, 4 * fields);
  EXPECT_EQ(message.row_step, message.point_step * message.width);
  EXPECT_FALSE(message.is_bigendian);
  EXPECT_TRUE(message.is_dense);
  EXPECT_EQ(message.data.size(), 4 * fields * voxels.size());
  if (fields <= 5 && message.data.size() == 4 * fields * voxels.size())
    for (std::size_t i = 0; i < voxels.size(); ++i)
      std::memcpy(&voxels[i], &message.data[4 * fields * i], 4 * fields);
  return voxels;
}

Voxels
voxelsIn(const io::VoxelFrame& frame)
{
  Voxels voxels;
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    voxels.push_back({x, y, z, intensity, 0.0f});
    if (frame.colour_bits == 0)
      return;
    const io::VoxelColour colour = frame.fullColour(voxels.size() - 1);
    const std::uint32_t packed =
        static_cast<std::uint32_t>((colour.r * 256 + colour.g) * 256 + colour.b);
    std::memcpy(&voxels.back()[4], &packed, sizeof(packed));
  });
  return voxels;
}

DirectStream::DirectStream(const pcl_ext::nodes::SensorNodeSettings& settings)
: sensor_node_(settings)
{
  EXPECT_TRUE(sensor_node_.settingsStatus().ok())
      << sensor_node_.settingsStatus().message();
}

Bytes
DirectStream::encode(const sensor_msgs::PointCloud2& cloud,
                     const pcl_ext::WorldPose& pose)
{
  pcl::PCLPointCloud2 input;
  pcl_conversions::toPCL(cloud, input);
  Bytes bytes;
  sensor_node_.encode(input, pose, bytes);
  return bytes;
}

io::VoxelFrame
DirectStream::frameOf(const sensor_msgs::PointCloud2& cloud,
                      const pcl_ext::WorldPose& pose)
{
  sensor_node_.requestIFrame(); // for a decoder without history
  const Bytes bytes = encode(cloud, pose);
  io::VoxelFrame voxels;
  const auto status = io::FrameDecoder().decode(bytes.data(), bytes.size(), voxels);
  EXPECT_TRUE(status.ok()) << status.message();
  return voxels;
}

Voxels
mergedDirectly(double resolution, const std::map<std::string, Bytes>& frames)
{
  pcl_ext::nodes::CentralNodeSettings settings;
  settings.resolution = resolution;
  settings.max_merge_age = std::chrono::hours(1);
  pcl_ext::nodes::CentralNode central_node(settings);
  for (const auto& [name, bytes] : frames) {
    EXPECT_TRUE(central_node.addStream(name).ok());
    EXPECT_TRUE(central_node.receive(name, bytes).ok());
  }
  central_node.waitUntilDecoded();
  io::VoxelFrame merged;
  central_node.merge(merged);
  return voxelsIn(merged);
}

} // namespace test
} // namespace pcl_ext_ros1

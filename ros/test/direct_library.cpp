#include "direct_library.h"

#include <pcl_ext/nodes/central_node.h>

#include <gtest/gtest.h>

#include <pcl_conversions/pcl_conversions.h>

#include <cstring>

namespace pcl_ext_ros {
namespace test {

namespace io = pcl_ext::io;
using pcl_ext::nodes::CentralNode;
using pcl_ext::nodes::CentralNodeSettings;

namespace {

CentralNodeSettings
centralSettings(double resolution = 0.04)
{
  CentralNodeSettings settings;
  settings.resolution = resolution;
  settings.threads = 1;
  settings.max_merge_age = std::chrono::hours(1);
  return settings;
}

} // namespace

Voxels
voxelsIn(const sensor_msgs::PointCloud2& message)
{
  const char* const names[] = {"x", "y", "z", "intensity"};
  Voxels voxels(std::size_t{message.width} * message.height);
  EXPECT_EQ(message.fields.size(), 4u);
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    EXPECT_EQ(message.fields[i].name, names[i % 4]);
    EXPECT_EQ(message.fields[i].offset, 4 * i);
    EXPECT_EQ(message.fields[i].datatype, sensor_msgs::PointField::FLOAT32);
    EXPECT_EQ(message.fields[i].count, 1u);
  }
  EXPECT_EQ(message.height, 1u);
  EXPECT_EQ(message.point_step, 16u);
  EXPECT_EQ(message.row_step, 16u * message.width);
  EXPECT_FALSE(message.is_bigendian);
  EXPECT_TRUE(message.is_dense);
  EXPECT_EQ(message.data.size(), 16 * voxels.size());
  if (message.data.size() == 16 * voxels.size() && !voxels.empty())
    std::memcpy(voxels.data(), message.data.data(), message.data.size());
  return voxels;
}

Voxels
voxelsIn(const io::VoxelFrame& frame)
{
  Voxels voxels;
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    voxels.push_back({x, y, z, intensity});
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
                     const std::optional<pcl_ext::WorldPose>& pose)
{
  pcl::PCLPointCloud2 input;
  pcl_conversions::toPCL(cloud, input);
  Bytes bytes;
  sensor_node_.encode(input, pose, bytes);
  return bytes;
}

Voxels
DirectStream::voxelsOf(const sensor_msgs::PointCloud2& cloud,
                       const std::optional<pcl_ext::WorldPose>& pose,
                       float min_intensity)
{
  return voxelsIn(frameOf(cloud, pose, min_intensity));
}

io::VoxelFrame
DirectStream::frameOf(const sensor_msgs::PointCloud2& cloud,
                      const std::optional<pcl_ext::WorldPose>& pose,
                      float min_intensity)
{
  // The stream's frames alone are decoded, so that each must know nothing of the others.
  sensor_node_.requestIFrame();
  io::VoxelFrame voxels;
  CentralNode central_node(centralSettings(),
                           [&](const pcl_ext::nodes::ReceivedFrame& frame) {
                             EXPECT_TRUE(frame.status.ok()) << frame.status.message();
                             voxels = frame.voxels;
                           });
  EXPECT_TRUE(central_node.addStream("direct", min_intensity).ok());
  EXPECT_TRUE(central_node.receive("direct", encode(cloud, pose)).ok());
  central_node.waitUntilDecoded();
  return voxels;
}

Voxels
mergedDirectly(double resolution, const std::map<std::string, Bytes>& frames)
{
  CentralNode central_node(centralSettings(resolution));
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
} // namespace pcl_ext_ros

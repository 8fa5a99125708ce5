#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "cell/robot_cell.h"

#include <pcl/conversions.h>

#include <gtest/gtest.h>

namespace {

using namespace pcl_ext;

nodes::SensorNodeSettings
settingsOf(nodes::IntensityLaw law)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = 0.08;
  settings.law = law;
  settings.sensor.emplace(70.6, 60.0, 512u, 424u);
  settings.crop_box = io::BoundingBox{{0.0, 0.0, 0.1}, {10.0, 10.0, 4.0}};
  return settings;
}

TEST(SensorNodeOutlierRemoval, SendsWhatTheFilterKeeps)
{
  for (const auto law : {nodes::IntensityLaw::Count, nodes::IntensityLaw::Quadratic}) {
    nodes::SensorNodeSettings settings = settingsOf(law);
    EXPECT_FALSE(settings.outlier_removal);
    nodes::SensorNode plain(settings);
    settings.outlier_removal.emplace();
    nodes::SensorNode filtering(settings);
    VoxelOutlierRemoval removal;
    io::FrameDecoder plain_decoder;
    io::FrameDecoder filtered_decoder;
    cell::RobotCell cell(1);
    cell::CellFrame captured;
    const WorldPose pose(cell.sensorPose(1));
    for (std::uint32_t i = 0; i < 5; ++i) {
      cell.capture(1, i, captured);
      pcl::PCLPointCloud2 cloud;
      pcl::toPCLPointCloud2(captured.cloud, cloud);
      std::vector<std::uint8_t> bytes;
      std::vector<std::uint8_t> filtered_bytes;
      ASSERT_TRUE(plain.encode(cloud, pose, bytes).ok());
      ASSERT_TRUE(filtering.encode(cloud, pose, filtered_bytes).ok());
      EXPECT_LT(filtered_bytes.size(), bytes.size());
      io::VoxelFrame expected;
      io::VoxelFrame voxels;
      ASSERT_TRUE(plain_decoder.decode(bytes.data(), bytes.size(), expected).ok());
      ASSERT_TRUE(
          filtered_decoder.decode(filtered_bytes.data(), filtered_bytes.size(), voxels)
              .ok());
      // The receiver's filter sees what the sensor's does.
      const std::size_t removed = removal.filter(expected);
      EXPECT_GT(removed, 0u);
      EXPECT_EQ(filtering.statistics().outliers_removed, removed);
      EXPECT_EQ(plain.statistics().outliers_removed, 0u);
      EXPECT_EQ(voxels.keys, expected.keys);
      EXPECT_EQ(voxels.intensities, expected.intensities);
    }
  }
}

} // namespace

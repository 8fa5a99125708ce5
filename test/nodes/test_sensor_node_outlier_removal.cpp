#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "simulator/robot_cell.h"

#include <pcl/conversions.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace {

using pcl_ext::IntensityLaw;
using namespace pcl_ext;

nodes::SensorNodeSettings
settingsOf(IntensityLaw law)
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
  for (const auto law : {IntensityLaw::Count, IntensityLaw::Quadratic}) {
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

TEST(SensorNodeOutlierRemoval, TheQuadraticLawIsMeasuredInFacesInAnyLayout)
{
  nodes::SensorNodeSettings settings = settingsOf(IntensityLaw::Quadratic);
  settings.compression.format = io::StreamFormat::Published;
  const auto removedBy = [&](DensityUnit unit) {
    settings.outlier_removal.emplace().unit = unit;
    nodes::SensorNode node(settings);
    cell::RobotCell cell(1);
    cell::CellFrame captured;
    cell.capture(1, 0, captured);
    pcl::PCLPointCloud2 cloud;
    pcl::toPCLPointCloud2(captured.cloud, cloud);
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(node.encode(cloud, WorldPose(cell.sensorPose(1)), bytes).ok());
    return node.statistics().outliers_removed;
  };
  EXPECT_EQ(removedBy(DensityUnit::Automatic), removedBy(DensityUnit::Faces));
  EXPECT_NE(removedBy(DensityUnit::Automatic), removedBy(DensityUnit::Points));
}

TEST(SensorNodeOutlierRemoval, ResolutionsThatTheFilterIsNotMadeForAreRefused)
{
  nodes::SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.outlier_removal.emplace();
  for (const double resolution : {0.02, 0.2}) {
    settings.compression.resolution = resolution;
    EXPECT_TRUE(nodes::SensorNode(settings).settingsStatus().ok());
  }
  settings.compression.resolution = 0.01;
  const nodes::SensorNode node(settings);
  EXPECT_EQ(node.settingsStatus().code(), nodes::SensorNodeCode::InvalidSettings);
  EXPECT_EQ(node.settingsStatus().message(),
            "outlier_removal is set and compression.resolution is 0.010000; it must be "
            "0.020000 to 0.200000 for that");
}

TEST(SensorNodeOutlierRemoval, NativeIntensitiesAndInvalidSettingsAreRefused)
{
  nodes::SensorNodeSettings settings = settingsOf(IntensityLaw::Native);
  EXPECT_TRUE(nodes::SensorNode(settings).settingsStatus().ok());
  settings.outlier_removal.emplace();
  const nodes::SensorNode native(settings);
  EXPECT_EQ(native.settingsStatus().code(), nodes::SensorNodeCode::InvalidSettings);
  EXPECT_EQ(native.settingsStatus().message(),
            "outlier_removal is set and law is Native; native intensities do not tell "
            "how densely points lie");
  for (const auto law : {IntensityLaw::Count,
                         IntensityLaw::Quadratic,
                         IntensityLaw::Linear}) {
    settings.law = law;
    settings.outlier_removal.emplace();
    EXPECT_TRUE(nodes::SensorNode(settings).settingsStatus().ok());
    settings.outlier_removal->full_intensity = -1.0f;
    const nodes::SensorNode invalid(settings);
    EXPECT_EQ(invalid.settingsStatus().code(), nodes::SensorNodeCode::InvalidSettings);
    EXPECT_EQ(
        invalid.settingsStatus().message(),
        "outlier_removal: full_intensity is -1.000000; it must be a finite number "
        "above 0");
  }
}

/** \brief Leaves some points of one corner of the image and less than 5 m away. */
void
leavePoints(pcl::PointCloud<pcl::PointXYZ>& cloud, int count)
{
  for (std::size_t pixel = 0; pixel < cloud.size(); ++pixel) {
    const bool stays = cloud[pixel].z < 5.0f && pixel % 512 > 200 && count > 0;
    if (stays)
      --count;
    else
      cloud[pixel].x = std::numeric_limits<float>::quiet_NaN();
  }
}

TEST(SensorNodeOutlierRemoval, ReceiverKnowsTheDepthsOfFramesWithoutModel)
{
  // Without a crop box each I-frame has the grid of its points, and one of few points no
  // depth model, as it would cost more than it saves.
  nodes::SensorNodeSettings settings = settingsOf(IntensityLaw::Quadratic);
  settings.compression.resolution = 0.04;
  settings.compression.i_frame_rate = 3;
  settings.crop_box.reset();
  nodes::SensorNode node(settings);
  io::FrameDecoder decoder;
  VoxelOutlierRemoval as_received;
  VoxelOutlierRemoval with_model;
  const IntensityModel<RuntimeSensor, QuadraticLaw> model(0.04, *settings.sensor);
  cell::RobotCell cell(1);
  cell::CellFrame captured;
  const WorldPose pose(cell.sensorPose(1));
  const Eigen::Vector3d origin = pose.translation();
  const Eigen::Vector3d axis = pose.linear().col(2);
  io::VoxelGrid first_grid;
  for (std::uint32_t i = 0; i < 6; ++i) {
    cell.capture(1, i, captured);
    if (i >= 3)
      leavePoints(captured.cloud, 40);
    pcl::PCLPointCloud2 cloud;
    pcl::toPCLPointCloud2(captured.cloud, cloud);
    std::vector<std::uint8_t> bytes;
    ASSERT_TRUE(node.encode(cloud, pose, bytes).ok());
    io::VoxelFrame frame;
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), frame).ok());
    if (i == 0)
      first_grid = frame.grid;
    ASSERT_EQ(frame.depth_model.has_value(), i < 3);
    ASSERT_EQ(frame.grid == first_grid, i < 3);
    std::vector<float> scores;
    as_received.score(frame, scores);
    frame.depth_model = io::depthModelOf({2, model.cutOffDepth(), 255.0},
                                         {origin.x(), origin.y(), origin.z()},
                                         {axis.x(), axis.y(), axis.z()},
                                         frame.grid,
                                         frame.intensity_scale);
    std::vector<float> expected;
    with_model.score(frame, expected);
    ASSERT_FALSE(scores.empty());
    // Where the grid moved, depths are rounded another way.
    for (std::size_t voxel = 0; voxel < scores.size(); ++voxel)
      ASSERT_NEAR(scores[voxel], expected[voxel], 0.05f);
  }
}

} // namespace

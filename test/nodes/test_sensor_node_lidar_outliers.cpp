// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/cloud_outlier_removal.h>

#include "support/lidar_room.h"
#include "support/node_tests.h"

#include <cmath>
#include <limits>
#include <set>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::nodes::test;
using pcl_ext::test::LidarRoom;

/** \brief A lidar's cloud of a standing sensor, in which it snows. */
pcl::PCLPointCloud2
lidarCloud(unsigned int seed, bool is_organised = true)
{
  LidarRoom room;
  room.width = 180;
  room.height = 16;
  room.snow = 0.05;
  room.seed = seed;
  auto cloud = room.scan().cloud<pcl::PointCloud<pcl::PointXYZ>>();
  if (!is_organised) {
    cloud.width *= cloud.height;
    cloud.height = 1;
  }
  return messageOf(cloud, 1000 + seed);
}

std::size_t
finitePoints(const pcl::PCLPointCloud2& message)
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  pcl::fromPCLPointCloud2(message, cloud);
  std::size_t count = 0;
  for (const pcl::PointXYZ& point : cloud)
    count += std::isfinite(point.x) ? 1 : 0;
  return count;
}

nodes::SensorNodeSettings
removingSettings()
{
  nodes::SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.outlier_removal.emplace();
  return settings;
}

TEST(SensorNodeLidarOutliers, AreRemovedAsPointsBeforeTheyAreVoxels)
{
  for (const bool is_organised : {true, false}) {
    nodes::SensorNode node(removingSettings());
    nodes::SensorNode plain(settingsOf(IntensityLaw::Count));
    PointOutlierRemoval removal;
    io::FrameDecoder decoder;
    io::FrameDecoder plain_decoder;
    for (unsigned int seed = 1; seed < 4; ++seed) {
      const pcl::PCLPointCloud2 cloud = lidarCloud(seed, is_organised);
      pcl::PCLPointCloud2 kept = cloud;
      const OutlierRemovalStatus status = removeOutliers(kept, removal);
      ASSERT_TRUE(status.ok()) << status.message();
      // The sensor has moved, but its points are judged as it saw them.
      const io::VoxelFrame voxels =
          decodedWith(decoder, encoded(node, cloud, poseOf(seed)));
      const io::VoxelFrame expected =
          decodedWith(plain_decoder, encoded(plain, kept, poseOf(seed)));
      EXPECT_EQ(voxels.keys, expected.keys);
      EXPECT_EQ(voxels.intensities, expected.intensities);
      const nodes::SensorNodeStatistics statistics = node.statistics();
      EXPECT_TRUE(statistics.judged_points);
      EXPECT_GT(statistics.points_removed, 50u);
      EXPECT_EQ(statistics.points_removed, status.removed);
      EXPECT_EQ(statistics.outliers_removed, 0u);
      EXPECT_EQ(statistics.preprocessing.points, std::size_t{180} * 16);
      EXPECT_EQ(statistics.preprocessing.points_not_finite,
                std::size_t{180} * 16 - finitePoints(cloud));
      EXPECT_EQ(statistics.frame.voxelization.points_used,
                finitePoints(cloud) - status.removed);
    }
  }
}

TEST(SensorNodeLidarOutliers, SettingsAreThoseOfTheNode)
{
  nodes::SensorNodeSettings settings = removingSettings();
  PointOutlierRemovalSettings expected;
  expected.min_log_odds = settings.outlier_removal->min_log_odds = 3.0f;
  settings.outlier_removal->unit = AutomaticUnit{{false}};
  expected.use_history = false;
  nodes::SensorNode node(settings);
  PointOutlierRemoval removal(expected);
  for (unsigned int seed = 1; seed < 3; ++seed) {
    pcl::PCLPointCloud2 cloud = lidarCloud(seed);
    encoded(node, cloud, poseOf(0));
    EXPECT_EQ(node.statistics().points_removed, removeOutliers(cloud, removal).removed);
  }
}

TEST(SensorNodeLidarOutliers, PointsAreJudgedWhateverTheEdge)
{
  std::set<std::size_t> removed;
  for (const double edge : {0.0005, 0.05, 0.5}) {
    nodes::SensorNodeSettings settings = removingSettings();
    settings.compression.resolution = edge;
    nodes::SensorNode node(settings);
    encoded(node, lidarCloud(1), poseOf(0));
    EXPECT_FALSE(node.statistics().outliers_stay);
    removed.insert(node.statistics().points_removed);
  }
  EXPECT_EQ(removed.size(), 1u);
  EXPECT_GT(*removed.begin(), 50u);
}

TEST(SensorNodeLidarOutliers, ANamedUnitJudgesVoxels)
{
  nodes::SensorNodeSettings settings = removingSettings();
  settings.outlier_removal->unit = VoxelsUnit();
  settings.outlier_removal->min_log_odds = 1000.0f; // all of them
  nodes::SensorNode node(settings);
  nodes::SensorNode plain(settingsOf(IntensityLaw::Count));
  VoxelOutlierRemoval removal(*settings.outlier_removal);
  io::FrameDecoder plain_decoder;
  std::size_t all_removed = 0;
  for (unsigned int seed = 1; seed < 4; ++seed) {
    io::VoxelFrame frame =
        decodedWith(plain_decoder, encoded(plain, lidarCloud(seed), poseOf(0)));
    const std::size_t removed = removal.filter(frame).removed;
    encoded(node, lidarCloud(seed), poseOf(0));
    EXPECT_FALSE(node.statistics().judged_points);
    EXPECT_EQ(node.statistics().points_removed, 0u);
    EXPECT_EQ(node.statistics().outliers_removed, removed);
    all_removed += removed;
  }
  EXPECT_GT(all_removed, 0u);
}

TEST(SensorNodeLidarOutliers, CloudsWithoutRowsLoseVoxelsInTheSameStream)
{
  nodes::SensorNode node(removingSettings());
  encoded(node, lidarCloud(1), poseOf(0));
  EXPECT_TRUE(node.statistics().judged_points);
  encoded(node, messageOf(cloudSeenFrom(poseOf(0), 1, 400, 5)), poseOf(0));
  EXPECT_FALSE(node.statistics().judged_points);
  EXPECT_EQ(node.statistics().points_removed, 0u);
  EXPECT_GT(node.statistics().outliers_removed, 0u);
  // What is refused leaves the statistics, and the next cloud is a lidar's again.
  pcl::PCLPointCloud2 invalid = lidarCloud(2);
  invalid.data.pop_back();
  expectLeftOut(node, invalid, poseOf(0), nodes::SensorNodeCode::InvalidCloud);
  EXPECT_FALSE(node.statistics().judged_points);
  encoded(node, lidarCloud(2), poseOf(0));
  EXPECT_TRUE(node.statistics().judged_points);
  EXPECT_GT(node.statistics().points_removed, 0u);
  EXPECT_EQ(node.statistics().outliers_removed, 0u);
}

} // namespace

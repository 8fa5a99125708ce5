// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/sensor_node.h>

#include "support/voxel_frames.h"

#include <pcl/conversions.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::nodes;
using pcl_ext::IntensityLaw;
using pcl_ext::WorldPose;
using pcl_ext::io::test::below;
using pcl_ext::io::test::uniform;

/** \brief An organised cloud with colours, in front of and behind the sensor, some
 * points of which are not finite. */
pcl::PCLPointCloud2
organisedCloud(std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  pcl::PointCloud<pcl::PointXYZRGB> points(512, 424);
  for (pcl::PointXYZRGB& point : points) {
    point.x = uniform(random, -2.0, 2.0);
    point.y = uniform(random, -2.0, 2.0);
    point.z = uniform(random, -0.2, 3.0);
    point.rgba = static_cast<std::uint32_t>(random());
    if (below(random, 5) == 0)
      point.y = std::numeric_limits<float>::quiet_NaN();
  }
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(points, cloud);
  return cloud;
}

TEST(SensorNodeThreads, ChangeNoByteAndNoCount)
{
  WorldPose pose = WorldPose::Identity();
  pose.translation() << 1.0, 2.0, 3.0;
  for (const bool is_cropped : {false, true}) {
    SensorNodeSettings settings;
    settings.law = is_cropped ? IntensityLaw::Count : IntensityLaw::Quadratic;
    settings.sensor = pcl_ext::named_sensors[0].value;
    settings.compression.resolution = 0.05;
    if (is_cropped)
      settings.crop_box = pcl_ext::io::BoundingBox{{0, 1, 3}, {3, 3, 5}};
    SensorNode of_one(settings);
    settings.compression.threads = 3;
    SensorNode of_three(settings);
    for (std::uint64_t i = 0; i < 3; ++i) {
      const pcl::PCLPointCloud2 cloud = organisedCloud(i);
      std::vector<std::uint8_t> expected;
      std::vector<std::uint8_t> bytes;
      ASSERT_TRUE(of_one.encode(cloud, pose, expected).hasFrame());
      ASSERT_TRUE(of_three.encode(cloud, pose, bytes).hasFrame());
      EXPECT_EQ(bytes, expected);
      const auto one = of_one.statistics().preprocessing;
      const auto three = of_three.statistics().preprocessing;
      EXPECT_EQ(three.points, 512u * 424u);
      EXPECT_EQ(three.points, one.points);
      EXPECT_EQ(three.points_not_finite, one.points_not_finite);
      EXPECT_EQ(three.points_cropped, one.points_cropped);
      EXPECT_EQ(three.points_cropped > 0, is_cropped);
      EXPECT_EQ(three.points_behind_sensor, one.points_behind_sensor);
      EXPECT_EQ(three.has_colours, one.has_colours);
      EXPECT_EQ(of_three.statistics().frame.voxelization.points_behind_sensor,
                of_one.statistics().frame.voxelization.points_behind_sensor);
    }
  }
}

} // namespace

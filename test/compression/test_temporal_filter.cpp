// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace {

namespace temporal_filter {

using pcl_ext::io::FrameStatistics;
using pcl_ext::io::IntensityCompressionSettings;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Compression =
    pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZ,
                                                      pcl_ext::CountIntensity>;

const Eigen::Vector3f sensor(4.0f, -2.0f, 1.0f);
constexpr float plate_depth = 1.5f;
constexpr float wall_depth = 3.0f;
constexpr float plate_slope = 0.2f; // half its width to its depth

/** \brief What a sensor sees of a wall, and of a plate that hides a part of it. */
Cloud::Ptr
wallWith(bool has_plate, unsigned int seed = 1)
{
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0f, 0.01f);
  Cloud::Ptr cloud(new Cloud);
  for (int column = -60; column <= 60; ++column)
    for (int row = -60; row <= 60; ++row) {
      const float x = 0.006f * static_cast<float>(column);
      const float y = 0.006f * static_cast<float>(row);
      const bool is_plate =
          has_plate && std::abs(x) < plate_slope && std::abs(y) < plate_slope;
      const float depth = (is_plate ? plate_depth : wall_depth) + noise(random);
      cloud->emplace_back(
          sensor.x() + depth * x, sensor.y() + depth * y, sensor.z() + depth);
    }
  cloud->sensor_origin_.head<3>() = sensor;
  return cloud;
}

IntensityCompressionSettings
filteringSettings(unsigned int frames)
{
  IntensityCompressionSettings settings =
      pcl_ext::test::settingsWith(pcl_ext::test::usual_resolution);
  settings.temporal_filter = frames;
  return settings;
}

std::size_t
voxelsOfThePlate(const Cloud& cloud)
{
  std::size_t number = 0;
  for (const pcl::PointXYZ& point : cloud)
    number += point.z - sensor.z() < (plate_depth + wall_depth) / 2.0f ? 1 : 0;
  return number;
}

Cloud
roundTrip(Compression& encoder, Compression& decoder, const Cloud::Ptr& cloud)
{
  return *pcl_ext::test::roundTrip(encoder, decoder, cloud);
}
TEST(CompressionTemporalFilter, WhatWasCroppedProvesThatTheWayIsFree)
{
  // The wall is outside of the box; a shelf in it stays, so that the scene is the same.
  IntensityCompressionSettings settings = filteringSettings(64);
  settings.bounding_box = pcl_ext::io::BoundingBox{{-10, -10, 0}, {10, 10, 3.0}};
  Compression encoder(settings);
  Compression decoder;
  const auto cloudOf = [](bool has_plate, unsigned int seed) {
    Cloud::Ptr cloud = wallWith(has_plate, seed);
    for (int i = 0; i < 200; ++i)
      for (int j = 0; j < 180; ++j)
        cloud->emplace_back(sensor.x() + 0.8f + 0.01f * static_cast<float>(i),
                            sensor.y() + 0.01f * static_cast<float>(j),
                            sensor.z() + 1.5f);
    return cloud;
  };
  const std::size_t shelf =
      voxelsOfThePlate(roundTrip(encoder, decoder, cloudOf(false, 0)));
  encoder = Compression(settings);
  decoder = Compression();
  for (unsigned int frame = 0; frame < 6; ++frame)
    EXPECT_GT(voxelsOfThePlate(roundTrip(encoder, decoder, cloudOf(true, frame))),
              shelf + 100u);
  roundTrip(encoder, decoder, cloudOf(false, 6));
  EXPECT_EQ(voxelsOfThePlate(roundTrip(encoder, decoder, cloudOf(false, 7))), shelf);
}

TEST(CompressionTemporalFilter, OctreeAndStatisticsAreThoseOfTheFrame)
{
  IntensityCompressionSettings settings = filteringSettings(8);
  settings.retain_octree = true;
  Compression encoder(settings);
  Compression decoder;
  bool differs = false;
  for (unsigned int frame = 0; frame < 4; ++frame) {
    const Cloud::Ptr cloud = wallWith(false, frame);
    const Cloud decoded = roundTrip(encoder, decoder, cloud);
    const FrameStatistics statistics = encoder.statistics();
    EXPECT_EQ(encoder.getLeafCount(), decoded.size());
    EXPECT_EQ(statistics.coding.voxels, decoded.size());
    EXPECT_EQ(
        statistics.voxelization.voxels,
        pcl_ext::test::naiveVoxels(*cloud, pcl_ext::test::usual_resolution).size());
    EXPECT_EQ(statistics.coding.voxels,
              statistics.voxelization.voxels - statistics.voxels_hidden +
                  statistics.voxels_held);
    differs |= statistics.voxels_hidden != 0 && statistics.voxels_held != 0;
  }
  EXPECT_TRUE(differs);
}

TEST(CompressionTemporalFilter, WhatIsHeldStaysInTheGrid)
{
  // A plate far away is missing in a cloud that begins with an I-frame.
  IntensityCompressionSettings settings = filteringSettings(8);
  settings.i_frame_rate = 6;
  Compression encoder(settings);
  Compression decoder;
  std::vector<std::size_t> far_voxels;
  for (unsigned int frame = 0; frame < 8; ++frame) {
    const Cloud::Ptr cloud = wallWith(false, 1);
    for (int i = 0; i < 40 && frame != 6; ++i)
      for (int j = 0; j < 40; ++j)
        cloud->emplace_back(
            300.0f, 0.05f * static_cast<float>(i), 0.05f * static_cast<float>(j));
    const Cloud decoded = roundTrip(encoder, decoder, cloud);
    far_voxels.push_back(static_cast<std::size_t>(
        std::count_if(decoded.begin(), decoded.end(), [](const pcl::PointXYZ& point) {
          return point.x > 200.0f;
        })));
  }
  EXPECT_GT(far_voxels[5], 100u);
  EXPECT_EQ(far_voxels[6], far_voxels[5]);
  EXPECT_EQ(far_voxels[7], far_voxels[5]);
}

} // namespace temporal_filter

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Organised clouds through the class: rows, columns and missing points come back.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <sstream>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;

/** \brief What a camera sees of a wall: depths in whole millimetres, and colours. */
pcl::PointCloud<pcl::PointXYZRGB>::Ptr
wallCloud(bool has_gaps)
{
  std::mt19937 random(7);
  pcl::PointCloud<pcl::PointXYZRGB>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGB>);
  for (std::uint32_t row = 0; row < 90; ++row)
    for (std::uint32_t column = 0; column < 120; ++column) {
      pcl::PointXYZRGB point(static_cast<std::uint8_t>(row),
                             static_cast<std::uint8_t>(column),
                             static_cast<std::uint8_t>(random() % 4));
      const float depth = 0.001f * static_cast<float>(1500 + 2 * column + random() % 3);
      point.x = (static_cast<float>(column) - 59.5f) / 100.0f * depth;
      point.y = (static_cast<float>(row) - 44.5f) / 100.0f * depth;
      point.z = depth;
      if (has_gaps && random() % 10 == 0)
        point.x = point.y = point.z = std::numeric_limits<float>::quiet_NaN();
      cloud->push_back(point);
    }
  cloud->width = 120;
  cloud->height = 90;
  cloud->is_dense = !has_gaps;
  return cloud;
}

TEST(OrganisedClouds, ComeBackWithRowsColumnsAndGaps)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  settings.fields = {{"rgb"}};
  for (const bool has_gaps : {false, true}) {
    const auto cloud = wallCloud(has_gaps);
    using Compressor =
        OctreePointCloudIntensityCompression<pcl::PointXYZRGB, NoIntensity>;
    std::stringstream stream;
    ASSERT_TRUE(Compressor(settings).encodePointCloud(cloud, stream).ok());
    Compressor::PointCloudPtr received;
    ASSERT_TRUE(Compressor().decodePointCloud(stream, received).ok());
    ASSERT_EQ(received->width, 120u);
    ASSERT_EQ(received->height, 90u);
    EXPECT_EQ(received->is_dense, !has_gaps);
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      const pcl::PointXYZRGB& point = (*received)[i];
      const pcl::PointXYZRGB& original = (*cloud)[i];
      ASSERT_EQ(std::isnan(point.x), std::isnan(original.x)) << i;
      if (std::isnan(point.x)) {
        EXPECT_TRUE(std::isnan(point.y) && std::isnan(point.z));
        continue;
      }
      EXPECT_LE((point.getVector3fMap() - original.getVector3fMap())
                    .lpNorm<Eigen::Infinity>(),
                0.0005001f);
      EXPECT_EQ(point.rgba, original.rgba);
    }
  }
}

TEST(OrganisedClouds, OfCoarseVoxelsAreRowsOfPoints)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.05;
  for (const bool keep_points : {false, true}) {
    settings.keep_points = keep_points;
    const auto cloud = wallCloud(true);
    using Compressor = OctreePointCloudIntensityCompression<pcl::PointXYZRGB>;
    std::stringstream stream;
    ASSERT_TRUE(Compressor(settings).encodePointCloud(cloud, stream).ok());
    Compressor::PointCloudPtr received;
    ASSERT_TRUE(Compressor().decodePointCloud(stream, received).ok());
    EXPECT_EQ(received->height, 1u);
    EXPECT_TRUE(received->is_dense);
  }
}

TEST(OrganisedClouds, VoxelsAreMadeWhereTheyAreAskedFor)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  settings.colour_bits = 8;
  for (const bool retains_octree : {false, true}) {
    settings.retain_octree = retains_octree;
    using Compressor =
        OctreePointCloudIntensityCompression<pcl::PointXYZRGB, NoIntensity>;
    const auto sent = wallCloud(true);
    std::stringstream stream;
    Compressor compressor(settings);
    ASSERT_TRUE(compressor.encodePointCloud(sent, stream).ok());
    Compressor::PointCloudPtr cloud;
    ASSERT_TRUE(compressor.decodePointCloud(stream, cloud).ok());
    const VoxelFrame& frame = compressor.voxelFrame();
    EXPECT_TRUE(isConsistent(frame));
    EXPECT_GT(frame.size(), 5000u);
    EXPECT_EQ(&compressor.voxelFrame(), &frame);
    std::size_t points = 0;
    for (const pcl::PointXYZRGB& point : *cloud)
      points += std::isfinite(point.x) ? 1 : 0;
    ASSERT_EQ(frame.pointCount(), points);
    std::size_t point = 0;
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
      const VoxelPosition at = voxelPosition(frame.keys[voxel]);
      for (std::uint32_t i = 0; i < frame.point_counts[voxel]; ++i) {
        const pcl::PointXYZRGB& of_cloud = (*cloud)[frame.cloudIndex(point++)];
        ASSERT_NEAR(of_cloud.x, frame.grid.centre(0, at.x), 0.000501);
        ASSERT_NEAR(of_cloud.y, frame.grid.centre(1, at.y), 0.000501);
        ASSERT_NEAR(of_cloud.z, frame.grid.centre(2, at.z), 0.000501);
      }
    }
    EXPECT_EQ(compressor.getLeafCount(), retains_octree ? frame.size() : 0u);
  }
}

TEST(OrganisedClouds, PointsHaveTheirOwnIntensities)
{
  pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZI>);
  const auto coloured = wallCloud(true);
  for (const pcl::PointXYZRGB& point : *coloured) {
    pcl::PointXYZI with_intensity;
    with_intensity.getVector3fMap() = point.getVector3fMap();
    with_intensity.intensity = static_cast<float>(cloud->size() * 37 % 256);
    cloud->push_back(with_intensity);
  }
  cloud->width = 120;
  cloud->height = 90;
  cloud->is_dense = false;
  IntensityCompressionSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  settings.intensity_bits = 8;
  using Compressor =
      OctreePointCloudIntensityCompression<pcl::PointXYZI, NativeIntensity>;
  std::stringstream stream;
  Compressor compressor(settings);
  ASSERT_TRUE(compressor.encodePointCloud(cloud, stream).ok());
  Compressor::PointCloudPtr received;
  ASSERT_TRUE(compressor.decodePointCloud(stream, received).ok());
  ASSERT_EQ(received->height, 90u);
  const float step = compressor.voxelFrame().intensity_scale.step;
  for (std::size_t i = 0; i < cloud->size(); ++i)
    if (std::isfinite((*cloud)[i].x)) {
      ASSERT_NEAR((*received)[i].intensity, (*cloud)[i].intensity, 0.501f * step) << i;
    }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>

#include "support/cloud_streams.h"

#include <pcl/octree/octree2buf_base.h>
#include <pcl/octree/octree_base.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

namespace {

using pcl_ext::CountIntensity;
using pcl_ext::NativeIntensity;
using pcl_ext::io::CompressionCode;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::octree::IntensityLeaf;
using pcl_ext::octree::OctreePointCloudIntensity;
using pcl_ext::test::randomCloud;
using pcl_ext::test::settingsWith;
using Bytes = std::vector<std::uint8_t>;

// Exact in binary, so that points are in the same voxels in floats and in doubles.
constexpr double resolution = 0.0625;

/** \brief Keeps the largest intensity, and no colour. */
class LargestIntensity : public pcl::octree::OctreeContainerBase {
public:
  void
  addPointIntensity(float intensity)
  {
    largest_ = std::max(largest_, intensity);
  }

  float
  getIntensity() const
  {
    return largest_;
  }

  void
  reset() override
  {
    largest_ = 0.0f;
  }

private:
  float largest_ = 0.0f;
};

template <typename TreeT, typename PointT>
void
fill(TreeT& tree, const typename pcl::PointCloud<PointT>::Ptr& cloud)
{
  tree.deleteTree();
  tree.setInputCloud(cloud);
  tree.addPointsFromInputCloud();
}

template <typename TreeT>
pcl::PointCloud<pcl::PointXYZI>::Ptr
centresOf(TreeT& tree)
{
  const pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZI>);
  typename TreeT::AlignedPointTVector centres;
  tree.getOccupiedVoxelCenters(centres);
  for (const auto& centre : centres)
    cloud->emplace_back(
        centre.x, centre.y, centre.z, tree.getVoxelIntensityAtPoint(centre));
  return cloud;
}

template <typename TreeT>
class OctreeCoding : public ::testing::Test {};

using Trees = ::testing::Types<
    OctreePointCloudIntensity<pcl::PointXYZRGB>,
    OctreePointCloudIntensity<pcl::PointXYZRGB,
                              IntensityLeaf,
                              pcl::octree::OctreeContainerEmpty,
                              pcl::octree::Octree2BufBase<IntensityLeaf>>>;
TYPED_TEST_SUITE(OctreeCoding, Trees);

TYPED_TEST(OctreeCoding, CountsHaveTheBytesOfTheCloud)
{
  OctreePointCloudIntensityCompression<pcl::PointXYZRGB, CountIntensity> of_clouds(
      settingsWith(resolution));
  OctreePointCloudIntensityCompression<pcl::PointXYZRGB, CountIntensity> of_octrees(
      settingsWith(resolution));
  TypeParam tree(resolution);
  for (const unsigned int seed : {1u, 1u, 2u}) {
    const auto cloud = randomCloud<pcl::PointXYZRGB>(seed, 2000, {0.3, -7.0, 1.0}, 0.5);
    for (pcl::PointXYZRGB& point : *cloud)
      point.r = point.g = point.b = 100; // means are the same, in whatever order
    fill<TypeParam, pcl::PointXYZRGB>(tree, cloud);
    Bytes expected;
    ASSERT_TRUE(of_clouds.encodePointCloud(cloud, expected).ok());
    std::stringstream stream;
    ASSERT_TRUE(of_octrees.encodeOctree(tree, stream).ok());
    const std::string written = stream.str();
    EXPECT_EQ(Bytes(written.begin(), written.end()), expected);
    EXPECT_EQ(of_octrees.statistics().coding.voxels, tree.getLeafCount());
  }
}

TEST(OctreeStreams, WhatLeavesAccumulateIsCoded)
{
  OctreePointCloudIntensity<pcl::PointXYZI, LargestIntensity> tree(resolution);
  fill<decltype(tree), pcl::PointXYZI>(
      tree, randomCloud<pcl::PointXYZI>(5, 2000, {0.0, 0.0, 0.0}, 0.5));
  using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  Bytes bytes;
  ASSERT_TRUE(Compression(settingsWith(resolution)).encodeOctree(tree, bytes).ok());
  Bytes expected;
  ASSERT_TRUE(Compression(settingsWith(resolution))
                  .encodePointCloud(centresOf(tree), expected)
                  .ok());
  EXPECT_EQ(bytes, expected);
}

TEST(OctreeStreams, VoxelsBetweenThoseOfTheGridAreMovedToTheNearest)
{
  OctreePointCloudIntensity<pcl::PointXYZI> tree(resolution);
  const double begin = -1.0 + 0.3 * resolution;
  const double end = begin + 32 * resolution;
  tree.defineBoundingBox(begin, begin, begin, end, end, end);
  const auto cloud = randomCloud<pcl::PointXYZI>(7, 500, {0.0, 0.0, 0.0}, 0.4);
  tree.setInputCloud(cloud);
  tree.addPointsFromInputCloud();
  OctreePointCloudIntensityCompression<pcl::PointXYZI> compression(
      settingsWith(resolution));
  Bytes bytes;
  ASSERT_TRUE(compression.encodeOctree(tree, bytes).ok());
  pcl::PointCloud<pcl::PointXYZI>::Ptr decoded;
  ASSERT_TRUE(compression.decodePointCloud(bytes.data(), bytes.size(), decoded).ok());
  ASSERT_EQ(decoded->size(), tree.getLeafCount());
  for (const pcl::PointXYZI& point : *decoded) {
    pcl::PointXYZI place = point;
    for (float* const coordinate : {&place.x, &place.y, &place.z})
      *coordinate += static_cast<float>(0.3 * resolution);
    EXPECT_NEAR(tree.getVoxelIntensityAtPoint(place), point.intensity, 0.01f);
  }
}

TEST(OctreeStreams, AnOctreeOfAnotherResolutionIsRefusedAndAnEmptyOneIsAFrame)
{
  OctreePointCloudIntensityCompression<pcl::PointXYZI> compression(
      settingsWith(resolution));
  OctreePointCloudIntensity<pcl::PointXYZI> coarse(2 * resolution);
  Bytes bytes(1);
  EXPECT_EQ(compression.encodeOctree(coarse, bytes).code(),
            CompressionCode::InvalidInput);
  EXPECT_TRUE(bytes.empty());
  OctreePointCloudIntensity<pcl::PointXYZI> none(resolution);
  ASSERT_TRUE(compression.encodeOctree(none, bytes).ok());
  EXPECT_EQ(compression.statistics().coding.frame_number, 1u);
  EXPECT_EQ(compression.statistics().coding.voxels, 0u);
}

TEST(OctreeStreams, LargerVoxelsOfTheRateControlTakeTheOctree)
{
  auto settings = settingsWith(resolution);
  settings.max_encode_ms = 0.1; // which no frame keeps, so that the edge is doubled
  OctreePointCloudIntensityCompression<pcl::PointXYZI> compression(settings);
  OctreePointCloudIntensity<pcl::PointXYZI> tree(resolution);
  fill<decltype(tree), pcl::PointXYZI>(
      tree, randomCloud<pcl::PointXYZI>(4, 200000, {0.0, 0.0, 0.0}, 4.0));
  Bytes bytes;
  for (int i = 0; i < 100 && compression.voxelFrame().grid.resolution <= resolution;
       ++i)
    ASSERT_TRUE(compression.encodeOctree(tree, bytes).ok());
  EXPECT_GT(compression.voxelFrame().grid.resolution, resolution);
}

TEST(OctreeStreams, ADecodedFrameFillsAnOctree)
{
  OctreePointCloudIntensityCompression<pcl::PointXYZRGB, CountIntensity> compression(
      settingsWith(resolution));
  OctreePointCloudIntensity<pcl::PointXYZRGB> tree(resolution);
  const auto cloud = randomCloud<pcl::PointXYZRGB>(3, 2000, {9.0, 0.0, -2.0}, 0.5);
  for (pcl::PointXYZRGB& point : *cloud)
    point.r = 255;
  fill<decltype(tree), pcl::PointXYZRGB>(tree, cloud);
  Bytes bytes;
  ASSERT_TRUE(compression.encodeOctree(tree, bytes).ok());
  pcl::PointCloud<pcl::PointXYZRGB>::Ptr decoded;
  ASSERT_TRUE(compression.decodePointCloud(bytes.data(), bytes.size(), decoded).ok());
  OctreePointCloudIntensity<pcl::PointXYZRGB> filled(resolution);
  filled.addVoxels(compression.voxelFrame());
  EXPECT_EQ(filled.getLeafCount(), tree.getLeafCount());
  for (const pcl::PointXYZRGB& point : *cloud) {
    EXPECT_EQ(filled.getVoxelIntensityAtPoint(point),
              tree.getVoxelIntensityAtPoint(point));
    ASSERT_TRUE(filled.getVoxelColourAtPoint(point));
    EXPECT_EQ(filled.getVoxelColourAtPoint(point)->r, 255);
  }
}

TEST(OctreeStreams, VoxelsThatTheLastFrameDidNotHaveAreNew)
{
  OctreePointCloudIntensity<pcl::PointXYZI,
                            IntensityLeaf,
                            pcl::octree::OctreeContainerEmpty,
                            pcl::octree::Octree2BufBase<IntensityLeaf>>
      tree(0.5);
  tree.defineBoundingBox(-4.0, -4.0, -4.0, 4.0, 4.0, 4.0);
  const pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZI>);
  cloud->emplace_back(0.1f, 0.1f, 0.1f, 4.0f);
  cloud->emplace_back(-3.0f, 0.1f, 0.1f, 5.0f);
  tree.setInputCloud(cloud);
  tree.addPointsFromInputCloud();
  tree.switchBuffers();
  (*cloud)[1] = pcl::PointXYZI(1.1f, 2.1f, 3.1f, 7.0f);
  tree.setInputCloud(cloud);
  tree.addPointsFromInputCloud();
  decltype(tree)::AlignedPointTVector centres;
  ASSERT_EQ(tree.getNewVoxelCenters(centres), 1u);
  EXPECT_EQ(centres[0].getVector3fMap(), Eigen::Vector3f(1.25f, 2.25f, 3.25f));
  EXPECT_EQ(centres[0].intensity, 7.0f);
  EXPECT_EQ(tree.getVoxelIntensityAtPoint((*cloud)[0]), 4.0f);
}

} // namespace

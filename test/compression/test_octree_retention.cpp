// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/octree/octree2buf_base.h>
#include <pcl/octree/octree_base.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace {

using pcl_ext::octree::IntensityLeaf;
using pcl_ext::test::encodeFrame;
using pcl_ext::test::NaiveVoxels;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::randomCloud;
using pcl_ext::test::roundTrip;
using pcl_ext::test::settingsWith;
using pcl_ext::test::VoxelIndex;
using pcl_ext::test::voxelOf;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using RealTime = pcl_ext::io::OctreePointCloudIntensityCompression<
    pcl::PointXYZI>::RealTimeStreamCompression;
using LowMemory = pcl_ext::io::OctreePointCloudIntensityCompression<
    pcl::PointXYZI>::SinglePointCloudCompressionLowMemory;

static_assert(
    std::is_base_of<pcl::octree::Octree2BufBase<IntensityLeaf>, RealTime>::value, "");
static_assert(std::is_base_of<pcl::octree::OctreeBase<IntensityLeaf>, LowMemory>::value,
              "");

template <typename CompressionT>
class OctreeRetention : public ::testing::Test {
protected:
  static pcl_ext::io::IntensityCompressionSettings
  retainingSettings(double resolution)
  {
    auto settings = settingsWith(resolution);
    settings.retain_octree = true;
    return settings;
  }

  static void
  expectAgreement(CompressionT& compression, const Cloud& decoded, double resolution)
  {
    ASSERT_EQ(compression.getLeafCount(), decoded.size());
    EXPECT_EQ(compression.getResolution(), resolution);
    std::map<VoxelIndex, float> intensities;
    for (const pcl::PointXYZI& point : decoded) {
      intensities[voxelOf(point, resolution)] = point.intensity;
      EXPECT_TRUE(compression.isVoxelOccupiedAtPoint(point)) << point;
      EXPECT_EQ(compression.getVoxelIntensityAtPoint(point), point.intensity) << point;
      EXPECT_EQ(compression.getVoxelDensityAtPoint(point), 1u) << point;
    }

    typename CompressionT::AlignedPointTVector centres;
    EXPECT_EQ(compression.getOccupiedVoxelCenters(centres), decoded.size());
    ASSERT_EQ(centres.size(), decoded.size());
    std::map<VoxelIndex, int> visits;
    for (const pcl::PointXYZI& centre : centres) {
      const VoxelIndex index = voxelOf(centre, resolution);
      ASSERT_EQ(intensities.count(index), 1u) << centre;
      EXPECT_EQ(++visits[index], 1);
      const float ulps = 1e-6f * std::max(1.0f, std::abs(centre.x));
      EXPECT_NEAR(centre.x, pcl_ext::test::centreOf(index[0], resolution), ulps);
    }

    // Until *leaf is null: the end iterators of PCL's Octree2BufBase belong to no
    // octree.
    std::size_t leaves = 0;
    for (auto leaf = compression.leaf_depth_begin(); *leaf != nullptr;
         ++leaf, ++leaves) {
      ASSERT_LT(leaves, centres.size());
      // Depth first is the order of the centres, and of the decoded cloud.
      const VoxelIndex index = voxelOf(centres[leaves], resolution);
      EXPECT_EQ(leaf.getLeafContainer().getIntensity(), intensities.at(index));
      EXPECT_EQ(leaf.getLeafContainer().getPointCounter(), 1u);
      EXPECT_EQ(voxelOf(decoded[leaves], resolution), index);
    }
    EXPECT_EQ(leaves, decoded.size());
  }

  static void
  expectAllOccupied(const Cloud& cloud, double resolution)
  {
    CompressionT compression(retainingSettings(resolution));
    std::ostringstream stream;
    ASSERT_TRUE(compression.encodePointCloud(cloud.makeShared(), stream).ok());
    for (const pcl::PointXYZI& point : cloud)
      EXPECT_TRUE(compression.isVoxelOccupiedAtPoint(point)) << point;
  }

  static void
  expectEmptySpace(const CompressionT& compression,
                   const NaiveVoxels& voxels,
                   double resolution)
  {
    std::size_t checked = 0;
    for (const auto& [index, voxel] : voxels)
      for (const std::int64_t step : {-1, 1, 1 << 20}) {
        const VoxelIndex neighbour = {index[0] + step, index[1], index[2]};
        if (voxels.count(neighbour) != 0)
          continue;
        pcl::PointXYZI point;
        point.x = pcl_ext::test::centreOf(neighbour[0], resolution);
        point.y = pcl_ext::test::centreOf(neighbour[1], resolution);
        point.z = pcl_ext::test::centreOf(neighbour[2], resolution);
        EXPECT_FALSE(compression.isVoxelOccupiedAtPoint(point)) << point;
        EXPECT_EQ(compression.getVoxelIntensityAtPoint(point), 0.0f) << point;
        ++checked;
      }
    EXPECT_TRUE(voxels.empty() || checked > voxels.size());
    EXPECT_FALSE(compression.isVoxelOccupiedAtPoint({9e4f, 0.0f, 0.0f}));
  }
};

using OctreeBases = ::testing::Types<RealTime, LowMemory>;
TYPED_TEST_SUITE(OctreeRetention, OctreeBases);

TYPED_TEST(OctreeRetention, AgreesOverFramesOfChangingGrids)
{
  const double resolution = 0.05;
  TypeParam encoder(this->retainingSettings(resolution));
  TypeParam decoder(this->retainingSettings(resolution));
  struct RandomCloud {
    std::array<double, 3> centre;
    double half_width;
    std::size_t points;
  };
  const std::vector<RandomCloud> clouds = {{{0.0, 0.0, 0.0}, 0.5, 0}, // empty
                                           {{0.0, 0.0, 0.0}, 0.5, 500},
                                           {{0.1, 0.0, 0.0}, 0.5, 500},
                                           {{0.0, 0.0, 0.0}, 6.0, 800}, // grows
                                           {{0.0, 0.0, 0.0}, 0.0, 1},
                                           {{0.0, 0.0, 0.0}, 0.5, 0},
                                           {{-30.0, 70.0, 2.0}, 0.7, 400},
                                           {{5000.0, -5000.0, 5000.0}, 0.5, 500},
                                           {{5000.0, -5000.0, 5000.0}, 0.5, 700},
                                           {{0.0, 0.0, 0.0}, 0.5, 500}};
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    SCOPED_TRACE("frame " + std::to_string(i));
    const auto cloud = randomCloud<pcl::PointXYZI>(10 + static_cast<unsigned int>(i),
                                                   clouds[i].points,
                                                   clouds[i].centre,
                                                   clouds[i].half_width);
    const auto decoded = roundTrip(encoder, decoder, cloud);
    const NaiveVoxels voxels = naiveVoxels(*cloud, resolution);
    ASSERT_EQ(decoded->size(), voxels.size());
    this->expectAgreement(encoder, *decoded, resolution);
    this->expectAgreement(decoder, *decoded, resolution);
    this->expectEmptySpace(encoder, voxels, resolution);
    this->expectEmptySpace(decoder, voxels, resolution);
  }
}

TYPED_TEST(OctreeRetention, AnswersForThePointsThatWereEncoded)
{
  // The octree must put a point into the voxel that the codec put it into: at
  // resolutions that no binary number is, far from the origin.
  for (const double resolution : {0.01, 0.04, 0.1})
    for (const double distance : {0.0, -7.0, 5000.0})
      this->expectAllOccupied(
          *randomCloud<pcl::PointXYZI>(30, 1000, {distance, -distance, distance}, 1.0),
          resolution);
  Cloud as_far_as_maps;
  for (int i = 0; i < 200; ++i)
    as_far_as_maps.push_back({500000.0f + 0.5f * static_cast<float>(i % 20),
                              500000.0f + 0.5f * static_cast<float>(i / 20),
                              0.0f});
  this->expectAllOccupied(as_far_as_maps, 0.05);
  // Whole centimetres on faces, as CAD models and simulated floors have them.
  for (const double resolution : {0.01, 0.04, 0.1})
    for (int first = -200; first < 200; first += 50) {
      Cloud cloud;
      for (int i = first; i < first + 20; ++i)
        cloud.push_back(
            pcl::PointXYZI(static_cast<float>(i * resolution), 0.0f, 0.0f, 1.0f));
      this->expectAllOccupied(cloud, resolution);
    }
}

TYPED_TEST(OctreeRetention, BoxesAndPublishedFramesAreRetainedToo)
{
  auto cropped = this->retainingSettings(0.05);
  cropped.bounding_box = pcl_ext::io::BoundingBox{{-0.3, -0.3, -0.3}, {0.3, 0.3, 0.3}};
  // A cube of 2^5 voxels about the origin, so that PCL's lattice is the world's.
  auto published = this->retainingSettings(0.05);
  published.format = pcl_ext::io::StreamFormat::Published;
  published.bounding_box =
      pcl_ext::io::BoundingBox{{-0.8, -0.8, -0.8}, {0.8, 0.8, 0.8}};
  for (const auto& settings : {cropped, published}) {
    TypeParam encoder(settings);
    TypeParam decoder(this->retainingSettings(0.02)); // the stream's resolution counts
    for (unsigned int frame = 0; frame < 3; ++frame) {
      const auto decoded =
          roundTrip(encoder, decoder, randomCloud<pcl::PointXYZI>(40 + frame, 900));
      ASSERT_FALSE(decoded->empty());
      this->expectAgreement(encoder, *decoded, 0.05);
      this->expectAgreement(decoder, *decoded, 0.05);
    }
  }
}

TYPED_TEST(OctreeRetention, ShowsTheLastFrameOfEitherDirectionAlsoBehindOneThatFails)
{
  TypeParam compression(this->retainingSettings(0.05));
  std::stringstream first;
  std::stringstream second;
  ASSERT_TRUE(
      compression.encodePointCloud(randomCloud<pcl::PointXYZI>(3, 300), first).ok());
  ASSERT_TRUE(
      compression.encodePointCloud(randomCloud<pcl::PointXYZI>(4, 600), second).ok());
  const auto leaves_of_second = compression.getLeafCount();
  Cloud::Ptr decoded;
  ASSERT_TRUE(compression.decodePointCloud(first, decoded).ok());
  EXPECT_NE(compression.getLeafCount(), leaves_of_second);
  this->expectAgreement(compression, *decoded, 0.05);
  ASSERT_TRUE(compression.decodePointCloud(second, decoded).ok());
  EXPECT_EQ(compression.getLeafCount(), leaves_of_second);
  const Cloud last = *decoded;
  std::stringstream rubbish("no frame at all");
  EXPECT_FALSE(compression.decodePointCloud(rubbish, decoded).ok());
  EXPECT_TRUE(decoded->empty());
  this->expectAgreement(compression, last, 0.05);
}

TYPED_TEST(OctreeRetention, IsOffByDefaultAndDoesNotChangeTheBytes)
{
  TypeParam with(this->retainingSettings(0.05));
  TypeParam without(settingsWith(0.05));
  for (unsigned int frame = 0; frame < 3; ++frame) {
    const auto cloud = randomCloud<pcl::PointXYZI>(50 + frame, 400);
    EXPECT_EQ(encodeFrame(with, cloud), encodeFrame(without, cloud));
    EXPECT_EQ(without.getLeafCount(), 0u);
    EXPECT_FALSE(without.isVoxelOccupiedAtPoint(cloud->front()));
  }
}

} // namespace

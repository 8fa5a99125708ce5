// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Colours and points through the class, for PCL's types that have a colour.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>

namespace {

using namespace pcl_ext::io;

/** \brief Points on a plane, more than a voxel of 1 cm apart, whose colours are all
 * different. */
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
colouredPlane()
{
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      PointT point;
      point.x = 0.0223f * static_cast<float>(x);
      point.y = 0.0223f * static_cast<float>(y);
      point.z = 1.0f;
      point.r = static_cast<std::uint8_t>(6 * x);
      point.g = static_cast<std::uint8_t>(6 * y);
      point.b = static_cast<std::uint8_t>(3 * (x + y));
      cloud->push_back(point);
    }
  return cloud;
}

template <typename PointT>
class Colours : public ::testing::Test {};

using ColouredTypes = ::testing::Types<pcl::PointXYZRGB,
                                       pcl::PointXYZRGBA,
                                       pcl::PointXYZRGBNormal,
                                       pcl::PointXYZRGBL>;
TYPED_TEST_SUITE(Colours, ColouredTypes, );

TYPED_TEST(Colours, ComeBackToTheirBits)
{
  using Compressor = OctreePointCloudIntensityCompression<TypeParam>;
  const auto cloud = colouredPlane<TypeParam>();
  for (const unsigned int bits : {1u, 4u, 6u, 8u}) {
    IntensityCompressionSettings settings;
    settings.resolution = 0.01;
    settings.colour_bits = bits;
    Compressor encoder(settings);
    Compressor decoder;
    const int most = static_cast<int>(std::lround(127.5 / (std::exp2(bits) - 1.0)));
    for (int frame = 0; frame < 3; ++frame) {
      std::stringstream stream;
      ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
      typename Compressor::PointCloudPtr decoded;
      ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
      ASSERT_EQ(decoded->size(), cloud->size());
      for (const TypeParam& point : *decoded) {
        const auto x = static_cast<std::size_t>(std::lround(point.x / 0.0223f));
        const auto y = static_cast<std::size_t>(std::lround(point.y / 0.0223f));
        const TypeParam& original = (*cloud)[40 * y + x];
        EXPECT_LE(std::abs(point.r - original.r), most);
        EXPECT_LE(std::abs(point.g - original.g), most);
        EXPECT_LE(std::abs(point.b - original.b), most);
        EXPECT_EQ(point.a, 255);
      }
    }
  }
}

TYPED_TEST(Colours, AreWhiteWhereTheProfileHasNone)
{
  OctreePointCloudIntensityCompression<TypeParam> compression(
      pcl::io::LOW_RES_ONLINE_COMPRESSION_WITHOUT_COLOR);
  std::stringstream stream;
  ASSERT_TRUE(compression.encodePointCloud(colouredPlane<TypeParam>(), stream).ok());
  EXPECT_EQ(compression.statistics().coding.attribute_bytes, 0u);
  typename pcl::PointCloud<TypeParam>::Ptr decoded;
  ASSERT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  for (const TypeParam& point : *decoded)
    EXPECT_EQ(point.r + point.g + point.b, 3 * 255);
}

TYPED_TEST(Colours, OfAnEmptyCloudAreNoOtherContent)
{
  using Compressor = OctreePointCloudIntensityCompression<TypeParam>;
  Compressor compression{IntensityCompressionSettings()};
  const auto cloud = colouredPlane<TypeParam>();
  const typename Compressor::PointCloudPtr empty(new pcl::PointCloud<TypeParam>);
  for (int frame = 0; frame < 4; ++frame) {
    std::stringstream stream;
    ASSERT_TRUE(
        compression.encodePointCloud(frame % 2 == 1 ? empty : cloud, stream).ok());
    EXPECT_EQ(compression.statistics().coding.is_i_frame, frame == 0) << frame;
  }
}

TYPED_TEST(Colours, AreKnownToRetainedOctrees)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.03;
  settings.colour_bits = 5;
  settings.retain_octree = true;
  using Compressor = OctreePointCloudIntensityCompression<TypeParam>;
  Compressor encoder(settings);
  Compressor decoder(settings);
  std::stringstream stream;
  ASSERT_TRUE(encoder.encodePointCloud(colouredPlane<TypeParam>(), stream).ok());
  typename Compressor::PointCloudPtr decoded;
  ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
  for (const Compressor* compression : {&encoder, &decoder})
    for (const TypeParam& point : *decoded) {
      const auto colour = compression->getVoxelColourAtPoint(point);
      ASSERT_TRUE(colour.has_value());
      EXPECT_TRUE(*colour == (VoxelColour{point.r, point.g, point.b}));
    }
  TypeParam elsewhere;
  elsewhere.x = -5.0f;
  EXPECT_FALSE(decoder.getVoxelColourAtPoint(elsewhere).has_value());
}

TYPED_TEST(Colours, OfAnOctreeAreTheMeansOfItsPoints)
{
  pcl_ext::octree::OctreePointCloudIntensity<TypeParam> octree(0.05);
  typename pcl::PointCloud<TypeParam>::Ptr cloud(new pcl::PointCloud<TypeParam>);
  for (const int grey : {10, 20, 33}) {
    TypeParam point;
    point.x = point.y = point.z = 0.02f;
    point.r = point.g = point.b = static_cast<std::uint8_t>(grey);
    cloud->push_back(point);
  }
  octree.defineBoundingBox(0.0, 0.0, 0.0, 1.0, 1.0, 1.0);
  octree.setInputCloud(cloud);
  octree.addPointsFromInputCloud();
  const auto colour = octree.getVoxelColourAtPoint(cloud->front());
  ASSERT_TRUE(colour.has_value());
  EXPECT_TRUE(*colour == (VoxelColour{21, 21, 21}));
}

TEST(FarOrigin, RetainedOctreesAnswerForTheirPoints)
{
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 200; ++i)
    cloud->push_back({500000.0f + 0.5f * static_cast<float>(i % 20),
                      500000.0f + 0.5f * static_cast<float>(i / 20),
                      0.0f});
  IntensityCompressionSettings settings;
  settings.resolution = 0.05;
  settings.retain_octree = true;
  OctreePointCloudIntensityCompression<pcl::PointXYZ> compression(settings);
  std::stringstream stream;
  ASSERT_TRUE(compression.encodePointCloud(cloud, stream).ok());
  for (const pcl::PointXYZ& point : *cloud)
    EXPECT_TRUE(compression.isVoxelOccupiedAtPoint(point));
}

TEST(NoIntensityModel, OfTypesWithoutTheFieldCostsNothing)
{
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 500; ++i)
    cloud->push_back({0.003f * static_cast<float>(i), 0.0f, 1.0f});
  IntensityCompressionSettings settings;
  OctreePointCloudIntensityCompression<pcl::PointXYZ> without(settings);
  OctreePointCloudIntensityCompression<pcl::PointXYZ, pcl_ext::CountIntensity> with(
      settings);
  std::stringstream stream;
  std::stringstream stream_with;
  ASSERT_TRUE(without.encodePointCloud(cloud, stream).ok());
  ASSERT_TRUE(with.encodePointCloud(cloud, stream_with).ok());
  EXPECT_LE(without.statistics().coding.intensity_bytes, 1u);
  EXPECT_LT(stream.str().size(), stream_with.str().size());
  // A receiver of intensities gets none from it, and counts from the other one.
  OctreePointCloudIntensityCompression<pcl::PointXYZI> receiver;
  pcl::PointCloud<pcl::PointXYZI>::Ptr decoded;
  ASSERT_TRUE(receiver.decodePointCloud(stream, decoded).ok());
  EXPECT_EQ((*decoded)[0].intensity, 0.0f);
  OctreePointCloudIntensityCompression<pcl::PointXYZI> counting_receiver;
  ASSERT_TRUE(counting_receiver.decodePointCloud(stream_with, decoded).ok());
  EXPECT_GT((*decoded)[0].intensity, 0.0f);
}

} // namespace

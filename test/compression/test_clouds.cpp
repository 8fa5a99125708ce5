// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/register_point_struct.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

struct PointWithByteIntensity {
  PCL_ADD_POINT4D;
  std::uint8_t intensity;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
} EIGEN_ALIGN16;

POINT_CLOUD_REGISTER_POINT_STRUCT(PointWithByteIntensity,
                                  (float, x, x)(float, y, y)(float, z, z)(std::uint8_t,
                                                                          intensity,
                                                                          intensity))

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;
using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

template <typename PointT, typename ModelT>
constexpr bool has_default_model =
    std::is_same<DefaultIntensityModel<PointT>, ModelT>::value;
static_assert(has_default_model<pcl::PointXYZI, pcl_ext::NativeIntensity>, "");
static_assert(has_default_model<pcl::PointXYZINormal, pcl_ext::NativeIntensity>, "");
static_assert(has_default_model<pcl::PointXYZ, pcl_ext::NoIntensity>, "");
static_assert(has_default_model<pcl::PointXYZRGB, pcl_ext::NoIntensity>, "");

template <typename PointT>
class PointTypes : public ::testing::Test {};

using TestedPointTypes = ::testing::Types<pcl::PointXYZ,
                                          pcl::PointXYZI,
                                          pcl::PointXYZL,
                                          pcl::PointXYZRGB,
                                          pcl::PointXYZRGBA,
                                          pcl::PointXYZRGBNormal,
                                          pcl::PointXYZINormal,
                                          pcl::PointNormal>;
TYPED_TEST_SUITE(PointTypes, TestedPointTypes);

TYPED_TEST(PointTypes, BecomeVoxelCentresWithTheMeanIntensity)
{
  constexpr double resolution = 0.05;
  for (const double distance : {1.0, -5000.0}) {
    const auto cloud =
        randomCloud<TypeParam>(14, 2000, {distance, -2.0 * distance, distance});
    const auto decoded = roundTrip<TypeParam>(resolution, cloud);
    const NaiveVoxels voxels = naiveVoxels(*cloud, resolution);
    expectVoxelCentres(*decoded, voxels, resolution);
    // Whole numbers up to 255 are coded in steps of 1.
    if constexpr (pcl_ext::has_intensity_field<TypeParam>)
      expectIntensities(
          *decoded,
          voxels,
          resolution,
          [](const NaiveVoxel& voxel) { return voxel.mean(); },
          0.5 + 1e-6);
  }
}

/** \brief Gives the fields that are not carried values other than their defaults. */
template <typename PointT>
void
paint(pcl::PointCloud<PointT>& cloud)
{
  for (PointT& point : cloud) {
    if constexpr (pcl::traits::has_color<PointT>::value) {
      point.r = 200;
      point.g = 100;
      point.b = 50;
      point.a = 7;
    }
    if constexpr (pcl::traits::has_normal<PointT>::value)
      point.normal_x = point.curvature = 0.75f;
    if constexpr (pcl::traits::has_label<PointT>::value)
      point.label = 77;
  }
}

TYPED_TEST(PointTypes, FieldsThatAreNotCarriedHaveTheirDefault)
{
  const auto cloud = randomCloud<TypeParam>(15, 100);
  paint(*cloud);
  OctreePointCloudIntensityCompression<TypeParam> compression(settingsWith(0.05));
  std::stringstream stream(encodeFrame(compression, cloud));
  typename pcl::PointCloud<TypeParam>::Ptr decoded(
      new pcl::PointCloud<TypeParam>(5000, 1));
  paint(*decoded);
  ASSERT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  ASSERT_FALSE(decoded->empty());
  const TypeParam blank;
  for (const TypeParam& point : *decoded) {
    if constexpr (pcl::traits::has_color<TypeParam>::value) {
      // 200, 100 and 50 in 63 steps; alpha is not carried.
      EXPECT_EQ(point.r, 198);
      EXPECT_EQ(point.g, 101);
      EXPECT_EQ(point.b, 49);
      EXPECT_EQ(point.a, 255);
    }
    if constexpr (pcl::traits::has_normal<TypeParam>::value) {
      EXPECT_EQ(point.normal_x, blank.normal_x);
      EXPECT_EQ(point.curvature, blank.curvature);
    }
    if constexpr (pcl::traits::has_label<TypeParam>::value) {
      EXPECT_EQ(point.label, blank.label);
    }
    EXPECT_EQ(point.data[3], blank.data[3]);
  }
}

TEST(WholeNumberFields, AreCarriedExactlyRoundedAndClampedToTheirRange)
{
  using Bytes = OctreePointCloudIntensityCompression<PointWithByteIntensity>;
  const Cloud::Ptr cloud(new Cloud);
  const Bytes::PointCloudPtr whole(new Bytes::PointCloud);
  const std::vector<float> intensities{-5.0f, 0.4f, 99.6f, 100.7f, 254.6f, 300.0f};
  const std::vector<std::uint8_t> expected{0, 0, 100, 101, 255, 255};
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    const float x = static_cast<float>(i) + 0.5f;
    cloud->emplace_back(x, 0.5f, 0.5f, intensities[i]);
    PointWithByteIntensity& point = whole->emplace_back();
    point.getVector3fMap() = cloud->back().getVector3fMap();
    point.intensity = expected[i];
  }
  for (const auto& decoded : {roundTrip(Compression(settingsWith(1.0)), Bytes(), cloud),
                              roundTrip(Bytes(settingsWith(1.0)), Bytes(), whole)}) {
    ASSERT_EQ(decoded->size(), intensities.size());
    for (const PointWithByteIntensity& point : *decoded)
      EXPECT_EQ(point.intensity, expected[static_cast<std::size_t>(point.x)]);
  }
}

TEST(HeaderPassthrough, OnCarriesStampAndFrame)
{
  IntensityCompressionSettings settings = settingsWith(0.04);
  settings.carry_header = true;
  Compression encoder(settings);
  Compression decoder; // the stream decides, not the receiver's settings
  std::stringstream stream;
  const std::vector<std::string> frames = {"cell", "cell", "map", "", "map"};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto cloud = randomCloud<pcl::PointXYZI>(20, 200);
    cloud->header.frame_id = frames[i];
    cloud->header.stamp = 18446744073709551000u + i;
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    EXPECT_EQ(decoded->header.frame_id, frames[i]);
    EXPECT_EQ(decoded->header.stamp, 18446744073709551000u + i);
  }
}

TEST(HeaderPassthrough, OffCostsNothingAndLeavesTheOutputsHeaderAlone)
{
  Compression first(settingsWith(0.04));
  Compression second(settingsWith(0.04));
  for (unsigned int frame = 0; frame < 3; ++frame) {
    const auto cloud = randomCloud<pcl::PointXYZI>(21 + frame, 200);
    const std::string plain = encodeFrame(first, cloud);
    cloud->header.frame_id = "cell";
    cloud->header.stamp = 123456789;
    std::stringstream stream(encodeFrame(second, cloud));
    EXPECT_EQ(stream.str(), plain);

    Cloud::Ptr decoded(new Cloud);
    decoded->header.frame_id = "mine";
    decoded->header.stamp = 5;
    ASSERT_TRUE(second.decodePointCloud(stream, decoded).ok());
    EXPECT_EQ(decoded->header.frame_id, "mine");
    EXPECT_EQ(decoded->header.stamp, 5u);
  }
}

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

TYPED_TEST(Colours, AreWhiteWhereTheProfileHasNone)
{
  OctreePointCloudIntensityCompression<TypeParam> compression(
      pcl::io::LOW_RES_ONLINE_COMPRESSION_WITHOUT_COLOR);
  const auto decoded = roundTrip(compression, colouredPlane<TypeParam>());
  EXPECT_EQ(compression.statistics().coding.attribute_bytes, 0u);
  for (const TypeParam& point : *decoded)
    EXPECT_EQ(point.r + point.g + point.b, 3 * 255);
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
  const auto decoded = roundTrip(encoder, decoder, colouredPlane<TypeParam>());
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

TEST(NoIntensityModel, OfTypesWithoutTheFieldCostsNothing)
{
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 500; ++i)
    cloud->push_back({0.003f * static_cast<float>(i), 0.0f, 1.0f});
  IntensityCompressionSettings settings;
  OctreePointCloudIntensityCompression<pcl::PointXYZ> without(settings);
  OctreePointCloudIntensityCompression<pcl::PointXYZ, pcl_ext::CountIntensity> with(
      settings);
  // A receiver of intensities gets none from it, and counts from the other one.
  using Receiver = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  EXPECT_EQ((*roundTrip(without, Receiver(), cloud))[0].intensity, 0.0f);
  expectIntensities(
      *roundTrip(with, Receiver(), cloud),
      naiveVoxels(*cloud, settings.resolution),
      settings.resolution,
      [](const NaiveVoxel& voxel) { return static_cast<double>(voxel.count); },
      0.0);
  EXPECT_LE(without.statistics().coding.intensity_bytes, 1u);
  EXPECT_LT(without.statistics().coding.bytes, with.statistics().coding.bytes);
}

} // namespace

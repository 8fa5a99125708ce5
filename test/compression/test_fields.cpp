// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>

#include "support/cloud_streams.h"
#include "support/text_parts.h"

#include <pcl/point_types.h>
#include <pcl/register_point_struct.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <vector>

struct PointXYZIRT {
  PCL_ADD_POINT4D
  float intensity;
  std::uint16_t ring;
  double timestamp;
  float descriptor[4];
  PCL_MAKE_ALIGNED_OPERATOR_NEW
} EIGEN_ALIGN16;

// clang-format off
POINT_CLOUD_REGISTER_POINT_STRUCT(PointXYZIRT,
                                  (float, x, x)(float, y, y)(float, z, z)
                                  (float, intensity, intensity)
                                  (std::uint16_t, ring, ring)
                                  (double, timestamp, timestamp)
                                  (float[4], descriptor, descriptor))
// clang-format on

/** \brief A point with a clock, which frames have no field for. */
struct PointXYZClock {
  PCL_ADD_POINT4D
  std::uint64_t clock;
  std::uint16_t ring;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
} EIGEN_ALIGN16;

// clang-format off
POINT_CLOUD_REGISTER_POINT_STRUCT(PointXYZClock,
                                  (float, x, x)(float, y, y)(float, z, z)
                                  (std::uint64_t, clock, clock)
                                  (std::uint16_t, ring, ring))
// clang-format on

/** \brief Points of 16 bytes that end with a colour, and of 24 with a wider one. */
struct PointXYZColour {
  float x;
  float y;
  float z;
  float rgb;
};

struct PointXYZWideColour {
  float x;
  float y;
  float z;
  double rgb;
};

// clang-format off
POINT_CLOUD_REGISTER_POINT_STRUCT(PointXYZColour,
                                  (float, x, x)(float, y, y)(float, z, z)
                                  (float, rgb, rgb))
POINT_CLOUD_REGISTER_POINT_STRUCT(PointXYZWideColour,
                                  (float, x, x)(float, y, y)(float, z, z)
                                  (double, rgb, rgb))
// clang-format on

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using pcl_ext::test::roundTrip;

pcl::PointCloud<PointXYZIRT>::Ptr
lidarCloud()
{
  std::mt19937 random(3);
  pcl::PointCloud<PointXYZIRT>::Ptr cloud(new pcl::PointCloud<PointXYZIRT>);
  for (int i = 0; i < 2000; ++i) {
    PointXYZIRT point{};
    point.x = 0.01f * static_cast<float>(random() % 500);
    point.y = 0.01f * static_cast<float>(random() % 500);
    point.z = 0.02f * static_cast<float>(i % 32);
    point.intensity = 0.37f * static_cast<float>(random() % 1000);
    point.ring = static_cast<std::uint16_t>(i % 32);
    point.timestamp = 1.7e9 + 1e-4 * i; // tells the points apart
    for (float& value : point.descriptor)
      value = static_cast<float>(random() % 100);
    cloud->push_back(point);
  }
  return cloud;
}

/** \brief Settings that keep points with fields. */
IntensityCompressionSettings
pointSettings(double resolution, const std::vector<FieldSetting>& fields)
{
  IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.keep_points = true;
  settings.fields = fields;
  return settings;
}

TEST(ClassFields, OfARegisteredTypeComeBackPointByPoint)
{
  using Compressor = OctreePointCloudIntensityCompression<PointXYZIRT, NativeIntensity>;
  const auto cloud = lidarCloud();
  const auto received =
      roundTrip(Compressor(pointSettings(0.1, {{all_fields}})), Compressor(), cloud);
  ASSERT_EQ(received->size(), cloud->size());
  std::map<double, PointXYZIRT> by_time;
  for (const PointXYZIRT& point : *cloud)
    by_time[point.timestamp] = point;
  for (const PointXYZIRT& point : *received) {
    ASSERT_EQ(by_time.count(point.timestamp), 1u);
    const PointXYZIRT original = by_time.at(point.timestamp);
    by_time.erase(point.timestamp);
    EXPECT_LE(
        (point.getVector3fMap() - original.getVector3fMap()).lpNorm<Eigen::Infinity>(),
        0.0501f);
    // Its own, not the mean of its voxel.
    EXPECT_EQ(point.intensity, original.intensity);
    EXPECT_EQ(point.ring, original.ring);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_EQ(point.descriptor[i], original.descriptor[i]);
  }
  EXPECT_TRUE(by_time.empty());
}

TEST(ClassFields, GoToFieldsOfOtherTypesByName)
{
  const IntensityCompressionSettings settings =
      pointSettings(0.1, {{"timestamp", 0.5}, {"intensity"}});
  using Encoder = OctreePointCloudIntensityCompression<PointXYZIRT, NativeIntensity>;
  using Decoder = OctreePointCloudIntensityCompression<pcl::PointXYZI, NativeIntensity>;
  const auto cloud = lidarCloud();
  const auto received = roundTrip(Encoder(settings), Decoder(), cloud);
  std::multiset<float> sent_intensities;
  for (const PointXYZIRT& point : *cloud)
    sent_intensities.insert(point.intensity);
  std::multiset<float> intensities;
  for (const pcl::PointXYZI& point : *received)
    intensities.insert(point.intensity);
  EXPECT_EQ(intensities, sent_intensities);
}

TEST(ClassFields, OfOtherTypesThanFramesHaveAreRefusedByNameAndNotAmongAll)
{
  pcl::PointCloud<PointXYZClock>::Ptr cloud(new pcl::PointCloud<PointXYZClock>);
  cloud->resize(1);
  cloud->front().ring = 7;
  using Compressor = OctreePointCloudIntensityCompression<PointXYZClock>;
  IntensityCompressionSettings settings;
  settings.fields = {{"clock"}};
  std::stringstream stream;
  EXPECT_TRUE(pcl_ext::test::hasPart(
      Compressor(settings).encodePointCloud(cloud, stream).message(),
      "field 'clock' cannot be kept: its datatype is none of int8 to uint32, float32 "
      "and float64"));
  settings.fields = {{all_fields}};
  EXPECT_EQ(Compressor(settings).encodePointCloud(cloud, stream).message(),
            "fields that cannot be kept: 'clock'");
  const auto received = roundTrip(Compressor(settings), Compressor(), cloud);
  EXPECT_EQ(received->front().ring, 7);
}

TEST(ClassFields, OfPackedColoursAreRefusedWithAStep)
{
  pcl::PointCloud<pcl::PointXYZRGB>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGB>);
  cloud->push_back(pcl::PointXYZRGB());
  IntensityCompressionSettings settings;
  settings.fields = {{"rgb", 4.0}};
  for (const bool keep_order : {false, true}) {
    settings.keep_order = keep_order;
    OctreePointCloudIntensityCompression<pcl::PointXYZRGB, NoIntensity> encoder(
        settings);
    std::stringstream stream;
    EXPECT_TRUE(
        pcl_ext::test::hasPart(encoder.encodePointCloud(cloud, stream).message(),
                               "field 'rgb' cannot be kept: it is a packed colour and "
                               "its step is 4"));
  }
}

TEST(ClassFields, AndColoursStayThoseOfTheStreamInAnEmptyCloud)
{
  IntensityCompressionSettings settings;
  settings.fields = {{"label"}};
  OctreePointCloudIntensityCompression<pcl::PointXYZRGBL> encoder(settings);
  std::stringstream stream;
  for (const unsigned int points : {9u, 0u, 9u, 0u}) {
    const pcl::PointCloud<pcl::PointXYZRGBL> cloud(points, 1);
    ASSERT_TRUE(encoder.encodePointCloud(cloud.makeShared(), stream).ok());
    EXPECT_EQ(encoder.statistics().coding.is_i_frame,
              encoder.statistics().coding.frame_number == 1);
  }
}

/** \brief Expects that points come back with their colours, by their labels. */
void
expectColoursOfPoints(unsigned int colour_bits, float spacing)
{
  IntensityCompressionSettings settings = pointSettings(1.0, {{all_fields}});
  settings.colour_bits = colour_bits;
  pcl::PointCloud<pcl::PointXYZRGBL>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGBL>);
  for (std::uint32_t i = 0; i < 300; ++i) {
    pcl::PointXYZRGBL point;
    point.x = point.y = point.z = 0.5f + spacing * static_cast<float>(i);
    point.rgba = 0xff000000u + 7919 * i;
    point.label = i; // the points of a voxel ascend with the first field
    cloud->push_back(point);
  }
  using Compressor = OctreePointCloudIntensityCompression<pcl::PointXYZRGBL>;
  const auto received = roundTrip(Compressor(settings), Compressor(), cloud);
  ASSERT_EQ(received->size(), cloud->size());
  std::map<std::uint32_t, std::uint32_t> colours;
  for (const auto& point : *received)
    colours[point.label] = point.rgba;
  for (const auto& point : *cloud)
    EXPECT_EQ(colours[point.label], point.rgba);
}

TEST(ClassFields, OfColoursAreExactWhereAllAreMeant)
{
  for (const unsigned int colour_bits : {0u, 4u, 6u})
    for (const float spacing :
         {0.0f, 0.2f, 1.5f}) { // voxels of many points, and of one
      SCOPED_TRACE(std::to_string(colour_bits) + " bits, " + std::to_string(spacing));
      expectColoursOfPoints(colour_bits, spacing);
    }
}

TEST(ClassFields, OfColoursWithAnAlphaAreToldWhereAScanLosesIt)
{
  pcl::PointCloud<pcl::PointXYZRGBA>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGBA>);
  for (std::uint32_t i = 0; i < 20; ++i) {
    pcl::PointXYZRGBA& point = cloud->emplace_back();
    point.x = 0.1f * static_cast<float>(i);
    point.rgba = (i < 2 ? 0x80000000u : 0xff000000u) + 76543 * i;
  }
  IntensityCompressionSettings settings;
  settings.keep_order = true;
  settings.fields = {{all_fields}};
  using Compressor = OctreePointCloudIntensityCompression<pcl::PointXYZRGBA>;
  for (const unsigned int colour_bits : {8u, 0u}) {
    settings.colour_bits = colour_bits;
    Compressor encoder(settings);
    std::vector<std::uint8_t> bytes;
    EXPECT_EQ(encoder.encodePointCloud(cloud, bytes).message(),
              colour_bits == 0 ? ""
                               : "2 of 20 points have a colour with an alpha, which a "
                                 "scan does not keep; set colour_bits to 0 to keep the "
                                 "field as it is");
    pcl::PointCloud<pcl::PointXYZRGBA>::Ptr received;
    ASSERT_TRUE(
        Compressor().decodePointCloud(bytes.data(), bytes.size(), received).ok());
    ASSERT_EQ(received->size(), cloud->size());
    for (std::size_t i = 0; i < cloud->size(); ++i)
      EXPECT_EQ((*received)[i].rgba,
                (*cloud)[i].rgba | (colour_bits == 0 ? 0 : 0xff000000u));
  }
}

TEST(ClassFields, OfColoursGoToTypesThatNameThemOtherwise)
{
  pcl::PointCloud<pcl::PointXYZRGB>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGB>);
  std::multiset<std::uint32_t> sent;
  for (std::uint32_t i = 0; i < 20; ++i) {
    pcl::PointXYZRGB& point = cloud->emplace_back(0.1f, 0.2f, 0.3f);
    point.rgba = 0xff000000u + 76543 * i;
    sent.insert(point.rgba);
  }
  using Encoder = OctreePointCloudIntensityCompression<pcl::PointXYZRGB>;
  using Decoder = OctreePointCloudIntensityCompression<pcl::PointXYZRGBA>;
  const auto decoded =
      roundTrip(Encoder(pointSettings(0.01, {{all_fields}})), Decoder(), cloud);
  std::multiset<std::uint32_t> received;
  for (const auto& point : *decoded)
    received.insert(point.rgba);
  EXPECT_EQ(received, sent);
}

TEST(ClassFields, OfAnyTypeNamedAsAColourStayInTheirPoints)
{
  pcl::PointCloud<PointXYZWideColour>::Ptr cloud(
      new pcl::PointCloud<PointXYZWideColour>);
  cloud->push_back({1.0f, 2.0f, 3.0f, 0.25});
  cloud->push_back({4.0f, 5.0f, 6.0f, 0.75});
  IntensityCompressionSettings settings;
  settings.fields = {{"rgb"}};
  settings.colour_bits = 0;
  using Encoder = OctreePointCloudIntensityCompression<PointXYZWideColour>;
  using Decoder = OctreePointCloudIntensityCompression<PointXYZColour>;
  const auto received = roundTrip(Encoder(settings), Decoder(), cloud);
  ASSERT_EQ(received->size(), 2u);
  EXPECT_EQ(received->at(0).rgb, 0.25f); // a number, converted
  EXPECT_EQ(received->at(1).rgb, 0.75f);
  EXPECT_NEAR(received->at(1).x, 4.0f, 0.02f);
}

TEST(ClassFields, OfRingsTellTheOrderOfAnUnorganisedCloud)
{
  auto cloud = lidarCloud();
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    const float angle = 2.0f * static_cast<float>(M_PI) / 125.0f *
                        static_cast<float>(i / 16); // half a turn of 16 rings
    PointXYZIRT& point = (*cloud)[i];
    point.ring = static_cast<std::uint16_t>(i % 16);
    point.x = 4.0f * std::cos(angle);
    point.y = 4.0f * std::sin(angle);
    point.z = 0.1f * point.ring;
  }
  using Compressor = OctreePointCloudIntensityCompression<PointXYZIRT, NoIntensity>;
  Compressor compressor(pointSettings(0.001, {}));
  const auto received = roundTrip(compressor, Compressor(), cloud);
  EXPECT_TRUE(compressor.statistics().coding.has_points);
  EXPECT_EQ(received->size(), cloud->size());
  EXPECT_EQ(received->height, 1u);
  EXPECT_TRUE(received->is_dense);
}

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
  const IntensityCompressionSettings settings = pointSettings(0.001, {{"rgb"}});
  for (const bool has_gaps : {false, true}) {
    const auto cloud = wallCloud(has_gaps);
    using Compressor =
        OctreePointCloudIntensityCompression<pcl::PointXYZRGB, NoIntensity>;
    const auto received = roundTrip(Compressor(settings), Compressor(), cloud);
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

TEST(OrganisedClouds, VoxelsAreMadeWhereTheyAreAskedFor)
{
  IntensityCompressionSettings settings = pointSettings(0.001, {});
  settings.colour_bits = 8;
  for (const bool retains_octree : {false, true}) {
    settings.retain_octree = retains_octree;
    using Compressor =
        OctreePointCloudIntensityCompression<pcl::PointXYZRGB, NoIntensity>;
    const auto sent = wallCloud(true);
    Compressor compressor(settings);
    const auto cloud = roundTrip(compressor, compressor, sent);
    const VoxelFrame& frame = compressor.voxelFrame();
    EXPECT_TRUE(isConsistent(frame));
    EXPECT_GT(frame.size(), 5000u);
    EXPECT_EQ(&compressor.voxelFrame(), &frame);
    const auto points =
        std::count_if(cloud->begin(), cloud->end(), [](const pcl::PointXYZRGB& point) {
          return std::isfinite(point.x);
        });
    EXPECT_EQ(frame.pointCount(), static_cast<std::size_t>(points));
    EXPECT_EQ(compressor.getLeafCount(), retains_octree ? frame.size() : 0u);
  }
}

} // namespace

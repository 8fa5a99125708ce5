/*
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *  Point Cloud Library (PCL) - www.pointclouds.org
 *  Copyright (c) 2014-, Open Perception Inc.
 *
 *  All rights reserved
 */

#define PCL_NO_PRECOMPILE // for a point type of our own

#include <pcl/compression/impl/octree_pointcloud_compression.hpp>
#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/test/gtest.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

struct PointOfManyTypes {
  PCL_ADD_POINT4D;
  std::int8_t signed_byte = 0;
  std::uint8_t byte = 0;
  std::int16_t signed_short = 0;
  std::uint16_t ring = 0;
  std::int32_t signed_int = 0;
  std::uint32_t label = 0;
  float intensity = 0.0f;
  double time = 0.0;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

POINT_CLOUD_REGISTER_POINT_STRUCT(
    PointOfManyTypes,
    (float, x, x)(float, y, y)(float, z, z)(std::int8_t, signed_byte, signed_byte)(
        std::uint8_t, byte, byte)(std::int16_t, signed_short, signed_short)(
        std::uint16_t, ring, ring)(std::int32_t, signed_int, signed_int)(
        std::uint32_t, label, label)(float, intensity, intensity)(double, time, time))

namespace {

template <typename PointT>
using Compression = pcl::io::OctreePointCloudCompression<PointT>;

pcl::PointCloud<PointOfManyTypes>
makeCloud()
{
  pcl::PointCloud<PointOfManyTypes> cloud;
  for (int i = 0; i < 100; ++i) {
    PointOfManyTypes point;
    point.x = 0.25f * static_cast<float>(i / 2);
    point.y = point.z = 0.0f;
    point.signed_byte = static_cast<std::int8_t>(i - 128);
    point.byte = static_cast<std::uint8_t>(255 - i);
    point.signed_short = static_cast<std::int16_t>(-32768 + 2 * i);
    point.ring = static_cast<std::uint16_t>(i * 7 % 64);
    point.signed_int = std::numeric_limits<std::int32_t>::min() + i;
    point.label = std::numeric_limits<std::uint32_t>::max() - i;
    point.intensity = static_cast<float>(i) * 0.5f;
    point.time = 1.7e9 + i * 1e-3;
    cloud.push_back(point);
  }
  return cloud;
}

std::string
encode(Compression<PointOfManyTypes>& encoder,
       const pcl::PointCloud<PointOfManyTypes>& cloud)
{
  std::ostringstream stream;
  encoder.encodePointCloud(cloud.makeShared(), stream);
  return stream.str();
}

template <typename PointT>
pcl::PointCloud<PointT>
decode(const std::string& bytes)
{
  Compression<PointT> decoder;
  std::istringstream stream(bytes);
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  decoder.decodePointCloud(stream, cloud);
  return *cloud;
}

} // namespace

// By default the profile has two points in a voxel coded one by one. Values are whole
// numbers in a range below 256, but for the time.
TEST(ScalarFieldCoding, FieldsOfAllTypes)
{
  const auto cloud = makeCloud();
  Compression<PointOfManyTypes> encoder;
  encoder.setScalarFields(
      {"signed_byte", "byte", "signed_short", "ring", "signed_int", "label", "time"},
      8);
  auto decoded = decode<PointOfManyTypes>(encode(encoder, cloud));
  ASSERT_EQ(decoded.size(), cloud.size());
  std::sort(decoded.begin(), decoded.end(), [](const auto& a, const auto& b) {
    return a.signed_int < b.signed_int;
  });
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_EQ(decoded[i].signed_byte, cloud[i].signed_byte);
    EXPECT_EQ(decoded[i].byte, cloud[i].byte);
    EXPECT_EQ(decoded[i].signed_short, cloud[i].signed_short);
    EXPECT_EQ(decoded[i].ring, cloud[i].ring);
    EXPECT_EQ(decoded[i].signed_int, cloud[i].signed_int);
    EXPECT_EQ(decoded[i].label, cloud[i].label);
    EXPECT_NEAR(decoded[i].time, cloud[i].time, 0.099 / 255 / 2 + 1e-6);
    EXPECT_EQ(decoded[i].intensity, 0.0f); // not selected
  }
}

// Whole numbers of a larger range than the scale are coded as others are.
TEST(ScalarFieldCoding, LargeRange)
{
  auto cloud = makeCloud();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud[i].label = i % 2 == 0 ? 0 : std::numeric_limits<std::uint32_t>::max();
  cloud[50].label = 1000000000;
  Compression<PointOfManyTypes> encoder;
  encoder.setScalarFields({"label", "signed_int"}, 8);
  auto decoded = decode<PointOfManyTypes>(encode(encoder, cloud));
  std::sort(decoded.begin(), decoded.end(), [](const auto& a, const auto& b) {
    return a.signed_int < b.signed_int;
  });
  const double step = 4294967295.0 / 255.0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_NEAR(decoded[i].label, cloud[i].label, i == 50 ? step / 2 + 1 : 0.0);
}

// Whole numbers are exact in double, too, also far from 0, and a value that is not
// finite takes nothing from the others.
TEST(ScalarFieldCoding, WholeNumbersOfDouble)
{
  for (const double lowest : {-77.0, 9007199254740992.0 - 300})
    for (const int range : {99, 100, 255, 300})
      for (const bool all_finite : {true, false}) {
        SCOPED_TRACE(testing::Message() << lowest << ' ' << range << ' ' << all_finite);
        auto cloud = makeCloud();
        for (std::size_t i = 0; i < cloud.size(); ++i)
          cloud[i].time = lowest + static_cast<double>(i);
        cloud[99].time = lowest + range;
        if (!all_finite)
          cloud[1].time = std::numeric_limits<double>::infinity();
        Compression<PointOfManyTypes> encoder;
        encoder.setScalarFields({"time", "time", "signed_int"}, range < 256 ? 9 : 16);
        auto decoded = decode<PointOfManyTypes>(encode(encoder, cloud));
        ASSERT_EQ(decoded.size(), cloud.size());
        std::sort(decoded.begin(), decoded.end(), [](const auto& a, const auto& b) {
          return a.signed_int < b.signed_int;
        });
        for (std::size_t i = 0; i < cloud.size(); ++i) {
          if (std::isfinite(cloud[i].time))
            EXPECT_EQ(decoded[i].time, cloud[i].time);
          else
            EXPECT_TRUE(std::isnan(decoded[i].time));
        }
      }
}

// The range of these values is infinite in double.
TEST(ScalarFieldCoding, WholeRangeOfDouble)
{
  const double most = std::numeric_limits<double>::max();
  auto cloud = makeCloud();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud[i].time = i % 2 == 0 ? -most : most;
  Compression<PointOfManyTypes> encoder;
  encoder.setScalarFields({"time", "signed_int"});
  auto decoded = decode<PointOfManyTypes>(encode(encoder, cloud));
  ASSERT_EQ(decoded.size(), cloud.size());
  std::sort(decoded.begin(), decoded.end(), [](const auto& a, const auto& b) {
    return a.signed_int < b.signed_int;
  });
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_EQ(decoded[i].time, cloud[i].time);
}

TEST(ScalarFieldCoding, FieldsThatAreNotCoded)
{
  const auto cloud = makeCloud();
  Compression<PointOfManyTypes> none, others;
  none.setScalarFields({});
  others.setScalarFields({"x", "y", "z", "rgb", "no such field"});
  EXPECT_EQ(encode(none, cloud), encode(others, cloud));

  Compression<PointOfManyTypes> once, twice;
  once.setScalarFields({"ring"});
  twice.setScalarFields({"ring", "no such field", "ring"});
  EXPECT_EQ(encode(once, cloud), encode(twice, cloud));
}

// If one field cannot be read, those before it are not decoded either.
TEST(ScalarFieldCoding, LastFieldEndsTooEarly)
{
  Compression<PointOfManyTypes> encoder;
  encoder.setScalarFields({"ring", "label"});
  const std::string bytes = encode(encoder, makeCloud());
  const std::size_t header = bytes.find("<PCL-OCT-COMPRESSED>");
  const std::size_t start_of_size = std::strlen("<PCL-OCT-SCALAR-FIELDS>");
  std::string fields = bytes.substr(0, header - 1);
  const auto size =
      static_cast<std::uint32_t>(fields.size() - start_of_size - sizeof(std::uint32_t));
  std::memcpy(&fields[start_of_size], &size, sizeof(size));
  const auto decoded = decode<PointOfManyTypes>(fields + bytes.substr(header));
  EXPECT_EQ(decoded.size(), 100u);
  for (const auto& point : decoded) {
    EXPECT_EQ(point.ring, 0u);
    EXPECT_EQ(point.label, 0u);
  }
}

TEST(ScalarFieldCoding, DecoderOfAnotherPointType)
{
  Compression<PointOfManyTypes> encoder;
  encoder.setScalarFields({"ring", "intensity", "label"});
  const std::string bytes = encode(encoder, makeCloud());
  EXPECT_EQ(decode<pcl::PointXYZ>(bytes).size(), 100u);
  auto decoded = decode<pcl::PointXYZI>(bytes);
  ASSERT_EQ(decoded.size(), 100u);
  std::sort(decoded.begin(), decoded.end(), [](const auto& a, const auto& b) {
    return a.intensity < b.intensity;
  });
  for (std::size_t i = 0; i < decoded.size(); ++i)
    EXPECT_NEAR(decoded[i].intensity, 0.5 * static_cast<double>(i), 49.5 / 65535 / 2);
}

int
main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  return (RUN_ALL_TESTS());
}

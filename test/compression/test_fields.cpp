// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Fields of points through the class, for PCL's types and for registered ones.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>

#include <pcl/point_types.h>
#include <pcl/register_point_struct.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <vector>

/** \brief A point of a lidar, as its ROS driver publishes it. */
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

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;

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

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
sentAndReceived(const IntensityCompressionSettings& settings,
                const typename pcl::PointCloud<PointT>::ConstPtr& cloud)
{
  using Compressor = OctreePointCloudIntensityCompression<PointT, NativeIntensity>;
  std::stringstream stream;
  EXPECT_TRUE(Compressor(settings).encodePointCloud(cloud, stream).ok());
  typename Compressor::PointCloudPtr received;
  Compressor decoder;
  EXPECT_TRUE(decoder.decodePointCloud(stream, received).ok());
  return received;
}

TEST(ClassFields, OfARegisteredTypeComeBackPointByPoint)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.1;
  settings.keep_points = true;
  settings.fields = {{all_fields}};
  const auto cloud = lidarCloud();
  const auto received = sentAndReceived<PointXYZIRT>(settings, cloud);
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
  IntensityCompressionSettings settings;
  settings.resolution = 0.1;
  settings.keep_points = true;
  settings.fields = {{"timestamp", 0.5}, {"intensity"}};
  using Encoder = OctreePointCloudIntensityCompression<PointXYZIRT, NativeIntensity>;
  using Decoder = OctreePointCloudIntensityCompression<pcl::PointXYZI, NativeIntensity>;
  std::stringstream stream;
  const auto cloud = lidarCloud();
  ASSERT_TRUE(Encoder(settings).encodePointCloud(cloud, stream).ok());
  Decoder decoder;
  Decoder::PointCloudPtr received;
  ASSERT_TRUE(decoder.decodePointCloud(stream, received).ok());
  std::multiset<float> sent_intensities;
  for (const PointXYZIRT& point : *cloud)
    sent_intensities.insert(point.intensity);
  std::multiset<float> intensities;
  for (const pcl::PointXYZI& point : *received)
    intensities.insert(point.intensity);
  EXPECT_EQ(intensities, sent_intensities);
}

TEST(ClassFields, StayThoseOfTheStreamInAnEmptyCloud)
{
  IntensityCompressionSettings settings;
  settings.fields = {{"ring"}};
  OctreePointCloudIntensityCompression<PointXYZIRT> encoder(settings);
  std::stringstream stream;
  ASSERT_TRUE(encoder.encodePointCloud(lidarCloud(), stream).ok());
  const pcl::PointCloud<PointXYZIRT>::Ptr empty(new pcl::PointCloud<PointXYZIRT>);
  ASSERT_TRUE(encoder.encodePointCloud(empty, stream).ok());
  EXPECT_FALSE(encoder.statistics().coding.is_i_frame);
}

TEST(ClassFields, OfNormalsAreMeansInVoxels)
{
  IntensityCompressionSettings settings;
  settings.resolution = 1.0;
  settings.fields = {{"normal_x"}, {"curvature", 0.25}};
  pcl::PointCloud<pcl::PointXYZINormal>::Ptr cloud(
      new pcl::PointCloud<pcl::PointXYZINormal>);
  for (const float normal : {0.25f, 0.75f, 0.5f, 1.0f}) {
    pcl::PointXYZINormal point;
    point.x = point.y = point.z = 0.5f;
    point.normal_x = normal;
    point.normal_y = 1.0f;
    point.curvature = normal;
    cloud->push_back(point);
  }
  const auto received = sentAndReceived<pcl::PointXYZINormal>(settings, cloud);
  ASSERT_EQ(received->size(), 1u);
  EXPECT_EQ((*received)[0].normal_x, 0.625f);
  EXPECT_EQ((*received)[0].normal_y, 0.0f);  // not kept
  EXPECT_EQ((*received)[0].curvature, 0.5f); // 2.5 steps, rounded to even
}

/** \brief Expects that points come back with their colours, by their labels. */
void
expectColoursOfPoints(unsigned int colour_bits, float spacing)
{
  IntensityCompressionSettings settings;
  settings.resolution = 1.0;
  settings.colour_bits = colour_bits;
  settings.keep_points = true;
  settings.fields = {{all_fields}};
  pcl::PointCloud<pcl::PointXYZRGBL>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGBL>);
  for (std::uint32_t i = 0; i < 300; ++i) {
    pcl::PointXYZRGBL point;
    point.x = point.y = point.z = 0.5f + spacing * static_cast<float>(i);
    point.rgba = 0xff000000u + 7919 * i;
    point.label = i; // the points of a voxel ascend with the first field
    cloud->push_back(point);
  }
  using Compressor = OctreePointCloudIntensityCompression<pcl::PointXYZRGBL>;
  std::stringstream stream;
  ASSERT_TRUE(Compressor(settings).encodePointCloud(cloud, stream).ok());
  Compressor::PointCloudPtr received;
  Compressor decoder;
  ASSERT_TRUE(decoder.decodePointCloud(stream, received).ok());
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
  IntensityCompressionSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  using Compressor = OctreePointCloudIntensityCompression<PointXYZIRT, NoIntensity>;
  Compressor compressor(settings);
  std::vector<std::uint8_t> bytes;
  ASSERT_TRUE(compressor.encodePointCloud(cloud, bytes).ok());
  EXPECT_TRUE(compressor.statistics().coding.has_points);
  Compressor::PointCloudPtr received;
  ASSERT_TRUE(compressor.decodePointCloud(bytes.data(), bytes.size(), received).ok());
  EXPECT_EQ(received->size(), cloud->size());
  EXPECT_EQ(received->height, 1u);
  EXPECT_TRUE(received->is_dense);
}

} // namespace

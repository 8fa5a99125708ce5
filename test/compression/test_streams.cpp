// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"
#include "support/text_parts.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

Cloud::Ptr
movingCloud(unsigned int frame)
{
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 600);
  for (pcl::PointXYZI& point : *cloud)
    point.x += 0.01f * static_cast<float>(frame);
  *cloud += *randomCloud<pcl::PointXYZI>(1000 + frame, 50);
  return cloud;
}

const BoundingBox wide_box{{-0.8, -0.8, -0.8}, {1.2, 0.8, 0.8}};

TEST(CompressionRate, IsKeptByTheStampsOfTheClouds)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.max_rate = 2e5;
  Compression encoder(settings);
  std::vector<std::uint8_t> bytes;
  unsigned int seed = 0;
  const auto encode = [&](std::uint64_t stamp) {
    const Cloud::Ptr cloud = randomCloud<pcl::PointXYZI>(++seed, 2000);
    cloud->header.stamp = stamp;
    const CompressionStatus status = encoder.encodePointCloud(cloud, bytes);
    EXPECT_EQ(status.ok(), !bytes.empty());
    return status.code();
  };
  for (std::uint64_t second = 1; second < 20; ++second)
    EXPECT_EQ(encode(1000000 * second), CompressionCode::Ok);
  std::size_t left_out = 0;
  for (int cloud = 0; cloud < 20; ++cloud)
    left_out += encode(20000000) == CompressionCode::LeftOut ? 1 : 0;
  EXPECT_GT(left_out, 0u);
  EXPECT_EQ(encoder.rateControlStatus().clouds_left_out, left_out);
  EXPECT_EQ(encoder.settings().resolution, usual_resolution);
}

TEST(CompressionRate, StampsOfAnySizeAreTimes)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.max_rate = 2e5;
  Compression encoder(settings);
  for (const std::uint64_t stamp : {UINT64_MAX, std::uint64_t{1}, UINT64_MAX / 2}) {
    const Cloud::Ptr cloud = randomCloud<pcl::PointXYZI>(1, 10);
    cloud->header.stamp = stamp;
    encodeFrame(encoder, cloud);
  }
}

TEST(CompressionRate, AnotherOneStaysWithAnotherResolution)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.max_rate = 2e5;
  Compression encoder(settings);
  encoder.setMaxRate(1e6);
  encoder.setResolution(0.1);
  EXPECT_EQ(encoder.rateControlStatus().max_rate, 1e6);
  EXPECT_EQ(encoder.rateControlStatus().resolution, 0.1);
  Compression unlimited(settingsWith(0.1));
  unlimited.setMaxRate(1e3);
  EXPECT_FALSE(unlimited.rateControlStatus().is_on);
}

TEST(CompressionStreams, OneInstanceServesBothDirectionsAtOnce)
{
  // A node that sends its own stream and watches another's.
  Compression node(settingsWith(usual_resolution));
  Compression alone(settingsWith(usual_resolution));
  Compression other(settingsWith(0.1));
  std::stringstream from_node;
  std::stringstream from_alone;
  for (unsigned int frame = 0; frame < 8; ++frame) {
    const auto others_cloud = randomCloud<pcl::PointXYZI>(50 + frame, 200, {3, 4, 5});
    std::stringstream from_other;
    ASSERT_TRUE(other.encodePointCloud(others_cloud, from_other).ok());
    ASSERT_TRUE(node.encodePointCloud(movingCloud(frame), from_node).ok());
    ASSERT_TRUE(alone.encodePointCloud(movingCloud(frame), from_alone).ok());
    Cloud::Ptr decoded;
    ASSERT_TRUE(node.decodePointCloud(from_other, decoded).ok());
    expectVoxelCentres(*decoded, naiveVoxels(*others_cloud, 0.1), 0.1);
  }
  EXPECT_EQ(from_node.str(), from_alone.str());
}

TEST(CompressionStatistics, AreThoseOfVoxelizerAndCoder)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.bounding_box = wide_box;
  Compression encoder(settings);
  Compression decoder;
  EXPECT_EQ(encoder.statistics().bytesPerVoxel(), 0.0);
  EXPECT_EQ(encoder.statistics().compressionRatio(), 0.0);
  for (unsigned int frame = 0; frame < 2; ++frame) {
    const auto cloud = movingCloud(frame);
    cloud->at(3).z = 50.0f; // outside the box
    cloud->at(4).x = std::numeric_limits<float>::quiet_NaN();
    std::stringstream stream;
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
    const FrameStatistics encoded = encoder.statistics();
    EXPECT_EQ(encoded.coding.bytes, stream.str().size());
    EXPECT_EQ(encoded.coding.frame_number, frame + 1);
    EXPECT_EQ(encoded.coding.is_i_frame, frame == 0);
    EXPECT_EQ(encoded.coding.voxels, encoded.voxelization.voxels);
    EXPECT_EQ(encoded.voxelization.points, cloud->size());
    EXPECT_EQ(encoded.voxelization.points_used, cloud->size() - 2);
    EXPECT_EQ(encoded.voxelization.points_not_finite, 1u);
    EXPECT_EQ(encoded.voxelization.points_outside_box, 1u);
    EXPECT_DOUBLE_EQ(encoded.bytesPerVoxel(),
                     static_cast<double>(encoded.coding.bytes) /
                         static_cast<double>(encoded.coding.voxels));
    EXPECT_DOUBLE_EQ(encoded.compressionRatio(),
                     16.0 * static_cast<double>(cloud->size()) /
                         static_cast<double>(stream.str().size()));
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    const FrameStatistics seen = decoder.statistics();
    EXPECT_EQ(seen.coding.bytes, encoded.coding.bytes);
    EXPECT_EQ(seen.coding.frame_number, encoded.coding.frame_number);
    EXPECT_EQ(seen.coding.voxels, decoded->size());
    EXPECT_EQ(seen.voxelization.points, 0u);
  }
}

TEST(CompressionStatistics, ArePrintedThroughPclsConsoleIfTheyAreToBe)
{
  const auto verbosity_before = pcl::console::getVerbosityLevel();
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  for (const bool is_shown : {true, false})
    for (const auto verbosity : {pcl::console::L_INFO, pcl::console::L_WARN}) {
      pcl::console::setVerbosityLevel(verbosity);
      settings.show_statistics = is_shown;
      Compression compression(settings);
      std::stringstream stream;
      Cloud::Ptr decoded;
      ::testing::internal::CaptureStdout();
      EXPECT_TRUE(compression.encodePointCloud(movingCloud(0), stream).ok());
      const std::string encoding = ::testing::internal::GetCapturedStdout();
      const CodedFrameStatistics coding = compression.statistics().coding;
      ::testing::internal::CaptureStdout();
      EXPECT_TRUE(compression.decodePointCloud(stream, decoded).ok());
      const std::string decoding = ::testing::internal::GetCapturedStdout();
      if (!is_shown || verbosity == pcl::console::L_WARN) {
        EXPECT_EQ(encoding + decoding, "");
        continue;
      }
      for (const std::string& text : {encoding, decoding})
        for (const std::string& words : {std::string("Intra frame"),
                                         std::to_string(coding.voxels),
                                         std::to_string(coding.bytes) + " bytes"})
          EXPECT_TRUE(hasPart(text, words));
      EXPECT_TRUE(hasPart(encoding, "POINTCLOUD ENCODING"));
      EXPECT_TRUE(hasPart(encoding, "points: 650"));
      EXPECT_TRUE(hasPart(decoding, "POINTCLOUD DECODING"));
      EXPECT_FALSE(hasPart(decoding, "points:"));
    }
  pcl::console::setVerbosityLevel(verbosity_before);
}

TEST(CompressionStreams, IFramesComeByTheStampsOfClouds)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.i_frame_every = 0.25;
  Compression encoder(settings);
  std::string kinds;
  // Microseconds; 0 is no stamp.
  for (const std::uint64_t stamp :
       {100000, 300000, 349999, 350000, 0, 599999, 600001}) {
    const Cloud::Ptr cloud = movingCloud(0);
    cloud->header.stamp = stamp;
    encodeFrame(encoder, cloud);
    kinds += encoder.statistics().coding.is_i_frame ? 'I' : 'P';
  }
  EXPECT_EQ(kinds, "IPPIPPI");
}

TEST(CompressionStreams, TheTemporalFilterSeesFromThePlaceOfTheCloud)
{
  // A plate before a wall, which goes: only from there one sees that its place is free.
  const Eigen::Vector3f sensor(4.0f, -2.0f, 1.0f);
  const auto cloudOf = [&](bool has_plate) {
    const Cloud::Ptr cloud(new Cloud);
    for (int column = -60; column <= 60; ++column)
      for (int row = -60; row <= 60; ++row) {
        const bool is_plate =
            has_plate && std::max(std::abs(column), std::abs(row)) < 30;
        const float depth = is_plate ? 1.5f : 3.0f;
        pcl::PointXYZI point;
        point.getVector3fMap() =
            sensor + depth * Eigen::Vector3f(0.006f * static_cast<float>(column),
                                             0.006f * static_cast<float>(row),
                                             1.0f);
        cloud->push_back(point);
      }
    cloud->sensor_origin_.head<3>() = sensor;
    return cloud;
  };
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.temporal_filter = 64;
  settings.retain_octree = true;
  OctreePointCloudIntensityCompression<pcl::PointXYZI, pcl_ext::CountIntensity> encoder(
      settings);
  for (int frame = 0; frame < 6; ++frame)
    encodeFrame(encoder, cloudOf(true));
  encodeFrame(encoder, cloudOf(false));
  EXPECT_GT(encoder.statistics().voxels_held, 0u);
  EXPECT_EQ(encoder.getLeafCount(), encoder.statistics().coding.voxels);
  encodeFrame(encoder, cloudOf(false));
  EXPECT_EQ(encoder.statistics().voxels_held, 0u);
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "support/cloud_streams.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <sstream>
#include <string>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;
using pcl_ext::CountIntensity;

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
TEST(CompressionStreams, IFramesComeByTheStampsOfClouds)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.bounding_box = wide_box;
  settings.i_frame_every = 0.25;
  Compression encoder(settings);
  Compression decoder;
  std::string kinds;
  std::stringstream stream;
  // Microseconds; 0 is no stamp.
  for (const std::uint64_t stamp :
       {100000, 300000, 349999, 350000, 0, 599999, 600001}) {
    const Cloud::Ptr cloud = movingCloud(0);
    cloud->header.stamp = stamp;
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    kinds += encoder.statistics().coding.is_i_frame ? 'I' : 'P';
  }
  EXPECT_EQ(kinds, "IPPIPPI");
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

/** \brief What a frame prints, at a verbosity of PCL's console. */
struct PrintedFrame {
  std::string encoding;
  std::string decoding;
  FrameStatistics encoded;
};

PrintedFrame
printFrame(bool show_statistics, pcl::console::VERBOSITY_LEVEL verbosity)
{
  const auto verbosity_before = pcl::console::getVerbosityLevel();
  pcl::console::setVerbosityLevel(verbosity);
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.show_statistics = show_statistics;
  Compression compression(settings);
  std::stringstream stream;
  Cloud::Ptr decoded;
  PrintedFrame printed;
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(compression.encodePointCloud(movingCloud(0), stream).ok());
  printed.encoding = ::testing::internal::GetCapturedStdout();
  printed.encoded = compression.statistics();
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  printed.decoding = ::testing::internal::GetCapturedStdout();
  pcl::console::setVerbosityLevel(verbosity_before);
  return printed;
}

TEST(CompressionStatistics, ArePrintedThroughPclsConsole)
{
  const PrintedFrame printed = printFrame(true, pcl::console::L_INFO);
  const std::string voxels = std::to_string(printed.encoded.coding.voxels);
  const std::string bytes = std::to_string(printed.encoded.coding.bytes);
  for (const std::string* text : {&printed.encoding, &printed.decoding}) {
    EXPECT_NE(text->find("Intra frame"), std::string::npos) << *text;
    EXPECT_NE(text->find(voxels), std::string::npos) << *text;
    EXPECT_NE(text->find(bytes + " bytes"), std::string::npos) << *text;
  }
  EXPECT_NE(printed.encoding.find("POINTCLOUD ENCODING"), std::string::npos);
  EXPECT_NE(printed.encoding.find("points: 650"), std::string::npos);
  EXPECT_NE(printed.decoding.find("POINTCLOUD DECODING"), std::string::npos);
  EXPECT_EQ(printed.decoding.find("points:"), std::string::npos);
}

TEST(CompressionStatistics, AreNotPrintedWhenDisabledOrBelowTheVerbosity)
{
  for (const PrintedFrame& printed : {printFrame(false, pcl::console::L_VERBOSE),
                                      printFrame(true, pcl::console::L_WARN)}) {
    EXPECT_EQ(printed.encoding, "");
    EXPECT_EQ(printed.decoding, "");
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/checked_link.h"
#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <vector>

namespace {

namespace rate_control {

using pcl_ext::io::CompressionCode;
using pcl_ext::io::CompressionStatus;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::test::CheckedLink;
using pcl_ext::test::expectCode;
using pcl_ext::test::randomCloud;
using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;
using Bytes = std::vector<std::uint8_t>;

constexpr double max_rate = 2e5;

IntensityCompressionSettings
limitedSettings()
{
  IntensityCompressionSettings settings =
      pcl_ext::test::settingsWith(pcl_ext::test::usual_resolution);
  settings.max_rate = max_rate;
  return settings;
}

Cloud::Ptr
cloudAt(unsigned int frame, std::size_t size = 2000)
{
  const Cloud::Ptr cloud = randomCloud<pcl::PointXYZI>(frame, size);
  cloud->header.stamp = 1000000000 + 100000 * std::uint64_t{frame};
  return cloud;
}

TEST(CompressionRate, TheRateIsKeptByTheStampsOfTheClouds)
{
  Compression encoder(limitedSettings());
  Compression decoder;
  CheckedLink link(max_rate, limitedSettings().rate_buffer);
  std::size_t left_out = 0;
  for (unsigned int i = 0; i < 100; ++i) {
    link.advance(std::chrono::milliseconds(100));
    Bytes bytes(3);
    const CompressionStatus status = encoder.encodePointCloud(cloudAt(i), bytes);
    EXPECT_EQ(status.ok(), !bytes.empty());
    if (!status.ok()) {
      expectCode(status, CompressionCode::LeftOut);
      ++left_out;
      continue;
    }
    link.add(bytes.size());
    Cloud::Ptr decoded(new Cloud);
    ASSERT_TRUE(decoder.decodePointCloud(bytes.data(), bytes.size(), decoded).ok());
  }
  const auto status = encoder.rateControlStatus();
  EXPECT_EQ(status.clouds_left_out, left_out);
  EXPECT_GT(status.step_number, 0u);
  EXPECT_EQ(encoder.settings().resolution, pcl_ext::test::usual_resolution);
  EXPECT_LT(left_out, 30u);
}
TEST(CompressionRate, StampsOfAnySizeAreTimes)
{
  Compression encoder(limitedSettings());
  for (const std::uint64_t stamp : {UINT64_MAX, std::uint64_t{1}, UINT64_MAX / 2}) {
    const Cloud::Ptr cloud = cloudAt(0, 10);
    cloud->header.stamp = stamp;
    Bytes bytes;
    EXPECT_TRUE(encoder.encodePointCloud(cloud, bytes).ok());
  }
}

TEST(CompressionRate, AnotherResolutionOrRateIsKept)
{
  Compression encoder(limitedSettings());
  encoder.setMaxRate(1e6);
  EXPECT_EQ(encoder.rateControlStatus().max_rate, 1e6);
  Bytes bytes;
  EXPECT_TRUE(encoder.encodePointCloud(cloudAt(0), bytes).ok());
  encoder.setResolution(0.1);
  EXPECT_EQ(encoder.rateControlStatus().max_rate, 1e6);
  EXPECT_EQ(encoder.rateControlStatus().resolution, 0.1);
  EXPECT_TRUE(encoder.encodePointCloud(cloudAt(10), bytes).ok());
  Compression decoder;
  Cloud::Ptr decoded(new Cloud);
  ASSERT_TRUE(decoder.decodePointCloud(bytes.data(), bytes.size(), decoded).ok());
  EXPECT_EQ(decoded->size(), pcl_ext::test::naiveVoxels(*cloudAt(10), 0.1).size());
  Compression unlimited(pcl_ext::test::settingsWith(0.1));
  unlimited.setMaxRate(1e3);
  EXPECT_FALSE(unlimited.rateControlStatus().is_on);
  EXPECT_TRUE(unlimited.encodePointCloud(cloudAt(0), bytes).ok());
}

} // namespace rate_control

} // namespace

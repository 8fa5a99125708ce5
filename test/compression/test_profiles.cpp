// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/compression/compression_profiles.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;

using PointCompression = OctreePointCloudIntensityCompression<pcl::PointXYZ>;

TEST(CompressionProfiles, ProfilesKeepWhatPclsProfilesKeep)
{
  for (int i = 0; i < pcl::io::COMPRESSION_PROFILE_COUNT; ++i) {
    const auto profile = static_cast<pcl::io::compression_Profiles_e>(i);
    const auto& pcls = pcl::io::compressionProfiles_[i];
    // The other arguments must not matter.
    const PointCompression compression(profile, false, 0.5, 0.123, true, 7, false, 2);
    SCOPED_TRACE("profile " + std::to_string(i));
    const IntensityCompressionSettings& settings = compression.settings();
    // Where points are kept to 0.1 mm there are eight voxels to a millimetre.
    const double edge = pcls.doVoxelGridDownSampling   ? pcls.octreeResolution
                        : pcls.pointResolution == 1e-4 ? 0.001 / 8.0
                                                       : pcls.pointResolution;
    EXPECT_DOUBLE_EQ(settings.resolution, edge);
    EXPECT_EQ(settings.keep_points, !pcls.doVoxelGridDownSampling);
    EXPECT_EQ(settings.colour_bits,
              pcls.doColorEncoding ? pcls.colorBitResolution : 0u);
    EXPECT_EQ(settings.i_frame_rate, pcls.iFrameRate);
    EXPECT_EQ(settings.effort,
              profile == pcl::io::HIGH_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR
                  ? Effort::Small
                  : Effort::Fast);
    EXPECT_DOUBLE_EQ(compression.getResolution(), edge);
    EXPECT_FALSE(settings.show_statistics);
    EXPECT_EQ(settings.format, StreamFormat::Version1);
    EXPECT_TRUE(settings.coarsen_wide_clouds);
    EXPECT_TRUE(settings.use_coordinate_step);
    EXPECT_TRUE(checkSettings(settings).ok());
  }
}

TEST(CompressionProfiles, ManualConfigurationTakesTheArgumentsAndHasPclsDefaults)
{
  const auto expect = [](const PointCompression& compression,
                         double resolution,
                         bool keeps_points,
                         unsigned int colour_bits,
                         unsigned int i_frame_rate,
                         bool shows_statistics) {
    EXPECT_EQ(compression.settings().resolution, resolution);
    EXPECT_EQ(compression.getResolution(), resolution);
    EXPECT_EQ(compression.settings().keep_points, keeps_points);
    EXPECT_EQ(compression.settings().colour_bits, colour_bits);
    EXPECT_EQ(compression.settings().i_frame_rate, i_frame_rate);
    EXPECT_EQ(compression.settings().effort, Effort::Fast);
    EXPECT_EQ(compression.settings().show_statistics, shows_statistics);
  };
  constexpr auto manual = pcl::io::MANUAL_CONFIGURATION;
  expect({manual, true, 0.5, 0.123, true, 7, false, 2}, 0.123, false, 0, 7, true);
  expect({manual, false, 0.002, 0.05, false, 7, true, 3}, 0.002, true, 3, 7, false);
  expect(manual, 0.001, true, 6, 30, false);
  const auto& pcls =
      pcl::io::compressionProfiles_[pcl::io::MED_RES_ONLINE_COMPRESSION_WITH_COLOR];
  EXPECT_EQ(PointCompression().settings().resolution, pcls.pointResolution);
  EXPECT_EQ(PointCompression().settings().i_frame_rate, pcls.iFrameRate);
  EXPECT_FALSE(PointCompression().settings().show_statistics);
}

TEST(CompressionProfiles, TheFinerOfTheTwoResolutionsCounts)
{
  const auto settings = [](double point_resolution, double octree_resolution) {
    return PointCompression(pcl::io::MANUAL_CONFIGURATION,
                            false,
                            point_resolution,
                            octree_resolution)
        .settings();
  };
  EXPECT_EQ(settings(0.001, 0.01).resolution, 0.001);
  EXPECT_EQ(settings(0.01, 0.001).resolution, 0.001);
  EXPECT_TRUE(settings(0.01, 0.001).keep_points);
  // One point for each voxel if they are the same for PCL, which compares a float.
  EXPECT_FALSE(settings(0.125, 0.125).keep_points);
  EXPECT_TRUE(settings(0.1, 0.1).keep_points);
}

TEST(CompressionProfiles, MillionsOfVoxelsAreDecodedByTheSameClass)
{
  // A floor, whose voxels take few bytes.
  constexpr int side = 2100;
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y)
      cloud->push_back({0.01f * static_cast<float>(x) + 0.005f,
                        0.01f * static_cast<float>(y) + 0.005f,
                        0.5f});
  PointCompression encoder(pcl::io::LOW_RES_ONLINE_COMPRESSION_WITHOUT_COLOR);
  PointCompression decoder(pcl::io::LOW_RES_ONLINE_COMPRESSION_WITHOUT_COLOR);
  std::stringstream stream;
  const CompressionStatus encoded = encoder.encodePointCloud(cloud, stream);
  EXPECT_TRUE(encoded.ok() && !encoded.hasWarning()) << encoded;
  EXPECT_LT(stream.str().size(), cloud->size() / 8);
  pcl::PointCloud<pcl::PointXYZ>::Ptr back(new pcl::PointCloud<pcl::PointXYZ>);
  const CompressionStatus decoded = decoder.decodePointCloud(stream, back);
  EXPECT_TRUE(decoded.ok()) << decoded;
  EXPECT_EQ(back->size(), cloud->size());
}

TEST(CompressionProfiles, FlatMapsTakeFewerBytesThanTheirCoordinatesHaveBits)
{
  // A floor at random, 1,700 points a square metre. PCL's class takes 8.8 bits a point.
  constexpr std::size_t points = 300000;
  constexpr float side = 13.3f;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(0.0f, side);
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (std::size_t i = 0; i < points; ++i)
    cloud->push_back({place(random), place(random), 0.001f});
  PointCompression encoder(pcl::io::MED_RES_ONLINE_COMPRESSION_WITHOUT_COLOR);
  EXPECT_EQ(roundTrip(encoder, cloud)->size(), points);
  EXPECT_LT(8.0 * static_cast<double>(encoder.statistics().coding.bytes), 7.2 * points);
}

TEST(CompressionProfiles, InvalidManualResolutionsAreReported)
{
  for (const double resolution : {0.0,
                                  -1.0,
                                  std::numeric_limits<double>::infinity(),
                                  std::numeric_limits<double>::quiet_NaN()}) {
    PointCompression compression(pcl::io::MANUAL_CONFIGURATION, false, resolution);
    std::stringstream stream;
    EXPECT_EQ(
        compression.encodePointCloud(randomCloud<pcl::PointXYZ>(1, 9), stream).code(),
        CompressionCode::InvalidSettings)
        << resolution;
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "support/cloud_streams.h"
#include "support/point_frames.h"
#include "support/voxel_frames.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext;

constexpr double decoded_resolution = 0.04;

/** \brief A wavy wall 2 to 3 m off, and single points before it, other ones each
 * time. */
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr
wallWithNoise(unsigned int frame)
{
  std::mt19937 random(frame + 1);
  const auto between = [&](float begin, float end) {
    return begin + (end - begin) * static_cast<float>(random() % 4096) / 4096.0f;
  };
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  const auto add = [&](float x, float y, float z) {
    PointT point;
    point.x = x;
    point.y = y;
    point.z = z;
    if constexpr (has_intensity_field<PointT>)
      point.intensity = 20.0f + between(0.0f, 9.0f);
    cloud->push_back(point);
  };
  for (int row = 0; row < 80; ++row)
    for (int column = 0; column < 80; ++column) {
      const float x = 0.015f * static_cast<float>(column) - 0.6f;
      add(x + between(-0.01f, 0.01f),
          0.015f * static_cast<float>(row) - 0.6f,
          2.5f + 0.3f * std::sin(4.0f * x));
    }
  for (int i = 0; i < 60; ++i)
    add(between(-0.6f, 0.6f), between(-0.6f, 0.6f), between(0.5f, 2.0f));
  return cloud;
}

io::IntensityCompressionSettings
settingsAt(double voxel_edge)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = voxel_edge;
  settings.i_frame_rate = 4;
  settings.carry_header = true;
  return settings;
}

template <typename PointT>
void
expectVoxel(const PointT& point, const io::VoxelFrame& frame, std::size_t voxel)
{
  EXPECT_EQ((std::array<float, 3>{point.x, point.y, point.z}),
            io::test::centreOf(frame, voxel));
  if constexpr (has_intensity_field<PointT>) {
    EXPECT_EQ(point.intensity, frame.intensity_scale.value(frame.intensities[voxel]));
  }
}

/** \brief Filters the clouds of a stream and, with another decoder, its frames. */
template <typename PointT, typename IntensityModelT>
void
expectSameAsFrames(const io::IntensityCompressionSettings& settings,
                   const VoxelOutlierRemovalSettings& removal_settings,
                   bool has_depth_model)
{
  using Compression = io::OctreePointCloudIntensityCompression<PointT, IntensityModelT>;
  Compression encoder(settings);
  Compression decoder(settings);
  VoxelOutlierRemoval removal(removal_settings);
  io::FrameDecoder frame_decoder;
  VoxelOutlierRemoval frame_removal(removal_settings);
  for (unsigned int i = 0; i < 8; ++i) {
    SCOPED_TRACE("frame " + std::to_string(i));
    const auto cloud = wallWithNoise<PointT>(i);
    cloud->header.stamp = 1000 + i;
    std::stringstream stream;
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
    const std::string bytes = stream.str();
    typename Compression::PointCloudPtr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    const OutlierRemovalStatus removed =
        removeOutliers(*decoded, decoder.voxelFrame(), removal);

    io::VoxelFrame expected;
    ASSERT_TRUE(frame_decoder
                    .decode(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                            bytes.size(),
                            expected)
                    .ok());
    EXPECT_EQ(expected.depth_model.has_value(), has_depth_model);
    const std::size_t expected_removed = frame_removal.filter(expected).removed;
    EXPECT_GT(expected_removed, 10u);
    EXPECT_GT(expected.size(), 200u);
    EXPECT_TRUE(removed.ok());
    EXPECT_EQ(removed.removed, expected_removed);
    ASSERT_EQ(decoded->size(), expected.size());
    EXPECT_EQ(decoded->width, expected.size());
    EXPECT_EQ(decoded->height, 1u);
    EXPECT_EQ(decoded->header.stamp, 1000 + i);
    for (std::size_t voxel = 0; voxel < expected.size(); ++voxel)
      expectVoxel((*decoded)[voxel], expected, voxel);
    EXPECT_EQ(removal.rememberedBlocks(), frame_removal.rememberedBlocks());
  }
}

TEST(DecodedCloudOutliers, AreThoseOfTheFrames)
{
  VoxelOutlierRemovalSettings settings{PointsUnit()};
  expectSameAsFrames<pcl::PointXYZ, CountIntensity>(
      settingsAt(decoded_resolution), settings, false);
  expectSameAsFrames<pcl::PointXYZI, CountIntensity>(settingsAt(0.05), settings, false);
  settings.unit = AutomaticUnit();
  settings.min_log_odds = 1.0f;
  using Quadratic = IntensityModel<KinectV2, QuadraticLaw>;
  expectSameAsFrames<pcl::PointXYZI, Quadratic>(
      settingsAt(decoded_resolution), settings, true);
  expectSameAsFrames<pcl::PointXYZ, Quadratic>(
      settingsAt(decoded_resolution), settings, true);
  settings.unit = PointsUnit{{false}};
  expectSameAsFrames<pcl::PointXYZI, NativeIntensity>(
      settingsAt(decoded_resolution), settings, false);
}

VoxelOutlierRemovalSettings
countSettings()
{
  return {PointsUnit()};
}

struct DecodedCloud {
  using Compression = io::OctreePointCloudIntensityCompression<pcl::PointXYZI>;

  explicit DecodedCloud(const pcl::PointCloud<pcl::PointXYZI>::Ptr& sent)
  {
    cloud = test::roundTrip(compression, compression, sent);
  }

  Compression compression{settingsAt(decoded_resolution)};
  Compression::PointCloudPtr cloud;
};

TEST(DecodedCloudOutliers, ACloudThatWasMovedLosesTheSamePoints)
{
  DecodedCloud decoded(wallWithNoise<pcl::PointXYZI>(0));
  pcl::PointCloud<pcl::PointXYZI> moved = *decoded.cloud;
  for (pcl::PointXYZI& point : moved) {
    point.x += 100.0f;
    point.intensity = -1.0f;
  }
  VoxelOutlierRemoval removal(countSettings());
  VoxelOutlierRemoval removal_of_moved(countSettings());
  const io::VoxelFrame& frame = decoded.compression.voxelFrame();
  const auto removed = removeOutliers(*decoded.cloud, frame, removal);
  EXPECT_EQ(removeOutliers(moved, frame, removal_of_moved).removed, removed.removed);
  ASSERT_EQ(moved.size(), decoded.cloud->size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_EQ(moved[i].x, (*decoded.cloud)[i].x + 100.0f);
    EXPECT_EQ(moved[i].y, (*decoded.cloud)[i].y);
    EXPECT_EQ(moved[i].z, (*decoded.cloud)[i].z);
    EXPECT_EQ(moved[i].intensity, -1.0f);
  }
}

TEST(DecodedCloudOutliers, PointsAreMissingInRowsAndColumnsAndElseErased)
{
  std::mt19937_64 random(5);
  for (const std::uint32_t height : {1u, 50u}) {
    SCOPED_TRACE(height);
    io::test::PointContent content;
    content.width = 5000 / height;
    content.height = height;
    content.has_fields = false;
    content.colour_bits = 0;
    const io::VoxelFrame frame = io::test::pointFrame(random, content);
    pcl::PointCloud<pcl::PointXYZI> cloud;
    io::detail::fillCloud(frame, cloud);
    const pcl::PointCloud<pcl::PointXYZI> before = cloud;
    VoxelOutlierRemoval scores(countSettings());
    std::vector<float> log_odds;
    ASSERT_TRUE(scores.score(frame, log_odds).ok());
    VoxelOutlierRemovalSettings settings = countSettings();
    std::vector<float> sorted = log_odds;
    std::sort(sorted.begin(), sorted.end());
    // Between two, as the filter compares before it takes the logarithm.
    const auto middle = std::upper_bound(
        sorted.begin(), sorted.end(), sorted[sorted.size() / 2] + 1e-3f);
    ASSERT_NE(middle, sorted.end());
    settings.min_log_odds = (*middle + *(middle - 1)) / 2.0f;
    VoxelOutlierRemoval removal(settings);
    const auto removed = removeOutliers(cloud, frame, removal);
    ASSERT_TRUE(removed.ok()) << removed.message();
    std::vector<bool> is_kept(before.size());
    std::size_t point = 0;
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
      for (std::uint32_t i = 0; i < frame.point_counts[voxel]; ++i)
        is_kept[frame.cloudIndex(point++)] = log_odds[voxel] >= settings.min_log_odds;
    std::size_t next = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (!is_kept[i] && height == 1)
        continue;
      ASSERT_LT(next, cloud.size());
      EXPECT_EQ(std::isfinite(cloud[next].x), is_kept[i]);
      EXPECT_TRUE(!is_kept[i] ||
                  cloud[next].getVector3fMap() == before[i].getVector3fMap());
      EXPECT_EQ(cloud[next++].intensity, before[i].intensity);
    }
    EXPECT_EQ(cloud.size(), next);
    EXPECT_EQ(cloud.height, height);
    EXPECT_EQ(cloud.is_dense, height == 1);
    const auto kept =
        static_cast<std::size_t>(std::count(is_kept.begin(), is_kept.end(), true));
    EXPECT_EQ(removed.removed, frame.pointCount() - kept);
    EXPECT_GT(removed.removed, 100u);
    EXPECT_GT(kept, 100u);
  }
}

TEST(DecodedCloudOutliers, PointsOutsideTheGridAreNotJudgedAndStay)
{
  const auto near = wallWithNoise<pcl::PointXYZ>(0);
  const auto cloud = wallWithNoise<pcl::PointXYZ>(0);
  pcl::PointXYZ far_point;
  far_point.x = 60'000.0f; // more than 2^20 voxels
  far_point.y = far_point.z = 0.0f;
  for (const std::ptrdiff_t place : {0, 77, 6000})
    cloud->insert(cloud->begin() + place, far_point);
  io::IntensityCompressionSettings settings = settingsAt(decoded_resolution);
  settings.keep_order = true;
  std::array<pcl::PointCloud<pcl::PointXYZ>, 2> kept;
  for (std::size_t i = 0; i < 2; ++i) {
    io::OctreePointCloudIntensityCompression<pcl::PointXYZ> encoder(settings);
    io::OctreePointCloudIntensityCompression<pcl::PointXYZ> decoder;
    std::vector<std::uint8_t> bytes;
    pcl::PointCloud<pcl::PointXYZ>::Ptr decoded;
    ASSERT_TRUE(encoder.encodePointCloud(i == 0 ? near : cloud, bytes).ok());
    ASSERT_TRUE(decoder.decodePointCloud(bytes.data(), bytes.size(), decoded).ok());
    VoxelOutlierRemoval removal(countSettings());
    const OutlierRemovalStatus removed =
        removeOutliers(*decoded, decoder.voxelFrame(), removal);
    ASSERT_TRUE(removed.ok()) << removed.message();
    EXPECT_GT(removed.removed, 20u);
    EXPECT_EQ(decoded->size() + removed.removed, (i == 0 ? near : cloud)->size());
    kept[i] = *decoded;
  }
  std::size_t i = 0;
  for (const pcl::PointXYZ& point : kept[1])
    if (point.x < 1000.0f) {
      EXPECT_NEAR(point.x, kept[0][i].x, decoded_resolution);
      EXPECT_NEAR(point.y, kept[0][i].y, decoded_resolution);
      EXPECT_NEAR(point.z, kept[0][i++].z, decoded_resolution);
    }
  EXPECT_EQ(i, kept[0].size());
  EXPECT_EQ(i + 3, kept[1].size());
}

TEST(DecodedCloudOutliers, ACloudOfAnotherFrameIsRefusedAndNotRemembered)
{
  DecodedCloud decoded(wallWithNoise<pcl::PointXYZI>(0));
  const io::VoxelFrame& frame = decoded.compression.voxelFrame();
  VoxelOutlierRemoval removal(countSettings());
  pcl::PointCloud<pcl::PointXYZI> shorter = *decoded.cloud;
  shorter.resize(shorter.size() - 1);
  const OutlierRemovalStatus status = removeOutliers(shorter, frame, removal);
  EXPECT_EQ(status.code(), OutlierRemovalCode::DifferentCloud);
  EXPECT_EQ(status.message(),
            "no point was judged: the cloud has " + std::to_string(frame.size() - 1) +
                " points, and its frame " + std::to_string(frame.size()));
  EXPECT_EQ(shorter.size(), frame.size() - 1);
  pcl::PointCloud<pcl::PointXYZI> none;
  EXPECT_EQ(removeOutliers(none, frame, removal).code(),
            OutlierRemovalCode::DifferentCloud);
  EXPECT_EQ(removal.rememberedBlocks(), 0u);
  // A cloud twice: the second time it is shorter than the frame.
  EXPECT_GT(removeOutliers(*decoded.cloud, frame, removal).removed, 0u);
  EXPECT_EQ(removeOutliers(*decoded.cloud, frame, removal).code(),
            OutlierRemovalCode::DifferentCloud);
}

TEST(DecodedCloudOutliers, NoPointsOrAllPointsMayBeRemoved)
{
  VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = -100.0f;
  VoxelOutlierRemoval lenient(settings);
  settings.min_log_odds = 100.0f;
  VoxelOutlierRemoval strict(settings);
  DecodedCloud decoded(wallWithNoise<pcl::PointXYZI>(0));
  const io::VoxelFrame& frame = decoded.compression.voxelFrame();
  EXPECT_EQ(removeOutliers(*decoded.cloud, frame, lenient).removed, 0u);
  EXPECT_EQ(decoded.cloud->size(), frame.size());
  EXPECT_EQ(removeOutliers(*decoded.cloud, frame, strict).removed, frame.size());
  EXPECT_TRUE(decoded.cloud->empty());
  EXPECT_EQ(decoded.cloud->width, 0u);

  pcl::PointCloud<pcl::PointXYZI>::Ptr nothing(new pcl::PointCloud<pcl::PointXYZI>);
  DecodedCloud empty(nothing);
  EXPECT_EQ(
      removeOutliers(*empty.cloud, empty.compression.voxelFrame(), lenient).removed,
      0u);
}

} // namespace

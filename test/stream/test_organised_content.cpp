// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/organised_clouds.h"
#include "support/unordered_clouds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

TEST(OrganisedClouds, AreScansWhereVoxelsWouldLeavePointsOut)
{
  // Most points are outside the lattice around that origin: voxels of the others would
  // take fewer bytes.
  EncoderSettings settings = fineSettings();
  settings.origin = {0x1p20 * settings.resolution + 0.85, 0.0, 0.0};
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (std::uint64_t i = 0; i < 8; ++i) {
    const OrganisedCloud cloud = cameraCloud(WorldPose::Identity(), i);
    const auto present = static_cast<std::size_t>(
        std::count_if(cloud.coordinates.begin(),
                      cloud.coordinates.end(),
                      [](float value) { return std::isfinite(value); }) /
        3);
    Bytes bytes;
    EXPECT_FALSE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).hasWarning());
    EXPECT_TRUE(encoder.statistics().coding.has_points) << i;
    EXPECT_EQ(encoder.statistics().voxelization.points_outside_grid, 0u);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    EXPECT_EQ(back.pointCount(), present);
  }
  settings.coarsen_wide_clouds =
      true; // whose voxels would be larger than the settings'
  settings.origin.reset();
  settings.resolution = 1e-6;
  CloudEncoder fine(settings, IntensityUnit::None);
  OrganisedCloud wide = cameraCloud(WorldPose::Identity(), 1);
  for (float& coordinate : wide.coordinates)
    coordinate *= 2.0000007f;
  Bytes bytes;
  EXPECT_FALSE(fine.encode(viewOf(wide), {wide.pose}, bytes).hasWarning());
  EXPECT_TRUE(fine.statistics().coding.has_points);
  EXPECT_EQ(fine.statistics().voxelization.resolution, 1e-6);
}

TEST(OrganisedClouds, GoOnBehindCloudsWithoutPoints)
{
  const WorldPose pose = slantedPose();
  OrganisedCloud nothing = cameraCloud(pose, 1);
  for (float& coordinate : nothing.coordinates)
    coordinate = std::numeric_limits<float>::quiet_NaN();
  CloudEncoder encoder(fineSettings(), IntensityUnit::None);
  FrameDecoder decoder;
  const auto encode = [&](const PointView& view) {
    Bytes bytes;
    EXPECT_TRUE(encoder.encode(view, {pose}, bytes).ok());
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    EXPECT_EQ(back.cloudSize(), view.count);
    return encoder.statistics().coding;
  };
  const std::vector<OrganisedCloud> clouds = {cameraCloud(pose, 1),
                                              cameraCloud(pose, 2)};
  EXPECT_TRUE(encode(viewOf(clouds[0])).has_points);
  const CodedFrameStatistics of_empty = encode(viewOf(nothing));
  EXPECT_FALSE(of_empty.is_i_frame);
  EXPECT_TRUE(of_empty.has_points);
  EXPECT_FALSE(encode(PointView()).has_points);
  EXPECT_TRUE(encode(viewOf(nothing)).is_i_frame);
  EXPECT_TRUE(encode(viewOf(clouds[1])).has_points);
}

TEST(OrganisedClouds, ThatRaysNoLongerFitTakeAnIFrame)
{
  // A lidar that tilts, whose pose nobody tells.
  EncoderSettings settings = fineSettings();
  settings.i_frame_rate = 100;
  settings.bounding_box = BoundingBox{{-8.0, -8.0, -8.0}, {8.0, 8.0, 8.0}};
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  std::vector<bool> are_i_frames;
  for (int i = 0; i < 4; ++i) {
    WorldPose pose = WorldPose::Identity();
    pose.rotate(Eigen::AngleAxisd(i < 2 ? 0.0 : 0.1, Eigen::Vector3d::UnitX()));
    OrganisedCloud cloud = lidarCloud(pose, 1);
    cloud.pose = WorldPose::Identity();
    expectCloud(encoder, decoder, cloud);
    are_i_frames.push_back(encoder.statistics().coding.is_i_frame);
  }
  EXPECT_EQ(are_i_frames, (std::vector<bool>{true, false, true, false}));
}

TEST(OrganisedClouds, OfIFramesHaveTheRaysOfBeforeWhileTheyFit)
{
  EncoderSettings settings = fineSettings();
  settings.i_frame_rate = 1;
  settings.bounding_box = BoundingBox{{-4.0, -4.0, -4.0}, {8.0, 8.0, 8.0}};
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  const auto rays_of = [&](const OrganisedCloud& cloud) {
    Bytes bytes;
    EXPECT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
    return takeApart(bytes).header.scan.rays;
  };
  const OrganisedCloud whole = cameraCloud(slantedPose(), 1);
  OrganisedCloud sparse = whole;
  for (std::size_t i = 0; i < sparse.coordinates.size(); ++i)
    if (i / 3 % 5 != 0)
      sparse.coordinates[i] = std::numeric_limits<float>::quiet_NaN();
  const scan::ScanRays of_few_points = rays_of(sparse);
  // Many more points tell better where the rays are.
  const scan::ScanRays rays = rays_of(whole);
  EXPECT_FALSE(rays.pose == of_few_points.pose);
  EXPECT_TRUE(rays_of(cameraCloud(slantedPose(), 2)).pose == rays.pose);
  EXPECT_TRUE(rays_of(sparse).pose == rays.pose);
  // Rays of another camera.
  WorldPose pose = slantedPose();
  pose.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  OrganisedCloud turned = cameraCloud(pose, 1);
  turned.pose = slantedPose();
  EXPECT_FALSE(rays_of(turned).pose == rays.pose);
}

/** \brief Whether a cloud is coded as a scan or as voxels, of which the effort decides
 * how many bytes they take. */
class ContentOfOrganisedClouds : public testing::TestWithParam<Effort> {};

TEST_P(ContentOfOrganisedClouds, OfPointsThatMoveAboutIsVoxels)
{
  // An order, but no rays: positions are random.
  std::mt19937_64 random(15);
  OrganisedCloud cloud{40, 30, {}};
  for (int i = 0; i < 3 * 40 * 30; ++i)
    cloud.coordinates.push_back(uniform(random, -1.0, 1.0));
  CloudEncoder encoder(fineSettings(GetParam()), IntensityUnit::None);
  UnorderedClouds other(fineSettings(GetParam()));
  Bytes bytes;
  ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
  EXPECT_FALSE(encoder.statistics().coding.has_points);
  EXPECT_LE(bytes.size(), other.encode(viewOf(cloud), cloud.pose));
}

TEST_P(ContentOfOrganisedClouds, OfManyPointsInAVoxelIsVoxels)
{
  EncoderSettings settings = fineSettings(GetParam());
  settings.resolution = 0.2;
  settings.i_frame_rate = 4;
  CloudEncoder encoder(settings, IntensityUnit::None);
  UnorderedClouds other(settings);
  FrameDecoder decoder;
  for (std::uint64_t i = 0; i < 9; ++i) {
    const OrganisedCloud cloud = cameraCloud(slantedPose(), i);
    Bytes bytes;
    ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
    EXPECT_FALSE(encoder.statistics().coding.has_points);
    EXPECT_EQ(encoder.statistics().coding.is_i_frame, i % 4 == 0);
    EXPECT_EQ(bytes.size(), other.encode(viewOf(cloud), cloud.pose));
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    expectSameFrame(back, encoder.frame());
  }
}

TEST_P(ContentOfOrganisedClouds, OfStillScenesTakesNextToNothing)
{
  // The same cloud again and again, as scans and, if these take fewer bytes, as voxels.
  EncoderSettings settings = fineSettings(GetParam());
  settings.i_frame_rate = 100;
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  const OrganisedCloud cloud = cameraCloud(slantedPose(), 1);
  std::size_t i_frames = 0;
  std::size_t first_bytes = 0;
  for (int i = 0; i < 16; ++i) {
    Bytes bytes;
    ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    expectSameFrame(back, encoder.frame());
    i_frames += encoder.statistics().coding.is_i_frame ? 1 : 0;
    first_bytes = i == 0 ? bytes.size() : first_bytes;
    // What is left of a scan are its tables.
    EXPECT_TRUE(encoder.statistics().coding.is_i_frame ||
                3 * bytes.size() < first_bytes)
        << i << ": " << bytes.size() << " of " << first_bytes;
  }
  EXPECT_LE(i_frames, 3u);
}

TEST_P(ContentOfOrganisedClouds, CountsTheBytesOfIFramesToo)
{
  // Voxels take fewer bytes than a scan in each P-frame, and more in each I-frame.
  const OrganisedCloud cloud = cameraCloud(slantedPose(), 1);
  std::array<std::size_t, 2> bytes_of_streams{};
  for (const bool keeps_order : {false, true}) {
    EncoderSettings settings = fineSettings(GetParam());
    settings.i_frame_rate = 12;
    settings.keep_order = keeps_order;
    CloudEncoder encoder(settings, IntensityUnit::None);
    for (int i = 0; i < 36; ++i) {
      Bytes bytes;
      ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
      bytes_of_streams[keeps_order ? 1 : 0] += bytes.size();
    }
  }
  EXPECT_LE(100 * bytes_of_streams[0], 105 * bytes_of_streams[1]);
}

INSTANTIATE_TEST_SUITE_P(,
                         ContentOfOrganisedClouds,
                         testing::ValuesIn(all_efforts),
                         [](const auto& effort) { return nameOf(effort.param); });

} // namespace

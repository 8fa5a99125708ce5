// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>

#include "support/organised_clouds.h"
#include "support/unordered_clouds.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

TEST(OrganisedClouds, AnywhereTakeHardlyMoreBytesThanWithTheirPose)
{
  for (const auto& cloudOf : {cameraCloud, lidarCloud})
    for (const double speed : {0.0, 0.05}) { // metres a frame
      std::size_t bytes[2] = {};
      for (const bool is_told : {false, true}) {
        CloudEncoder encoder(fineSettings(), IntensityUnit::None);
        FrameDecoder decoder;
        WorldPose pose = slantedPose();
        for (std::uint64_t seed = 0; seed < 4; ++seed) {
          pose.translate(Eigen::Vector3d(speed, 0.0, -0.5 * speed));
          pose.rotate(Eigen::AngleAxisd(0.2 * speed, Eigen::Vector3d(0.6, 0.0, 0.8)));
          OrganisedCloud cloud = cloudOf(pose, seed);
          if (!is_told)
            cloud.pose = WorldPose::Identity();
          bytes[is_told ? 1 : 0] += expectCloud(encoder, decoder, cloud);
          EXPECT_EQ(encoder.statistics().coding.is_i_frame, seed % 3 == 0);
        }
      }
      EXPECT_LT(static_cast<double>(bytes[0]), 1.1 * static_cast<double>(bytes[1]));
    }
}

TEST(OrganisedClouds, OfCamerasThatLookAlongNoAxisTakeHardlyMoreBytes)
{
  EncoderSettings settings = fineSettings();
  settings.resolution = 0.005; // depths are finer
  settings.keep_order = true;
  const auto bytes_of = [&settings](const WorldPose& pose) {
    CloudEncoder encoder(settings, IntensityUnit::None);
    FrameDecoder decoder;
    std::size_t bytes = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed)
      bytes += expectCloud(encoder, decoder, cameraCloud(pose, seed));
    return static_cast<double>(bytes);
  };
  EXPECT_LT(bytes_of(slantedPose()), 1.1 * bytes_of(WorldPose::Identity()));
}

TEST(OrganisedClouds, TakeFewerBytesInOrder)
{
  for (const auto& cloudOf : {cameraCloud, lidarCloud})
    for (const WorldPose& pose : {WorldPose(WorldPose::Identity()), slantedPose()}) {
      CloudEncoder encoder(fineSettings(), IntensityUnit::None);
      UnorderedClouds other(fineSettings(Effort::Small));
      FrameDecoder decoder;
      for (std::uint64_t i = 0; i < 5; ++i) {
        const OrganisedCloud cloud = cloudOf(pose, i);
        const std::size_t bytes = expectCloud(encoder, decoder, cloud);
        EXPECT_LT(3 * bytes, 2 * other.encode(viewOf(cloud), cloud.pose));
      }
    }
}

TEST(OrganisedClouds, OfCamerasAreAmidTheirVoxels)
{
  // How far the centres of their voxels are from points, on average, as a part of an edge.
  const auto centre_off = [](const EncoderSettings& settings, double depth_unit) {
    OrganisedCloud cloud{80, 60, {}};
    std::mt19937_64 random(5);
    for (std::uint32_t row = 0; row < cloud.height; ++row)
      for (std::uint32_t column = 0; column < cloud.width; ++column) {
        const auto units = static_cast<double>(below(random, 1000000)) + 1e6;
        const double depth = depth_unit * std::floor(units * 1e-6 / depth_unit);
        cloud.coordinates.push_back(static_cast<float>((column - 39.5) / 61.0 * depth));
        cloud.coordinates.push_back(static_cast<float>((row - 28.0) / 60.5 * depth));
        cloud.coordinates.push_back(static_cast<float>(depth));
      }
    CloudEncoder encoder(settings, IntensityUnit::None);
    FrameDecoder decoder;
    expectCloud(encoder, decoder, cloud);
    EXPECT_TRUE(encoder.statistics().coding.has_points);
    const VoxelFrame& frame = encoder.frame();
    EXPECT_EQ(frame.point_counts.size(), frame.size());
    double off = 0.0;
    std::size_t point = 0;
    for (std::size_t voxel = 0; voxel < frame.point_counts.size(); ++voxel)
      for (std::uint32_t i = 0; i < frame.point_counts[voxel]; ++i, ++point)
        off += (frame.grid.centre(2, voxelPosition(frame.keys[voxel]).z) -
                cloud.coordinates[3 * frame.cloudIndex(point) + 2]) /
               frame.grid.resolution;
    return off / static_cast<double>(frame.pointCount());
  };
  EncoderSettings settings = fineSettings();
  EXPECT_NEAR(centre_off(settings, 1e-6), 0.0, 0.02);
  // Depths in whole edges are kept, on the faces where they are.
  EXPECT_NEAR(centre_off(settings, 1e-3), 0.5, 0.02);
  settings.resolution = 0.01;
  EXPECT_NEAR(centre_off(settings, 1e-3), 0.0, 0.02);
}

TEST(OrganisedClouds, OfLidarsAreWithinHalfAnEdgeAlsoFarAway)
{
  // Ranges of 500 to 700 m, by any fraction of an edge of 0.1 mm.
  std::mt19937_64 random(5);
  OrganisedCloud cloud{1024, 32, {}};
  for (std::uint32_t row = 0; row < cloud.height; ++row)
    for (std::uint32_t column = 0; column < cloud.width; ++column) {
      const double angle = 2.0 * M_PI * column / cloud.width;
      const double elevation = 0.017 * row - 0.26;
      const double range =
          600.0 + 99.0 * std::sin(3.0 * angle) + 0.01 * uniform(random, -1.0, 1.0);
      for (const double along : {std::cos(elevation) * std::cos(angle),
                                 std::cos(elevation) * std::sin(angle),
                                 std::sin(elevation)})
        cloud.coordinates.push_back(static_cast<float>(range * along));
    }
  EncoderSettings settings = fineSettings();
  settings.resolution = 0.0001;
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false); // which reach less far
  Bytes bytes;
  ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
  VoxelFrame back;
  ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
  EXPECT_TRUE(back.points.sensor) << "no rays were found";
  ASSERT_EQ(back.pointCount(), back.cloudSize());
  for (std::size_t point = 0; point < back.pointCount(); ++point)
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(back.points.positions[point][axis],
                  cloud.coordinates[3 * back.cloudIndex(point) + axis],
                  0.500001 * settings.resolution);
}

TEST(OrganisedClouds, AfterFarHigherIntensitiesKeepTheirOwn)
{
  const OrganisedCloud cloud = lidarCloud(slantedPose(), 3);
  EncoderSettings settings = fineSettings();
  settings.i_frame_rate = 100;
  CloudEncoder encoder(settings, IntensityUnit::Native);
  FrameDecoder decoder;
  for (const float highest : {1e8f, 1.0f, 0.5f}) {
    std::vector<float> intensities(cloud.coordinates.size() / 3);
    for (std::size_t i = 0; i < intensities.size(); ++i)
      intensities[i] = highest * static_cast<float>(i % 999) / 998.0f;
    PointView view = viewOf(cloud);
    view.intensities = intensities.data();
    view.intensity_stride = sizeof(float);
    Bytes bytes;
    ASSERT_TRUE(encoder.encode(view, {cloud.pose}, bytes).ok());
    EXPECT_EQ(describeFrame(bytes.data(), bytes.size()).is_i_frame, highest >= 1.0f);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    ASSERT_TRUE(back.points.areThere());
    EXPECT_LT(back.intensity_scale.step, 4e-5f * highest);
    for (std::size_t point = 0; point < back.pointCount(); ++point)
      EXPECT_NEAR(back.intensity_scale.value(back.points.intensities[point]),
                  intensities[back.cloudIndex(point)],
                  0.501f * back.intensity_scale.step);
  }
}

TEST(OrganisedClouds, MissingPointsMayBeAtTheSensor)
{
  // Some drivers write (0, 0, 0) for them.
  for (const bool is_camera : {true, false}) {
    CloudEncoder encoder(fineSettings(), IntensityUnit::None);
    CloudEncoder other(fineSettings(), IntensityUnit::None);
    FrameDecoder decoder;
    FrameDecoder other_decoder;
    for (std::uint64_t i = 0; i < 3; ++i) {
      SCOPED_TRACE(i);
      const WorldPose pose = is_camera ? WorldPose::Identity() : slantedPose();
      OrganisedCloud cloud = is_camera ? cameraCloud(pose, i) : lidarCloud(pose, i);
      const std::size_t without = expectCloud(other, other_decoder, cloud);
      for (std::size_t point = 0; point < cloud.coordinates.size() / 3; ++point)
        for (std::size_t axis = 0; axis < 3; ++axis)
          if (float& coordinate = cloud.coordinates[3 * point + axis];
              std::isnan(coordinate))
            coordinate = static_cast<float>(pose.translation()[static_cast<int>(axis)]);
      const std::size_t bytes = expectCloud(encoder, decoder, cloud);
      EXPECT_LT(bytes, without + without / 10 + 100);
      EXPECT_EQ(encoder.statistics().coding.is_i_frame, i == 0);
    }
  }
}

TEST(OrganisedClouds, OfHostileCloudsKeepTheBound)
{
  // All points at one place, at the sensor, on one line, far away, or of one row.
  std::mt19937_64 random(16);
  for (int kind = 0; kind < 6; ++kind) {
    SCOPED_TRACE(kind);
    OrganisedCloud cloud{32, 16, {}};
    for (std::uint32_t i = 0; i < cloud.width * cloud.height; ++i) {
      const float noise = uniform(random, -0.5, 0.5);
      const std::array<float, 3> point =
          kind == 0   ? std::array<float, 3>{0.3f, 0.3f, 0.3f}
          : kind == 1 ? std::array<float, 3>{0.0f, 0.0f, 0.0f}
          : kind == 2 ? std::array<float, 3>{noise, 2 * noise, 0.0f}
          : kind == 3 ? std::array<float, 3>{1000.0f + noise, -1000.0f, noise}
          : kind == 4 ? std::array<float, 3>{0.0f, 0.0f, 1.0f + noise}
                      : std::array<float, 3>{i < 32 ? noise : NAN, 1.0f, 1e-9f};
      cloud.coordinates.insert(cloud.coordinates.end(), point.begin(), point.end());
    }
    CloudEncoder encoder(fineSettings(), IntensityUnit::None);
    FrameDecoder decoder;
    for (int i = 0; i < 2; ++i) {
      Bytes bytes;
      ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
      const VoxelFrame& frame = encoder.frame();
      ASSERT_TRUE(isConsistent(frame));
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
      EXPECT_EQ(back.keys, frame.keys);
      EXPECT_EQ(back.point_counts, frame.point_counts);
    }
  }
}

TEST(OrganisedClouds, PixelsOfPointsMayBeGiven)
{
  // Without the pixels that have no point, and in another order.
  const OrganisedCloud cloud = cameraCloud(WorldPose::Identity(), 3);
  std::vector<std::uint32_t> pixels;
  for (std::uint32_t pixel = 0; pixel < 80 * 60; ++pixel)
    if (std::isfinite(cloud.coordinates[3 * pixel]))
      pixels.push_back(pixel);
  std::mt19937_64 random(17);
  std::shuffle(pixels.begin(), pixels.end(), random);
  std::vector<float> coordinates;
  for (const std::uint32_t pixel : pixels)
    coordinates.insert(coordinates.end(),
                       cloud.coordinates.begin() + 3 * pixel,
                       cloud.coordinates.begin() + 3 * pixel + 3);
  PointView view = viewOf(cloud);
  view.count = pixels.size();
  view.coordinates = coordinates.data();
  view.pixels = pixels.data();
  const auto encode = [](const PointView& points) {
    CloudEncoder encoder(fineSettings(), IntensityUnit::None);
    Bytes bytes;
    EXPECT_TRUE(encoder.encode(points, {}, bytes).ok());
    EXPECT_TRUE(encoder.statistics().coding.has_points);
    VoxelFrame back;
    FrameDecoder decoder;
    decoder.setDecodesVoxels(false);
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    return back;
  };
  const VoxelFrame expected = encode(viewOf(cloud));
  const VoxelFrame back = encode(view);
  EXPECT_EQ(back.points.indices, expected.points.indices);
  for (std::size_t i = 0; i < back.pointCount(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(
          back.points.positions[i][axis], expected.points.positions[i][axis], 0.00101);

  // Pixels that are shared or outside the image are no order.
  for (const std::uint32_t wrong : {pixels[1], 80u * 60u, 0xffffffffu}) {
    std::vector<std::uint32_t> others = pixels;
    others[0] = wrong;
    view.pixels = others.data();
    CloudEncoder encoder(fineSettings(), IntensityUnit::None);
    Bytes bytes;
    ASSERT_TRUE(encoder.encode(view, {}, bytes).ok());
    EXPECT_FALSE(encoder.statistics().coding.has_points);
  }
  view.pixels = nullptr;
  CloudEncoder encoder(fineSettings(), IntensityUnit::None);
  VoxelFrame frame;
  EXPECT_EQ(encoder.voxelize(view, WorldPose::Identity(), frame).code(),
            CompressionCode::InvalidInput);
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/frame_description.h>

#include "support/organised_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

OrganisedCloud
withoutMissing(const OrganisedCloud& cloud)
{
  OrganisedCloud list{0, 0, {}, cloud.pose};
  for (std::size_t i = 0; i < cloud.coordinates.size(); i += 3)
    if (std::isfinite(cloud.coordinates[i]))
      list.coordinates.insert(
          list.coordinates.end(),
          cloud.coordinates.begin() + static_cast<std::ptrdiff_t>(i),
          cloud.coordinates.begin() + static_cast<std::ptrdiff_t>(i + 3));
  return list;
}

OrganisedCloud
shuffled(OrganisedCloud cloud)
{
  std::mt19937_64 random(3);
  for (std::size_t i = cloud.coordinates.size() / 3 - 1; i > 0; --i) {
    const std::size_t other = below(random, i + 1);
    for (std::size_t axis = 0; axis < 3; ++axis)
      std::swap(cloud.coordinates[3 * i + axis], cloud.coordinates[3 * other + axis]);
  }
  return cloud;
}

class CameraStream {
public:
  explicit CameraStream(const EncoderSettings& settings)
  : edge_(settings.resolution), encoder_(settings, IntensityUnit::None)
  {
    decoder_.setDecodesVoxels(false);
  }

  /** \brief Encodes a cloud: its points come back in their order, within half an edge. */
  std::size_t
  encode(const OrganisedCloud& cloud)
  {
    Bytes bytes;
    const CompressionStatus status =
        encoder_.encode(viewOf(cloud), {cloud.pose}, bytes);
    EXPECT_TRUE(status.ok() && !status.hasWarning()) << status;
    description = describeFrame(bytes.data(), bytes.size());
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder_, bytes, back), CompressionCode::Ok);
    EXPECT_EQ(3 * back.points.positions.size(), cloud.coordinates.size());
    if (testing::Test::HasFailure())
      return 0;
    double farthest = 0.0;
    for (std::size_t i = 0; i < cloud.coordinates.size(); ++i)
      farthest = std::max(
          farthest,
          std::abs(back.points.positions[i / 3][i % 3] - double{cloud.coordinates[i]}));
    EXPECT_LE(farthest, 0.500001 * edge_);
    return bytes.size();
  }

  FrameDescription description; ///< of the last cloud

private:
  double edge_;
  CloudEncoder encoder_;
  FrameDecoder decoder_;
};

EncoderSettings
settingsOf(bool keeps_order)
{
  EncoderSettings settings = fineSettings();
  settings.keep_order = keeps_order;
  return settings;
}

TEST(CameraClouds, TakeHardlyMoreBytesThanTheirImages)
{
  for (const WorldPose& pose : {WorldPose(WorldPose::Identity()), slantedPose()})
    for (const bool keeps_order : {false, true}) {
      CameraStream stream(settingsOf(keeps_order));
      CloudEncoder images(settingsOf(keeps_order), IntensityUnit::None);
      std::size_t bytes = 0;
      std::size_t image_bytes = 0;
      for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const OrganisedCloud cloud = cameraCloud(pose, seed);
        bytes += stream.encode(withoutMissing(cloud));
        Bytes image;
        EXPECT_TRUE(images.encode(viewOf(cloud), {pose}, image).ok());
        image_bytes += image.size();
        // As many P-frames, in which the image stays as it is.
        EXPECT_EQ(stream.description.is_i_frame, seed % 3 == 0);
      }
      EXPECT_LT(static_cast<double>(bytes), 1.05 * static_cast<double>(image_bytes));
    }
}

TEST(CameraClouds, MayLookAlongAnyAxisAndBeMirrored)
{
  // Coordinates as drivers have them: right, down, ahead; ahead, left, up; and others.
  for (const std::array<int, 3>& axes : {std::array{0, 1, 2}, {2, 0, 1}, {1, 2, 0}})
    for (const float sign : {1.0f, -1.0f}) {
      const OrganisedCloud seen = withoutMissing(cameraCloud(WorldPose::Identity(), 1));
      OrganisedCloud cloud = seen;
      for (std::size_t i = 0; i < cloud.coordinates.size(); ++i)
        cloud.coordinates[i] =
            sign * seen.coordinates[i / 3 * 3 + static_cast<std::size_t>(axes[i % 3])];
      CameraStream stream(settingsOf(true));
      stream.encode(cloud);
      EXPECT_GE(stream.description.scan.width, 80u);
      EXPECT_GE(stream.description.scan.height, 60u);
    }
}

TEST(CameraClouds, MayHaveWholeMillimetres)
{
  OrganisedCloud cloud = withoutMissing(cameraCloud(WorldPose::Identity(), 1));
  for (float& coordinate : cloud.coordinates)
    coordinate = std::round(coordinate * 1000.0f) / 1000.0f;
  CameraStream stream(settingsOf(true));
  stream.encode(cloud);
  EXPECT_GE(stream.description.scan.height, 60u);
}

TEST(CameraClouds, MayHaveMissingPointsAtTheSensor)
{
  for (const WorldPose& pose : {WorldPose(WorldPose::Identity()), slantedPose()}) {
    OrganisedCloud cloud = cameraCloud(pose, 1);
    cloud.width = cloud.height = 0;
    for (std::size_t i = 0; i < cloud.coordinates.size(); ++i)
      if (std::isnan(cloud.coordinates[i]))
        cloud.coordinates[i] =
            static_cast<float>(pose.translation()[static_cast<Eigen::Index>(i % 3)]);
    CameraStream stream(settingsOf(true));
    stream.encode(cloud);
    EXPECT_GE(stream.description.scan.height, 60u);
  }
}

TEST(CameraClouds, MayBeOfPartsOfTheirImages)
{
  const OrganisedCloud whole = cameraCloud(WorldPose::Identity(), 1);
  OrganisedCloud part = whole;
  // A person's outline, say, of which no row is whole.
  for (std::size_t i = 0; i < part.coordinates.size(); ++i) {
    const double column = static_cast<double>(i / 3 % 80) - 40.0;
    const double row = static_cast<double>(i / 3 / 80) - 30.0;
    if (column * column + row * row > 700.0)
      part.coordinates[i] = std::numeric_limits<float>::quiet_NaN();
  }
  CameraStream stream(settingsOf(true));
  stream.encode(withoutMissing(part));
  EXPECT_GT(stream.description.scan.height, 50u);
  // What is beyond the image that was found needs another one.
  stream.encode(withoutMissing(whole));
  EXPECT_TRUE(stream.description.is_i_frame);
  EXPECT_GE(stream.description.scan.height, 60u);
  stream.encode(withoutMissing(part));
  EXPECT_FALSE(stream.description.is_i_frame);
}

TEST(CameraClouds, MayHaveAFewOddPoints)
{
  const OrganisedCloud camera = withoutMissing(cameraCloud(WorldPose::Identity(), 1));
  const auto middle = static_cast<std::ptrdiff_t>(camera.coordinates.size() / 6 * 3);
  OrganisedCloud swapped = camera;
  std::swap_ranges(swapped.coordinates.begin() + middle,
                   swapped.coordinates.begin() + middle + 3,
                   swapped.coordinates.begin() + middle + 3);
  OrganisedCloud behind = camera;
  const std::array<float, 3> opposite = {0.0f, 0.1f, -1.0f};
  behind.coordinates.insert(
      behind.coordinates.begin() + middle, opposite.begin(), opposite.end());
  OrganisedCloud outside = camera;
  outside.coordinates[static_cast<std::size_t>(middle)] += 9.0f;
  for (const OrganisedCloud& cloud : {swapped, behind, outside}) {
    CameraStream stream(settingsOf(true));
    stream.encode(cloud);
    EXPECT_GE(stream.description.scan.height, 60u);
  }
}

TEST(CameraClouds, MayBeOnOneSideOfTheImage)
{
  OrganisedCloud fine{0, 0, {}, WorldPose::Identity()};
  for (unsigned int row = 0; row < 40; ++row)
    for (unsigned int column = 0; column < 40; ++column) {
      const float depth = 2.0f + 0.01f * static_cast<float>((row * column) % 7);
      fine.coordinates.insert(fine.coordinates.end(),
                              {(-0.5f + 0.01f * static_cast<float>(column)) * depth,
                               (-0.5f + 0.01f * static_cast<float>(row)) * depth,
                               depth});
    }
  CameraStream stream(settingsOf(true));
  stream.encode(fine);
  EXPECT_GE(stream.description.scan.height, 40u);
  EXPECT_LE(stream.description.scan.height, 60u);
}

TEST(CameraClouds, AreFoundAfterOneOfAFewPoints)
{
  const OrganisedCloud camera = withoutMissing(cameraCloud(WorldPose::Identity(), 1));
  OrganisedCloud few = camera;
  few.coordinates.resize(300);
  for (const bool keeps_order : {false, true}) {
    CloudEncoder encoder(settingsOf(keeps_order), IntensityUnit::None);
    Bytes bytes;
    for (const OrganisedCloud& cloud : {few, camera})
      ASSERT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
    const FrameDescription described = describeFrame(bytes.data(), bytes.size());
    EXPECT_TRUE(described.is_i_frame);
    EXPECT_GE(described.scan.height, 60u) << keeps_order;
  }
}

TEST(CameraClouds, AreFoundAgainAfterAnOddOne)
{
  const OrganisedCloud camera = withoutMissing(cameraCloud(WorldPose::Identity(), 1));
  for (const unsigned int i_frame_rate :
       {2u, 30u}) { // the odd one is an I-frame, or not
    EncoderSettings settings = settingsOf(true);
    settings.i_frame_rate = i_frame_rate;
    CameraStream stream(settings);
    for (const OrganisedCloud& cloud : {camera, camera, shuffled(camera), camera})
      stream.encode(cloud);
    EXPECT_GE(stream.description.scan.height, 60u) << i_frame_rate;
  }
}

TEST(CameraClouds, OfOtherSensorsHaveNoImage)
{
  const OrganisedCloud camera = withoutMissing(cameraCloud(WorldPose::Identity(), 1));
  OrganisedCloud noisy = camera;
  std::mt19937_64 random(3);
  for (float& coordinate : noisy.coordinates)
    coordinate += static_cast<float>(uniform(random, -0.01, 0.01));
  for (const OrganisedCloud& cloud : {shuffled(camera), noisy}) {
    CameraStream stream(settingsOf(true));
    stream.encode(cloud);
    EXPECT_EQ(stream.description.scan.height, 1u); // a sequence
  }
}

} // namespace

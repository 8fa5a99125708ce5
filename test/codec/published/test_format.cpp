// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "support/published_streams.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;
using pcl_ext::PublishedReference;
using pcl_ext::PublishedReferenceDecoder;

/** \brief The bytes except for the octree's box: its corners are sums that PCL and this
 * library take in different orders, so that their last bits may differ. */
void
expectSameBytes(const Bytes& bytes, const std::string& expected, bool is_i_frame)
{
  ASSERT_EQ(bytes.size(), expected.size());
  constexpr std::size_t box_begin = 6 + 4 + 1 + 8 + 8;
  constexpr std::size_t box_end = box_begin + 6 * 8;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (is_i_frame && i >= box_begin && i < box_end)
      continue;
    ASSERT_EQ(bytes[i], static_cast<std::uint8_t>(expected[i])) << "byte " << i;
  }
  for (std::size_t at = box_begin; is_i_frame && at < box_end; at += 8) {
    double corner;
    double expected_corner;
    std::memcpy(&corner, bytes.data() + at, 8);
    std::memcpy(&expected_corner, expected.data() + at, 8);
    EXPECT_NEAR(corner, expected_corner, 1e-9);
  }
}

struct Scene {
  double resolution;
  BoundingBox box;
  std::size_t points;
};

std::vector<Scene>
scenes()
{
  return {{0.04, {{-1.0, -1.0, 0.0}, {1.0, 1.0, 2.0}}, 3000},
          {0.02, {{-1.003, -2.017, 0.301}, {1.111, 0.777, 0.899}}, 2000},
          {0.1, {{-5.05, 100.03, -7.7}, {5.0, 103.0, -7.1}}, 1000},
          {0.01, {{12.3456, -0.5, -0.5}, {12.5, 0.0, 0.123}}, 500},
          {1.0, {{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}}, 4},
          {0.25, {{0.0, 0.0, 0.0}, {4.0, 4.0, 4.0}}, 20000}};
}

IntensityCompressionSettings
settingsOf(const Scene& scene)
{
  IntensityCompressionSettings settings;
  settings.format = StreamFormat::Published;
  settings.resolution = scene.resolution;
  settings.bounding_box = scene.box;
  return settings;
}

/** \brief Encodes clouds with the library and with PCL's octree, and decodes both
 * streams with both. */
class BothEncoders {
public:
  BothEncoders(const Scene& scene, unsigned int i_frame_rate)
  : reference_(
        scene.resolution, corner(scene.box.min), corner(scene.box.max), i_frame_rate)
  , voxelizer_(settingsOf(scene), IntensityUnit::Native)
  , encoder_(StreamFormat::Published, i_frame_rate)
  {}

  void
  send(const Cloud& cloud)
  {
    const VoxelizationStatistics voxelized =
        voxelizer_.voxelize(pcl_ext::pointViewWithIntensities(cloud), false, frame_);
    ASSERT_EQ(voxelized.points_used, cloud.size());
    ours = encoded(encoder_, frame_);
    reference = reference_.encode(cloud);
    ++number_;
    expectDecoded(decoder_of_ours_, ours, reference_of_ours_);
    expectDecoded(decoder_of_reference_, bytesOf(reference), reference_of_reference_);
    EXPECT_EQ(reference_of_ours_.frameNumber(), number_);
  }

  // Of the last frame.
  Bytes ours;
  std::string reference;

private:
  void
  expectDecoded(FrameDecoder& decoder,
                const Bytes& bytes,
                PublishedReferenceDecoder& reference_decoder)
  {
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    expectSameVoxels(back, frame_);
    expectSameCloud(back, reference_decoder.decode(textOf(bytes)));
  }

  PublishedReference reference_;
  Voxelizer voxelizer_;
  FrameEncoder encoder_;
  PublishedReferenceDecoder reference_of_ours_;
  PublishedReferenceDecoder reference_of_reference_;
  FrameDecoder decoder_of_ours_;
  FrameDecoder decoder_of_reference_;
  VoxelFrame frame_;
  unsigned int number_ = 0;
};

TEST(PublishedFormat, PointsBecomeTheReferencesBytesInBothDirections)
{
  std::mt19937_64 random(1);
  for (const Scene& scene : scenes())
    for (const unsigned int rate : {1u, 4u}) {
      SCOPED_TRACE(scene.resolution);
      BothEncoders encoders(scene, rate);
      Cloud cloud = randomCloud(random, scene.box, scene.points);
      for (unsigned int number = 1; number <= 9; ++number) {
        ASSERT_NO_FATAL_FAILURE(encoders.send(cloud));
        expectSameBytes(encoders.ours, encoders.reference, number % rate == 1 % rate);
        shake(random, scene.box, cloud);
      }
    }
}

TEST(PublishedFormat, EmptyFramesGoBothWays)
{
  std::mt19937_64 random(5);
  const Scene scene = scenes()[0];
  BothEncoders encoders(scene, 4);
  for (const std::size_t points :
       {0u, 0u, 5u, 100u, 0u, 100u, 90u, 0u, 0u, 3u, 3u, 3u, 0u})
    ASSERT_NO_FATAL_FAILURE(encoders.send(randomCloud(random, scene.box, points)));
}

/** \brief Points with the intensity that a law gives them; the reference adds up floats
 * of 255 times the share, so the shares are such that no sum rounds. */
template <typename LawT>
void
expectLaw(const LawT& law)
{
  std::mt19937_64 random(2);
  const Scene scene = scenes()[1];
  Cloud cloud = randomCloud(random, scene.box, scene.points);
  Cloud shown = cloud; // in the reference's unit, 0 to 255
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float depth = static_cast<float>(below(random, 65)) / 64.0f;
    cloud[i].intensity = law(depth, static_cast<float>(below(random, 300)));
    shown[i].intensity =
        cloud[i].intensity * (LawT::unit == IntensityUnit::Share ? 255.0f : 1.0f);
  }
  PublishedReference reference(
      scene.resolution, corner(scene.box.min), corner(scene.box.max), 3);
  Voxelizer voxelizer(settingsOf(scene), LawT::unit);
  FrameEncoder encoder(StreamFormat::Published, 3);
  VoxelFrame frame;
  voxelizer.voxelize(pcl_ext::pointViewWithIntensities(cloud), false, frame);
  expectSameBytes(encoded(encoder, frame), reference.encode(shown), true);
  EXPECT_GT(*std::max_element(frame.intensities.begin(), frame.intensities.end()), 0);
}

TEST(PublishedFormat, AllLawsMakeTheReferencesBytes)
{
  expectLaw(pcl_ext::CountLaw());
  expectLaw(pcl_ext::QuadraticLaw());
  expectLaw(pcl_ext::LinearLaw());
  expectLaw(pcl_ext::NativeLaw());
}

TEST(PublishedFormat, AWorldGridIsPlacedWithinAMicrometre)
{
  std::mt19937_64 random(3);
  FrameEncoder encoder(StreamFormat::Published, 6);
  PublishedReferenceDecoder reference;
  const VoxelFrame frame = randomFrame(random, 7, 100); // first_index is not 0
  const Cloud cloud = reference.decode(textOf(encoded(encoder, frame)));
  ASSERT_EQ(cloud.size(), frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame.keys[i]);
    EXPECT_NEAR(double{cloud[i].x}, frame.grid.centre(0, position.x), 1e-6);
    EXPECT_NEAR(double{cloud[i].y}, frame.grid.centre(1, position.y), 1e-6);
    EXPECT_NEAR(double{cloud[i].z}, frame.grid.centre(2, position.z), 1e-6);
  }
}

TEST(PublishedFormat, DecodingOverwritesTheWholeFrame)
{
  VoxelFrame frame = emptyFrame(4);
  frame.keys = {3, 5};
  frame.intensities = {7, 200};
  FrameEncoder encoder(StreamFormat::Published, 4);
  FrameDecoder decoder;
  // As a frame of version 1, of the quadratic law, may have left it.
  VoxelFrame back = emptyFrame(9, 12);
  back.keys = {1, 2, 3};
  back.intensities = {1, 1, 1};
  back.intensity_scale.offset = 3.0f;
  back.depth_model.emplace();
  ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
  expectSameVoxels(back, frame);
  EXPECT_EQ(back.grid.depth, frame.grid.depth);
  EXPECT_EQ(back.grid.first_index, VoxelGrid().first_index);
  EXPECT_FALSE(back.depth_model.has_value());
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames whose points have the order of a sensor.
 */
#include <pcl_ext/compression/frame_decoder.h>

#include "stream/frame_encoder.h"
#include "support/image_frames.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "voxels/keep_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

class Images : public testing::TestWithParam<Effort> {};

TEST_P(Images, RandomFramesComeBack)
{
  std::mt19937_64 random(11);
  FrameEncoder encoder(StreamFormat::Version1, 4, GetParam());
  FrameDecoder decoder;
  for (int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    PointImage image = i / 6 % 2 == 0 ? planarImage(48, 32) : spinningImage(128, 40, 9);
    image.has_points_at_sensor = i < 12 && i / 3 % 2 == 1;
    ImagePoints points;
    points.noise = 1 + below(random, 9);
    points.misses = 12 + below(random, 90);
    points.nearest = static_cast<std::uint32_t>(30 + below(random, 60));
    VoxelFrame frame = imageFrame(random, image, 9, points);
    if (image.has_points_at_sensor)
      addPointsAtSensor(random, frame);
    if (i >= 12)
      addFields(random, frame);
    if (i >= 18)
      addColours(random, 6, frame);
    if (i % 9 == 8)
      clearVoxels(frame);
    VoxelFrame back;
    const Bytes bytes = encoded(encoder, frame);
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    if (frame.keys.empty() && encoder.statistics().is_i_frame)
      frame.image = PointImage();
    if (back.image.hasPixels() || frame.keys.empty()) {
      EXPECT_EQ(decoder.statistics().has_image, back.image.hasPixels());
      expectSameFrame(back, frame);
    }
    else
      ADD_FAILURE() << "no image";
  }
}

TEST_P(Images, AreCodedWhereTheyTakeFewerBytes)
{
  std::mt19937_64 random(12);
  // Points anywhere have no rays to be on.
  VoxelFrame frame = imageFrame(random, planarImage(48, 32), 9, {90, 50, 1, 200, 2});
  VoxelFrame without = frame;
  without.image = PointImage();
  FrameEncoder encoder(StreamFormat::Version1, 3, GetParam());
  FrameEncoder encoder_without(StreamFormat::Version1, 3, GetParam());
  for (int i = 0; i < 5; ++i) {
    const Bytes bytes = encoded(encoder, frame);
    EXPECT_TRUE(encoder.isIFrameDue() || !encoder.takesImages());
    EXPECT_EQ(bytes, encoded(encoder_without, without));
  }
}

TEST_P(Images, OthersTakeAnIFrame)
{
  std::mt19937_64 random(13);
  PointImage image = spinningImage(64, 16, 9);
  FrameEncoder encoder(StreamFormat::Version1, 30, GetParam());
  const auto is_i_frame = [&] {
    encoded(encoder, imageFrame(random, image, 9));
    EXPECT_TRUE(encoder.statistics().has_image);
    return encoder.statistics().is_i_frame;
  };
  EXPECT_TRUE(is_i_frame());
  EXPECT_FALSE(is_i_frame());
  ++image.rays.rows[7].up;
  EXPECT_TRUE(is_i_frame());
  EXPECT_FALSE(is_i_frame());
  image.is_organised = false;
  EXPECT_TRUE(is_i_frame());
  image = spinningImage(63, 16, 9);
  EXPECT_TRUE(is_i_frame());
  EXPECT_FALSE(is_i_frame());
}

TEST_P(Images, OfMovingSensorsAreInPFrames)
{
  std::mt19937_64 random(18);
  FrameEncoder encoder(StreamFormat::Version1, 30, GetParam());
  FrameDecoder decoder;
  for (PointImage image : {planarImage(48, 32), spinningImage(64, 16, 9)}) {
    image.is_organised = false;
    std::vector<std::size_t> header_bytes;
    for (int i = 0; i < 8; ++i) {
      SCOPED_TRACE(i);
      RayPose& pose = image.rays.pose;
      if (i == 2)
        pose.origin[1] += 12345;
      else if (i == 4 || i == 6)
        pose.vectors[2][0] -= 1 << 20;
      VoxelFrame frame = imageFrame(random, image, 9);
      if (i == 6)
        clearVoxels(frame);
      const Bytes bytes = encoded(encoder, frame);
      EXPECT_EQ(encoder.statistics().is_i_frame, i == 0);
      EXPECT_TRUE(encoder.statistics().has_image);
      header_bytes.push_back(encoder.statistics().header_bytes);
      VoxelFrame back;
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
      expectSameFrame(back, frame);
      EXPECT_EQ(back.cloudWidth(), back.pointCount());
      EXPECT_EQ(back.cloudHeight(), 1u);
    }
    // Another pose takes bytes, the same one none.
    EXPECT_LT(header_bytes[1] + 20, header_bytes[2]);
    EXPECT_LT(header_bytes[3] + 20, header_bytes[4]);
    EXPECT_LT(header_bytes[7], header_bytes[2]);
  }
}

TEST(ImagesOfFrames, HaveOnePixelForEachPoint)
{
  std::mt19937_64 random(14);
  const VoxelFrame good = imageFrame(random, planarImage(48, 32), 7);
  ASSERT_TRUE(isConsistent(good));
  ASSERT_GT(good.pointCount(), good.size());
  const auto is_consistent = [&](auto change) {
    VoxelFrame frame = good;
    change(frame);
    return isConsistent(frame);
  };
  const auto shared = static_cast<std::size_t>(
      std::find_if(good.point_counts.begin(),
                   good.point_counts.end(),
                   [](std::uint32_t count) { return count > 1; }) -
      good.point_counts.begin());
  std::size_t point = 0;
  for (std::size_t voxel = 0; voxel < shared; ++voxel)
    point += good.point_counts[voxel];
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.image.pixels.pop_back(); }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.image.depths.push_back(0); }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.image.pixels[1] = 48 * 32; }));
  EXPECT_FALSE(
      is_consistent([](VoxelFrame& f) { f.image.pixels[0] = f.image.pixels[5]; }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.image.depths[3] = depth_end; }));
  EXPECT_FALSE(is_consistent([&](VoxelFrame& f) {
    std::swap(f.image.pixels[point], f.image.pixels[point + 1]);
  }));
  EXPECT_FALSE(is_consistent([](VoxelFrame& f) { f.image.width = 0; }));
  EXPECT_TRUE(is_consistent([](VoxelFrame& f) { f.image = PointImage(); }));

  VoxelFrame with_points_at_sensor = good;
  with_points_at_sensor.image.has_points_at_sensor = true;
  addPointsAtSensor(random, with_points_at_sensor);
  EXPECT_TRUE(isConsistent(with_points_at_sensor));
  std::vector<std::uint32_t>& depths = with_points_at_sensor.image.depths;
  *std::find(depths.begin(), depths.end(), 0u) = 1;
  EXPECT_FALSE(isConsistent(with_points_at_sensor));
}

TEST(ImagesOfFrames, AreGoneInFramesOfOtherStreamsWithoutOne)
{
  std::mt19937_64 random(15);
  const VoxelFrame frame = imageFrame(random, planarImage(48, 32), 9, ImagePoints());
  FrameEncoder encoder(StreamFormat::Version1, 3, Effort::Fast);
  const Bytes with_image = encoded(encoder, frame);
  VoxelFrame other;
  other.grid = frame.grid;
  other.keys = frame.keys;
  other.intensities.assign(other.keys.size(), 7);
  for (const StreamFormat format : {StreamFormat::Version1, StreamFormat::Published}) {
    FrameEncoder other_encoder(format, 3, Effort::Fast);
    const Bytes without = encoded(other_encoder, other);
    VoxelFrame back;
    FrameDecoder decoder;
    FrameDecoder other_decoder;
    ASSERT_EQ(decoded(decoder, with_image, back), CompressionCode::Ok);
    EXPECT_TRUE(back.image.hasPixels());
    ASSERT_EQ(decoded(other_decoder, without, back), CompressionCode::Ok);
    EXPECT_FALSE(back.image.hasPixels());
    EXPECT_EQ(back.size(), other.size());
  }
}

TEST(ImagesOfFrames, StayWithTheVoxelsThatAreKept)
{
  std::mt19937_64 random(18);
  VoxelFrame frame = imageFrame(random, planarImage(48, 32), 7);
  addFields(random, frame);
  using Point = std::pair<std::uint64_t, std::uint32_t>; // key and depth
  const auto by_pixel = [](const VoxelFrame& voxels) {
    std::map<std::uint32_t, Point> points;
    std::size_t point = 0;
    for (std::size_t i = 0; i < voxels.size(); ++i)
      for (std::uint32_t k = 0; k < voxels.point_counts[i]; ++k, ++point)
        points[voxels.image.pixels[point]] = {voxels.keys[i],
                                              voxels.image.depths[point]};
    return points;
  };
  std::map<std::uint32_t, Point> expected;
  for (const auto& [pixel, point] : by_pixel(frame))
    if (point.first % 3 != 0)
      expected[pixel] = point;
  keepVoxels(frame, [&](std::size_t i) { return frame.keys[i] % 3 != 0; });
  EXPECT_TRUE(isConsistent(frame));
  EXPECT_EQ(by_pixel(frame), expected);
}

INSTANTIATE_TEST_SUITE_P(,
                         Images,
                         testing::ValuesIn(all_efforts),
                         [](const auto& effort) { return nameOf(effort.param); });

} // namespace

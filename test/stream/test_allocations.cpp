// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"
#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

constexpr unsigned int usual_i_frame_rate = 10;
constexpr std::size_t first_second = 20; // frames
constexpr std::size_t warm_up = first_second + usual_i_frame_rate;
constexpr std::size_t frame_count = warm_up + 3 * usual_i_frame_rate;

std::vector<VoxelFrame>
room(bool has_depth_model)
{
  RoomStream::Settings settings = roomSettings(8, 60, has_depth_model);
  RoomStream stream(settings);
  // The first second has the largest frames: a frame that is larger than all before it
  // may take memory.
  settings.noise *= 40;
  RoomStream first(settings); // of the same scene
  std::vector<VoxelFrame> frames;
  for (std::size_t i = 0; i < frame_count; ++i)
    frames.push_back(i < first_second ? first.next() : stream.next());
  return frames;
}

void
expectNoAllocations(Effort effort, bool has_depth_model_and_stamp)
{
  SCOPED_TRACE(nameOf(effort));
  const std::vector<VoxelFrame> frames = room(has_depth_model_and_stamp);
  FrameEncoder encoder(StreamFormat::Version1, usual_i_frame_rate, effort);
  FrameDecoder decoder;
  std::vector<std::uint8_t> bytes;
  VoxelFrame back;
  std::size_t allocations = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::optional<FrameStamp> stamp;
    if (has_depth_model_and_stamp)
      stamp = FrameStamp{1700000000000000 + 50000 * i, "a_frame_of_some_length"};
    const MemoryUse memory_use;
    ASSERT_TRUE(encoder.encode(frames[i], stamp, bytes).ok());
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), back).ok());
    allocations += i < warm_up ? 0 : memory_use.allocations();
    EXPECT_EQ(encoder.statistics().is_i_frame, i % usual_i_frame_rate == 0);
    ASSERT_EQ(decoder.stamp().has_value(), stamp.has_value());
  }
  EXPECT_EQ(allocations, 0u);
}

TEST(Allocations, CodingAllocatesNothingAfterWarmUp)
{
  for (const Effort effort : all_efforts)
    for (const bool has_depth_model_and_stamp : {false, true})
      expectNoAllocations(effort, has_depth_model_and_stamp);
}

TEST(Allocations, EncodingCloudsAllocatesNothingAfterWarmUp)
{
  std::vector<Cloud> clouds;
  for (const std::uint64_t seed : {3u, 4u, 5u}) {
    clouds.push_back(randomCloud(seed, -0.4, 0.4));
    for (Point& point : clouds.back())
      point.intensity = 1.0f;
  }
  for (const Effort effort : all_efforts) {
    IntensityCompressionSettings settings = settingsOf(0.04);
    settings.effort = effort;
    settings.i_frame_rate = usual_i_frame_rate;
    settings.bounding_box = BoundingBox{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
    CloudEncoder encoder(settings, pcl_ext::IntensityUnit::Points);
    std::vector<std::uint8_t> bytes;
    std::size_t allocations = 0;
    for (std::size_t i = 0; i < frame_count; ++i) {
      const PointView view = viewOf(clouds[i % clouds.size()]);
      const MemoryUse memory_use;
      const CompressionStatus status = encoder.encode(view, {}, bytes);
      allocations += i < warm_up ? 0 : memory_use.allocations();
      ASSERT_TRUE(status.ok());
      ASSERT_FALSE(status.hasWarning()) << status.message(); // which takes memory
    }
    EXPECT_EQ(allocations, 0u) << "effort " << static_cast<int>(effort);
  }
}

TEST(Allocations, FramesThatGrowSlowlyRarelyAllocate)
{
  std::mt19937_64 random(6);
  Cloud cloud = randomCloud(7, -4.0, 4.0, 6000);
  for (const Effort effort : all_efforts) {
    IntensityCompressionSettings settings = settingsOf(0.04);
    settings.effort = effort;
    settings.bounding_box = BoundingBox{{-5, -5, -5}, {5, 5, 5}};
    CloudEncoder encoder(settings, pcl_ext::IntensityUnit::Points);
    FrameDecoder decoder;
    VoxelFrame back;
    std::vector<std::uint8_t> bytes;
    std::size_t frames_with_allocations = 0;
    for (std::size_t i = 0; i < frame_count; ++i) {
      for (const Point& point : randomCloud(random(), -4.0, 4.0, 20))
        cloud.push_back(point);
      PointView view = viewOf(cloud);
      view.intensities = nullptr;
      const MemoryUse memory_use;
      ASSERT_TRUE(encoder.encode(view, {}, bytes).ok());
      ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), back).ok());
      frames_with_allocations += i >= warm_up && memory_use.allocations() > 0 ? 1 : 0;
    }
    EXPECT_LE(frames_with_allocations, (frame_count - warm_up) / 4)
        << "effort " << static_cast<int>(effort);
  }
}

} // namespace

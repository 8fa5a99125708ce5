// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/labelled_stream.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::noise::LabelledFrame;
using pcl_ext::noise::LabelledStream;

struct Scene {
  unsigned int depth;
  std::size_t voxels;
};
const std::vector<Scene> scenes{
    {8, 1}, {8, 50}, {8, 5000}, {4, 3500}, {2, 64}, {6, 100000}, {21, 300}, {1, 0}};

TEST(FrameSizes, NoEffortIsLargerThanThePublishedLayout)
{
  for (const Effort effort : all_efforts) {
    std::mt19937_64 random(11);
    for (const Scene& scene : scenes) {
      FrameEncoder version1(StreamFormat::Version1, 3, effort);
      FrameEncoder published(StreamFormat::Published, 3);
      VoxelFrame frame = randomFrame(random, scene.depth, scene.voxels);
      for (int i = 0; i < 6; ++i) {
        // A third of a small grid at random is noise in every bit, which the published
        // layout's static table codes better than adaptive models, and much better than
        // those of effort fast, which expect intensities near previous ones.
        const std::size_t published_size = encoded(published, frame).size();
        const std::size_t percent = scene.voxels < 100000    ? 100
                                    : effort == Effort::Fast ? 108
                                                             : 102;
        EXPECT_LE(100 * encoded(version1, frame).size(), percent * published_size)
            << scene.voxels << " voxels, depth " << scene.depth;
        walk(random, static_cast<unsigned int>(scene.voxels / 10), frame);
      }
    }
  }
}

TEST(FrameSizes, DepthModelsThatSaveNothingAreLeftOut)
{
  for (const Effort effort : all_efforts) {
    RoomStream room(roomSettings(8, 60, true));
    FrameEncoder with(StreamFormat::Version1, 4, effort);
    FrameEncoder without(StreamFormat::Version1, 4, effort);
    for (int i = 0; i < 10; ++i) {
      VoxelFrame frame = room.next();
      frame.intensities.assign(frame.size(), 255); // all are saturated
      const Bytes bytes = encoded(with, frame);
      frame.depth_model.reset();
      EXPECT_EQ(bytes, encoded(without, frame));
    }
  }
}

struct RoomBytes {
  std::size_t all = 0;
  std::size_t of_p_frames = 0;
};

/** \brief Bytes of some frames of a room after its first second. */
RoomBytes
bytesOfRoom(const RoomStream::Settings& settings, FrameEncoder encoder)
{
  RoomStream room(settings);
  RoomBytes bytes;
  for (int i = 0; i < 40; ++i) {
    const std::size_t size = encoded(encoder, room.next()).size();
    if (i < 20)
      continue;
    bytes.all += size;
    bytes.of_p_frames += encoder.statistics().is_i_frame ? 0 : size;
  }
  return bytes;
}

TEST(FrameSizes, AStaticSceneIsMuchSmallerThanInThePublishedLayout)
{
  for (const std::uint32_t width : {25u, 60u, 150u}) {
    SCOPED_TRACE(width);
    RoomStream::Settings settings;
    settings.width = width;
    settings.noise = width / 5;
    const RoomBytes published =
        bytesOfRoom(settings, FrameEncoder(StreamFormat::Published, 10));
    std::vector<RoomBytes> bytes;
    for (const Effort effort : all_efforts)
      bytes.push_back(
          bytesOfRoom(settings, FrameEncoder(StreamFormat::Version1, 10, effort)));
    for (const auto part : {&RoomBytes::all, &RoomBytes::of_p_frames}) {
      EXPECT_LE(bytes[0].*part, published.*part);
      EXPECT_LE(4 * (bytes[1].*part), 3 * (published.*part));
      EXPECT_LE(4 * (bytes[2].*part), 3 * (published.*part));
      // More effort is no larger.
      EXPECT_LE(bytes[1].*part, bytes[0].*part);
      EXPECT_LE(bytes[2].*part, bytes[1].*part);
    }
  }
}

TEST(FrameSizes, PFramesAreSmallerThanIFrames)
{
  for (const Effort effort : all_efforts) {
    const auto size = [&](unsigned int rate) {
      return bytesOfRoom({}, FrameEncoder(StreamFormat::Version1, rate, effort)).all;
    };
    EXPECT_LT(5 * size(1000), 4 * size(1));
  }
}

TEST(FrameSizes, FiftyVoxelsOfAKnownSceneTakeNinetyBytesAtMost)
{
  // Most of them stay, as on a robot's arm that holds still; all of the frame counts.
  for (const Effort effort : all_efforts) {
    std::mt19937_64 random(5);
    VoxelFrame scene = randomFrame(random, 8, 50);
    for (std::uint16_t& symbol : scene.intensities)
      symbol = static_cast<std::uint16_t>(1 + below(random, 4));
    FrameEncoder encoder(StreamFormat::Version1, 30, effort);
    for (int i = 0; i < 30; ++i) {
      VoxelFrame frame = scene;
      for (int change = 0; change < 3; ++change) {
        const std::size_t lost = below(random, frame.size());
        frame.keys.erase(frame.keys.begin() + static_cast<std::ptrdiff_t>(lost));
        frame.intensities.erase(frame.intensities.begin() +
                                static_cast<std::ptrdiff_t>(lost));
      }
      for (int change = 0; change < 10; ++change)
        frame.intensities[below(random, frame.size())] =
            static_cast<std::uint16_t>(1 + below(random, 4));
      const std::size_t size = encoded(encoder, frame).size();
      if (i >= 20) {
        EXPECT_LE(size, 90u) << "frame " << i;
      }
    }
  }
}

TEST(FrameSizes, DepthModelsSaveAQuarterOfTheIntensities)
{
  for (const Effort effort : {Effort::Balanced, Effort::Small})
    for (const std::uint8_t exponent : {std::uint8_t{1}, std::uint8_t{2}})
      for (const unsigned int bits : {8u, 12u}) {
        RoomStream::Settings settings;
        settings.bits = bits;
        settings.depth_model = roomDepthModel(settings.depth, bits, exponent);
        RoomStream room(settings);
        FrameEncoder with(StreamFormat::Version1, 20, effort);
        FrameEncoder without(StreamFormat::Version1, 20, effort);
        std::size_t bytes_with = 0;
        std::size_t bytes_without = 0;
        for (int i = 0; i < 40; ++i) {
          VoxelFrame frame = room.next();
          encoded(with, frame);
          bytes_with += with.statistics().intensity_bytes;
          frame.depth_model.reset();
          encoded(without, frame);
          bytes_without += without.statistics().intensity_bytes;
        }
        EXPECT_LT(4 * bytes_with, 3 * bytes_without)
            << bits << " bits, exponent " << static_cast<int>(exponent);
      }
}

// From fine voxels, of which most hold one point, to coarse ones with dozens in which
// it costs nothing to learn no voxel's count in the I-frame, but much after it.
TEST(FrameSizesOfTheCell, FastIsAnEighthLargerThanBalancedAtMost)
{
  for (const double resolution : {0.04, 0.1, 0.19, 0.5}) {
    LabelledStream stream(1, 1, resolution); // of sensor 1
    LabelledFrame frame;
    FrameEncoder balanced_encoder(StreamFormat::Version1, 30, Effort::Balanced);
    FrameEncoder fast_encoder(StreamFormat::Version1, 30, Effort::Fast);
    std::size_t balanced = 0;
    std::size_t fast = 0;
    for (std::uint32_t number = 0; number < 30; ++number) {
      stream.read(number, frame);
      const VoxelFrame& voxels = frame.of(pcl_ext::noise::Law::Count);
      balanced += encoded(balanced_encoder, voxels).size();
      fast += encoded(fast_encoder, voxels).size();
    }
    EXPECT_GT(fast, balanced) << resolution;
    EXPECT_LT(8 * fast, 9 * balanced) << resolution;
  }
}

} // namespace

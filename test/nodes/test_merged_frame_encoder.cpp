// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "nodes/merged_frame_encoder.h"
#include "support/node_tests.h"

#include <memory>

namespace {

namespace merged_frame_encoder {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::IntensityScale;

constexpr double resolution = 0.04;
constexpr std::size_t streams = 6;
constexpr std::size_t zones = 3;

/** \brief Some voxels of a stream with intensities on a scale and colours. */
VoxelFrame
someVoxels(std::mt19937_64& random, const IntensityScale& scale)
{
  VoxelFrame frame = pcl_ext::io::test::randomFrame(random, 4, 900, 8);
  frame.grid.resolution = resolution;
  frame.intensity_scale = scale;
  frame.colour_bits = 8;
  for (std::uint16_t& intensity : frame.intensities)
    intensity = static_cast<std::uint16_t>(below(random, scale.maxSymbol() + 1));
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const auto channel = [&] { return static_cast<std::uint8_t>(below(random, 256)); };
    const std::uint8_t r = channel();
    const std::uint8_t g = channel();
    frame.colours.push_back({r, g, channel()});
  }
  return frame;
}

IntensityScale
scaleOf(float offset, float step)
{
  IntensityScale scale;
  scale.offset = offset;
  scale.step = step;
  return scale;
}

/** \brief A centre whose merged frames are a stream. */
struct Zone {
  Zone() : node(centralSettings()), encoder({}) {}

  Bytes
  next(std::size_t number)
  {
    VoxelFrame merged;
    EXPECT_TRUE(node.merge(merged).ok());
    Bytes bytes;
    EXPECT_TRUE(
        encoder.encode(merged, std::chrono::milliseconds(100 * number), "world", bytes)
            .ok());
    return bytes;
  }

  CentralNode node;
  MergedFrameEncoder encoder;
};

class MergedFrames : public ::testing::TestWithParam<IntensityScale> {};

TEST_P(MergedFrames, OfThreeCentresAreThoseOfOne)
{
  std::mt19937_64 random(7);
  CentralNode one(centralSettings());
  CentralNode top(centralSettings());
  std::vector<std::unique_ptr<Zone>> all;
  for (std::size_t zone = 0; zone < zones; ++zone) {
    all.push_back(std::make_unique<Zone>());
    top.addStream(std::to_string(zone));
  }
  for (std::size_t stream = 0; stream < streams; ++stream) {
    one.addStream(std::to_string(stream));
    all[stream % zones]->node.addStream(std::to_string(stream));
  }
  for (std::size_t number = 0; number < 6; ++number) {
    for (std::size_t stream = 0; stream < streams; ++stream) {
      const Bytes frame = coded(someVoxels(random, GetParam()));
      sendAndWait(one, std::to_string(stream), frame);
      sendAndWait(all[stream % zones]->node, std::to_string(stream), frame);
    }
    for (std::size_t zone = 0; zone < zones; ++zone) {
      sendAndWait(top, std::to_string(zone), all[zone]->next(number));
    }
    VoxelFrame expected;
    VoxelFrame merged;
    ASSERT_TRUE(one.merge(expected).ok());
    const MergeStatus status = top.merge(merged);
    ASSERT_TRUE(status.ok());
    ASSERT_EQ(status.streams.size(), zones);
    EXPECT_EQ(status.streams[0].frame->stamp,
              Time(std::chrono::milliseconds(100 * number)));
    EXPECT_EQ(worldVoxels(merged), worldVoxels(expected));
    EXPECT_EQ(merged.colour_bits, 8u);
  }
}

// Counts, shares of a voxel's face, hundredths.
INSTANTIATE_TEST_SUITE_P(Scales,
                         MergedFrames,
                         ::testing::Values(scaleOf(1.0f, 1.0f),
                                           scaleOf(0.0f, 1.0f),
                                           scaleOf(0.0f, 1.0f / 255.0f),
                                           scaleOf(0.0f, 0.01f)));

TEST(MergedFrames, KeepColours)
{
  std::mt19937_64 random(8);
  Zone zone;
  zone.node.addStream("a");
  const VoxelFrame frame = someVoxels(random, scaleOf(1.0f, 1.0f));
  sendAndWait(zone.node, "a", coded(frame));
  pcl_ext::io::FrameDecoder decoder;
  VoxelFrame decoded;
  const Bytes bytes = zone.next(1);
  ASSERT_EQ(pcl_ext::io::test::decoded(decoder, bytes, decoded), CompressionCode::Ok);
  ASSERT_EQ(decoded.size(), frame.size());
  EXPECT_EQ(decoded.colours, frame.colours);
  EXPECT_EQ(worldVoxels(decoded), worldVoxels(frame));
  ASSERT_TRUE(decoder.stamp());
  EXPECT_EQ(decoder.stamp()->stamp, 100'000u);
  EXPECT_EQ(decoder.stamp()->frame_id, "world");
}

/** \brief Three voxels, with intensities in steps of 2 up to 131070, or of 1. */
VoxelFrame
frameOf(std::vector<std::uint16_t> numbers, float step)
{
  VoxelFrame frame = pcl_ext::io::test::emptyFrame(4);
  frame.grid.resolution = resolution;
  frame.keys = {1, 20, 300};
  frame.intensities = std::move(numbers);
  frame.intensity_scale.bits = 16;
  frame.intensity_scale.step = step;
  return frame;
}

TEST(MergedFrames, WholeIntensitiesAreExactBehindOnesThatHaveNoStep)
{
  Zone zone;
  zone.node.addStream("a");
  pcl_ext::io::FrameDecoder decoder;
  VoxelFrame decoded;
  // The first one is on a scale of 16 bits with steps of about 2.
  sendAndWait(zone.node, "a", coded(frameOf({50000, 3, 1}, 2.0f)));
  ASSERT_EQ(pcl_ext::io::test::decoded(decoder, zone.next(1), decoded),
            CompressionCode::Ok);
  ASSERT_GT(decoded.intensity_scale.step, 2.0f);
  const VoxelFrame frame = frameOf({40000, 3, 1}, 1.0f);
  sendAndWait(zone.node, "a", coded(frame));
  ASSERT_EQ(pcl_ext::io::test::decoded(decoder, zone.next(2), decoded),
            CompressionCode::Ok);
  EXPECT_EQ(worldVoxels(decoded), worldVoxels(frame));
}

TEST(MergedFrames, AreOfTheStampsThatAreAskedFor)
{
  FakeClock clock;
  CentralNodeSettings settings = centralSettings();
  settings.clock = clock.clock();
  CentralNode node(settings);
  std::mt19937_64 random(9);
  const VoxelFrame frame = someVoxels(random, scaleOf(1.0f, 1.0f));
  node.addStream("slow");
  ASSERT_TRUE(node.receive("slow", coded(frame), Time(5000)).ok());
  node.waitUntilDecoded();
  clock.set(std::chrono::hours(1)); // long after it was decoded
  VoxelFrame merged;
  EXPECT_FALSE(node.merge(merged).streams[0].frame);
  EXPECT_TRUE(node.merge(merged, StampRange{Time(5000), Time(5000)}).streams[0].frame);
  EXPECT_EQ(worldVoxels(merged), worldVoxels(frame));
  EXPECT_FALSE(node.merge(merged, StampRange{Time(5001), Time(9000)}).streams[0].frame);
  EXPECT_FALSE(node.merge(merged, StampRange{Time(0), Time(4999)}).streams[0].frame);
}

TEST(MergedFrameEncoder, IFramesComeByStamps)
{
  std::mt19937_64 random(3);
  const VoxelFrame frame = someVoxels(random, scaleOf(0.0f, 1.0f));
  pcl_ext::io::StreamSettings stream;
  stream.i_frame_every = 0.3;
  MergedFrameEncoder encoder(stream);
  FrameDecoder decoder;
  std::string kinds;
  for (const int ms : {500, 700, 799, 800, 900, 1101}) {
    Bytes bytes;
    VoxelFrame back;
    ASSERT_TRUE(
        encoder.encode(frame, std::chrono::milliseconds(ms), "world", bytes).ok());
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), back).ok());
    kinds += decoder.statistics().is_i_frame ? 'I' : 'P';
  }
  EXPECT_EQ(kinds, "IPPIPI");
}

} // namespace merged_frame_encoder

} // namespace

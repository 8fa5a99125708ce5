// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "codec/frame_limits.h"
#include "support/forged_frames.h"
#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::DecodingMemory;
using pcl_ext::io::test::Parts;
using pcl_ext::io::test::putTogether;
using pcl_ext::io::test::RoomStream;
using pcl_ext::io::test::takeApart;
using pcl_ext::test::MemoryUse;

/** \brief Below it nothing is released, bytes. */
constexpr std::size_t floor_of_rule = std::size_t{1} << 16;

/** \brief I-frames of one sender: some large ones, and small ones after them. */
std::vector<Bytes>
largeThenSmall(std::size_t large_frames, std::size_t small_frames)
{
  RoomStream::Settings settings;
  settings.width = 200;
  RoomStream large(settings);
  settings.width = 10;
  RoomStream small(settings);
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Fast);
  std::vector<Bytes> frames;
  for (std::size_t i = 0; i < large_frames; ++i)
    frames.push_back(pcl_ext::io::test::encoded(encoder, large.next()));
  for (std::size_t i = 0; i < small_frames; ++i)
    frames.push_back(pcl_ext::io::test::encoded(encoder, small.next()));
  return frames;
}

/** \brief What a decoder of these frames keeps. */
std::size_t
keptByDecoder(const std::vector<Bytes>& frames)
{
  const MemoryUse memory_use;
  FrameDecoder decoder;
  DecodingMemory memory;
  for (const Bytes& bytes : frames) {
    VoxelFrame voxels;
    decoder.decode(bytes.data(), bytes.size(), voxels, memory);
  }
  return memory_use.live();
}

/** \brief What a node of one thread keeps besides its decoder.
 * \param[in] merges whether all is merged after each frame
 */
std::size_t
keptByNode(const std::vector<Bytes>& frames, bool merges)
{
  const std::size_t of_decoder = keptByDecoder(frames);
  CentralNodeSettings settings = centralSettings();
  settings.threads = 1;
  settings.max_merge_age = Time::max();
  const MemoryUse memory_use;
  CentralNode node(settings);
  node.addStream("a");
  for (const Bytes& bytes : frames) {
    sendAndWait(node, "a", bytes);
    VoxelFrame merged;
    if (merges)
      node.merge(merged);
  }
  const std::size_t kept = memory_use.live();
  return kept - std::min(kept, of_decoder);
}

TEST(CentralNodeMemoryUse, IsReleasedSomeFramesAfterALargeOne)
{
  // Large frames that are shown and merged take memory; else this would say nothing.
  const std::size_t shown = keptByNode(largeThenSmall(2, 0), false);
  EXPECT_GT(shown, 10 * floor_of_rule);
  EXPECT_GT(keptByNode(largeThenSmall(2, 0), true), shown + 10 * floor_of_rule);
  EXPECT_LT(keptByNode(largeThenSmall(2, 10), false), floor_of_rule);
  EXPECT_LT(keptByNode(largeThenSmall(1, 10), false), floor_of_rule);
  EXPECT_LT(keptByNode(largeThenSmall(2, 10), true), 2 * floor_of_rule);
}

TEST(CentralNodeMemoryUse, MergingThatRunsOutKeepsNone)
{
  CentralNode node(centralSettings());
  node.addStream("a");
  sendAndWait(node, "a", largeThenSmall(1, 0)[0]);
  const MemoryUse memory_use;
  std::size_t failures = 0;
  for (bool has_failed = true; has_failed; ++failures) {
    VoxelFrame merged;
    {
      const FailingAllocation failing(failures + 1);
      node.merge(merged);
      has_failed = failing.hasFailed();
    }
    if (has_failed) {
      EXPECT_LT(memory_use.live(), floor_of_rule) << "allocation " << failures + 1;
    }
  }
  EXPECT_GT(failures, 20u);
}

TEST(CentralNodeMemoryUse, AFrameThatFailsKeepsNone)
{
  std::vector<Bytes> frames = largeThenSmall(1, 1);
  // Wrong at its end, where the decoder has almost all of its voxels.
  Parts parts = takeApart(frames[0]);
  parts.payload[parts.payload.size() - 40] ^= 5;
  frames[0] = putTogether(parts);
  FrameDecoder decoder;
  VoxelFrame voxels;
  EXPECT_FALSE(decoder.decode(frames[0].data(), frames[0].size(), voxels).ok());
  EXPECT_GT(voxels.keys.capacity() * sizeof(voxels.keys[0]), 4 * floor_of_rule);
  EXPECT_LT(keptByNode(frames, false), floor_of_rule);
}

TEST(CentralNodeMemoryUse, OfAllStreamsIsWithinTheBudget)
{
  // A cube of few bytes, as anybody may send.
  constexpr std::size_t voxels = 100000;
  VoxelFrame cube = pcl_ext::io::test::emptyFrame(8);
  for (std::uint64_t key = 0; key < voxels; ++key)
    cube.keys.push_back(key);
  cube.intensities.assign(voxels, 1);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  const Bytes i_frame = pcl_ext::io::test::encoded(encoder, cube);
  const Bytes p_frame = pcl_ext::io::test::encoded(encoder, cube);
  ASSERT_LT(i_frame.size(), 1000u);

  constexpr std::size_t limit = 50'000'000;
  constexpr std::size_t streams = 40;
  CentralNodeSettings settings = centralSettings();
  settings.threads = 1;
  settings.max_merge_age = Time::max();
  settings.decoder_limits.budget = std::make_shared<pcl_ext::io::MemoryBudget>(limit);
  const MemoryUse memory_use;
  std::vector<std::string> requested;
  CentralNode node(settings, [&](const ReceivedFrame& frame) {
    if (frame.wants_i_frame)
      requested.push_back(frame.stream);
  });
  for (std::size_t i = 0; i < streams; ++i) {
    node.addStream(std::to_string(i));
    sendAndWait(node, std::to_string(i), i_frame);
  }
  EXPECT_LT(memory_use.live(), limit + pcl_ext::io::bytes_of_voxel * voxels);
  std::size_t drops = 0;
  for (const StreamHealth& health : node.health()) {
    drops += health.memory_drops;
    EXPECT_EQ(health.lacks_voxels, health.memory_drops > 0) << health.name;
  }
  EXPECT_GT(drops, 10u);
  EXPECT_LT(drops, streams);
  EXPECT_TRUE(latestVoxels(node, "0").keys.empty());
  EXPECT_EQ(latestVoxels(node, std::to_string(streams - 1)).size(), voxels);

  sendAndWait(node, std::to_string(streams - 1), p_frame);
  sendAndWait(node, "0", p_frame);
  EXPECT_EQ(requested, std::vector<std::string>{"0"});
  EXPECT_NE(node.health()[0].last_failure.message().find("the memory limit of 50 MB"),
            std::string::npos)
      << node.health()[0].last_failure;
  encoder.requestIFrame();
  sendAndWait(node, "0", pcl_ext::io::test::encoded(encoder, cube));
  sendAndWait(node, "0", pcl_ext::io::test::encoded(encoder, cube));
  EXPECT_TRUE(node.health()[0].in_sync);
  EXPECT_FALSE(node.health()[0].lacks_voxels);
  EXPECT_EQ(latestVoxels(node, "0").size(), voxels);
}

TEST(CentralNodeMemoryUse, FramesThatFollowAreShownRight)
{
  const std::vector<Bytes> frames = largeThenSmall(2, 14);
  CentralNodeSettings settings = centralSettings();
  settings.max_merge_age = Time::max();
  CentralNode node(settings);
  node.addStream("a");
  FrameDecoder decoder;
  for (const Bytes& bytes : frames) {
    sendAndWait(node, "a", bytes);
    VoxelFrame expected;
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), expected).ok());
    expectSameFrame(latestVoxels(node), expected);
    VoxelFrame merged;
    node.merge(merged);
    EXPECT_EQ(merged.size(), expected.size());
  }
}

} // namespace

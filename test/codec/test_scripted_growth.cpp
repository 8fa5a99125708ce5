// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/scripted_fast_stream.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

std::size_t
memoryToRefuse(FrameDecoder& decoder, const Bytes& bytes)
{
  VoxelFrame back;
  const MemoryUse memory_use;
  EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Corrupt);
  return memory_use.peak();
}

TEST(ScriptedGrowth, NodesThatAreMoreThanVoxels)
{
  constexpr unsigned int depth = 8;
  constexpr std::size_t voxels = 33000;
  Parts parts;
  parts.header.effort = Effort::Fast;
  parts.header.grid = emptyFrame(depth).grid;
  parts.header.frame_number = 1;
  parts.header.voxel_count = voxels;
  FastScript script;
  writeFullGrid(script, depth - 2);
  RansChoices choices;
  choices.states = 4;
  parts.payload = script.rans(choices).bytes;
  FrameDecoder decoder;
  // Nodes of two levels, with room to grow.
  EXPECT_LE(memoryToRefuse(decoder, putTogetherSized(parts)),
            (std::size_t{1} << 19) + 4 * voxels * sizeof(std::uint64_t));
}

TEST(ScriptedGrowth, NewBlocksBehindMoreTrackedVoxelsThanThereMayBe)
{
  constexpr unsigned int depth = 8;
  const ScriptedStream stream(depth, 0, 2, [](FastScript& script) {
    script.newVoxels(depth, {0, 1});
  });
  // Both tracked voxels are occupied; the header has one voxel.
  const Bytes forged = stream.pFrame(1, [](FastScript& script) {
    script.trackedVoxels(3, 2, 3);
    script.octants(false, 0);
    writeFullGrid(script, depth - 2);
  });
  FrameDecoder decoder;
  VoxelFrame back;
  ASSERT_EQ(decoded(decoder, stream.iFrame(), back), CompressionCode::Ok);
  EXPECT_LE(memoryToRefuse(decoder, forged), std::size_t{1} << 20);
}

TEST(ScriptedGrowth, NoBytesBehindMoreTrackedVoxelsThanThereMayBe)
{
  // The context coder reads nothing but ones: both tracked voxels, although the header
  // has one voxel, and then every block of the grid.
  for (const Effort effort : {Effort::Balanced, Effort::Small}) {
    VoxelFrame frame = emptyFrame(8);
    frame.keys = {0, 1};
    frame.intensities = {1, 1};
    FrameEncoder encoder(StreamFormat::Version1, 10, effort);
    const Bytes i_frame = encoded(encoder, frame);
    Parts parts = takeApart(encoded(encoder, frame));
    ASSERT_FALSE(parts.header.is_i_frame);
    parts.header.voxel_count = 1;
    parts.payload.clear();
    FrameDecoder decoder;
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
    EXPECT_LE(
        memoryToRefuse(decoder, putTogetherSized(parts, takeApart(i_frame).checksum)),
        std::size_t{1} << 20);
  }
}

/** \brief A scene that stays, and voxels that never come back, each in a block of its
 * own. */
VoxelFrame
movingFrame(std::uint64_t index)
{
  constexpr std::uint64_t staying = 48;
  constexpr std::uint64_t moving = 20;
  VoxelFrame frame = emptyFrame(18);
  for (std::uint64_t i = 0; i < staying; ++i)
    frame.keys.push_back(i << block_key_bits);
  for (std::uint64_t i = 0; i < moving; ++i)
    frame.keys.push_back((staying + index * moving + i) << block_key_bits);
  frame.intensities.assign(frame.size(), static_cast<std::uint16_t>(1 + index % 3));
  return frame;
}

TEST(MovingStreams, TakeNoMoreMemoryAsTheyGoOn)
{
  constexpr std::uint64_t warm = 100;
  constexpr std::uint64_t end = 600;
  for (const Effort effort : all_efforts) {
    FrameEncoder encoder(
        StreamFormat::Version1, std::numeric_limits<unsigned int>::max(), effort);
    FrameDecoder decoder;
    VoxelFrame back;
    Bytes bytes;
    std::size_t live = 0;
    const MemoryUse memory_use;
    for (std::uint64_t i = 0; i < end; ++i) {
      const VoxelFrame frame = movingFrame(i);
      if (i == warm)
        live = memory_use.live();
      ASSERT_TRUE(encoder.encode(frame, std::nullopt, bytes).ok());
      ASSERT_EQ(encoder.statistics().is_i_frame, i == 0);
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
      ASSERT_EQ(back.keys, frame.keys);
    }
    // The frames' own vectors differ by a little.
    EXPECT_LE(memory_use.live(), live + 4096);
  }
}

} // namespace

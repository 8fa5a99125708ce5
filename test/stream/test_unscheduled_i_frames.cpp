// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief When an encoder of version 1 sends an I-frame although none is due.
 */
#include "codec/payload_coder.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief A frame that shares some of its voxels with another one. */
VoxelFrame
sharing(std::mt19937_64& random,
        const VoxelFrame& other,
        std::size_t shared,
        std::size_t count)
{
  std::set<std::uint64_t> keys(
      other.keys.begin(), other.keys.begin() + static_cast<std::ptrdiff_t>(shared));
  const std::set<std::uint64_t> others(other.keys.begin(), other.keys.end());
  while (keys.size() < count) {
    const std::uint64_t key = below(random, std::uint64_t{1} << (3 * other.grid.depth));
    if (others.count(key) == 0)
      keys.insert(key);
  }
  VoxelFrame frame = other;
  setVoxels(random, keys, frame);
  return frame;
}

/** \brief Whether the second of two frames is an I-frame. */
bool
isSecondAnIFrame(const VoxelFrame& first, const VoxelFrame& second, Effort effort)
{
  FrameEncoder encoder(StreamFormat::Version1, 1000, effort);
  FrameDecoder decoder;
  VoxelFrame back;
  for (const VoxelFrame* frame : {&first, &second}) {
    EXPECT_EQ(decoded(decoder, encoded(encoder, *frame), back), CompressionCode::Ok);
    expectSameFrame(back, *frame);
    EXPECT_EQ(decoder.statistics().is_i_frame, encoder.statistics().is_i_frame);
  }
  return encoder.statistics().is_i_frame;
}

TEST(UnscheduledIFrames, AreSentWhenTheHistoryIsTooLarge)
{
  // A sensor that sees much, then almost nothing: its history is as large as before,
  // and costs time for nothing.
  std::mt19937_64 random(2);
  const auto isIFrameAfter = [&](std::size_t records, std::size_t voxels) {
    const VoxelFrame first = randomFrame(random, 8, records);
    return isSecondAnIFrame(
        first, sharing(random, first, voxels, voxels), Effort::Balanced);
  };
  const std::size_t few = 100;
  EXPECT_FALSE(isIFrameAfter(maxTracked(few), few));
  EXPECT_TRUE(isIFrameAfter(maxTracked(few) + 1, few));
  EXPECT_FALSE(isIFrameAfter(maxTracked(0), 0));
  EXPECT_TRUE(isIFrameAfter(maxTracked(0) + 1, 0));
}

TEST(UnscheduledIFrames, DecodersWithTheSameLimitAcceptEveryFrame)
{
  // Voxels that wander as fast as they can without an I-frame.
  DecoderLimits limits;
  limits.max_voxels = 5000;
  for (const Effort effort : all_efforts) {
    std::mt19937_64 random(3);
    FrameEncoder encoder(StreamFormat::Version1, 1000, effort);
    FrameDecoder decoder(limits);
    VoxelFrame back;
    VoxelFrame frame = randomFrame(random, 12, limits.max_voxels);
    for (int i = 0; i < 25; ++i) {
      ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
      ASSERT_EQ(back.keys, frame.keys);
      ASSERT_EQ(encoder.statistics().is_i_frame, i == 0);
      frame = sharing(random, frame, limits.max_voxels / 2, limits.max_voxels);
    }
  }
}
} // namespace

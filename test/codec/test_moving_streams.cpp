// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What streams remember stays as large as what they see, however long they run.
 */
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

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

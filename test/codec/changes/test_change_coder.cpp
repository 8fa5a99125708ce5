// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "codec/changes/change_coder.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr unsigned int first_depth = 2;
constexpr unsigned int first_bits = 9;

VoxelFrame
frameOfSymbols(const std::vector<std::uint64_t>& keys,
               const std::vector<std::uint16_t>& symbols)
{
  VoxelFrame frame = emptyFrame(first_depth, first_bits);
  frame.keys = keys;
  frame.intensities = symbols;
  return frame;
}

const VoxelFrame first = frameOfSymbols({1, 3, 4}, {200, 100, 50});

/** \brief Codes the change from the first frame to another one.
 * \param[in] count, grid_depth, symbol_bits as the header says
 * \return whether the decoder takes the payload
 */
bool
isTaken(const VoxelFrame& next,
        std::size_t count,
        unsigned int grid_depth = first_depth,
        unsigned int symbol_bits = first_bits)
{
  CodingWorkspace memory;
  changes::ChangeCoder encoder;
  encoder.prepare(first);
  encoder.learnWhole(true);
  encoder.countChanges(memory, next);
  Bytes payload;
  encoder.encode(memory, next, payload);

  changes::ChangeCoder decoder;
  decoder.prepare(first);
  decoder.learnWhole(true);
  VoxelFrame back = emptyFrame(grid_depth, symbol_bits);
  const bool is_taken = decoder.decode(
      memory, {payload.data(), payload.data() + payload.size(), count, false}, back);
  if (is_taken) {
    decoder.listVoxels(memory, back);
    EXPECT_EQ(back.keys, next.keys);
    EXPECT_EQ(back.intensities, next.intensities);
  }
  return is_taken;
}

TEST(ChangeCoder, TakesAsManyVoxelsAsTheHeaderSays)
{
  const VoxelFrame next = frameOfSymbols({1, 4, 6}, {200, 51, 7});
  EXPECT_TRUE(isTaken(next, 3));
  EXPECT_FALSE(isTaken(next, 2));
  EXPECT_FALSE(isTaken(next, 4));
}

TEST(ChangeCoder, RefusesVoxelsOutsideOfTheGrid)
{
  const VoxelFrame next = frameOfSymbols({1, 3, 4, 9}, {200, 100, 50, 1});
  EXPECT_TRUE(isTaken(next, 4));
  EXPECT_FALSE(isTaken(next, 4, first_depth - 1));
}

TEST(ChangeCoder, RefusesSymbolsBeyondTheScale)
{
  EXPECT_TRUE(isTaken(frameOfSymbols({1, 3, 4}, {255, 100, 50}), 3, first_depth, 8));
  const VoxelFrame above = frameOfSymbols({1, 3, 4}, {256, 100, 50});
  EXPECT_TRUE(isTaken(above, 3));
  EXPECT_FALSE(isTaken(above, 3, first_depth, 8));
}

} // namespace

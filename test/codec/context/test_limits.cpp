// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Ends of the numbers that history, mixing and expectations have, which streams
 * hardly reach.
 */
#include "codec/context/bit_mixer.h"
#include "codec/context/history.h"
#include "codec/context/local_expectation.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using pcl_ext::io::test::below;

TEST(ContextHistory, ForgetsVoxelsBelowTheThreshold)
{
  // A voxel comes and goes at random until its probability is 1000 or 999, which golden
  // streams do not reach.
  std::mt19937_64 random(7);
  BlockList with;
  with.assign({7});
  const BlockList without;
  std::map<std::uint32_t, int> seen;
  for (int stream = 0; stream < 20000; ++stream) {
    History history;
    history.clear(8);
    history.update(with, {5}, nullptr, false);
    std::uint32_t probability = 26000;
    for (int age = 0; age < 60 && probability >= 1000; ++age) {
      const unsigned int shift = age < 2 ? 1 : age < 5 ? 2 : age < 10 ? 3 : 4;
      if (below(random, 8) == 0) {
        probability += (65535 - probability) >> shift;
        history.update(with, {5}, nullptr, false);
      }
      else {
        probability -= probability >> shift;
        history.update(without, {}, nullptr, false);
      }
      ASSERT_EQ(history.recordCount(), probability >= 1000 ? 1u : 0u);
      ++seen[probability];
    }
  }
  EXPECT_GT(seen[1000], 0);
  EXPECT_GT(seen[999], 0);
}

TEST(BitMixer, WeightsStayWithinEight)
{
  constexpr std::int32_t heaviest = 8 << 16;
  const std::array<std::int32_t, 2> stretched{2047, -2047};
  std::array<std::int32_t, 2> weights{};
  for (int i = 0; i < 1000; ++i)
    adaptWeights(weights.data(), stretched, 65000);
  EXPECT_EQ(weights[0], heaviest);
  EXPECT_EQ(weights[1], -heaviest);
  for (int i = 0; i < 1000; ++i)
    adaptWeights(weights.data(), stretched, -65000);
  EXPECT_EQ(weights[0], -heaviest);
  EXPECT_EQ(weights[1], heaviest);
  EXPECT_EQ(mix(weights.data(), stretched), -2 * 8 * 2047);
}

TEST(BitMixer, MixedNumbersAreHeldWithinTheTable)
{
  const LogisticTables& tables = logisticTables();
  EXPECT_EQ(tables.squash(2048), tables.squash(2047));
  EXPECT_EQ(tables.squash(-16 * 2047), tables.squash(-2047));
  EXPECT_EQ(tables.squash(2047) + tables.squash(-2047), 1 << 16);
  EXPECT_GT(tables.squash(-2047), 0);
}

TEST(LocalExpectation, LogarithmsOfAllSymbols)
{
  int before = LocalExpectation::least - 1;
  for (std::uint32_t sixteenths = 0; sixteenths <= 16 * 0xffff; ++sixteenths) {
    const int logarithm = logarithmOf(sixteenths + 8);
    ASSERT_GE(logarithm, before);
    ASSERT_LE(numberOf(logarithm), sixteenths + 8);
    // Logarithms are rounded down by less than 1/64 octave.
    ASSERT_GE(numberOf(logarithm) + (sixteenths + 8) / 64 + 1, sixteenths + 8);
    before = logarithm;
  }
}

/** \brief Learns frames of one block's voxels, and returns the last expectations. */
std::vector<std::uint32_t>
expectationsOf(std::uint64_t mask,
               const std::function<std::uint32_t(unsigned int cell, int frame)>& symbol)
{
  BlockList blocks;
  blocks.append(0, mask, 0);
  FrameDirectory directory;
  IntensityNeighbours neighbours(blocks, 0, directory);
  neighbours.begin();
  neighbours.moveTo(0);
  LocalModels models;
  std::vector<std::uint32_t> last;
  for (int frame = 0; frame < 300; ++frame) {
    LocalExpectation local(models, directory.smoothed, blocks.voxelCount());
    last.clear();
    for (unsigned int cell = 0; cell < block_cells; ++cell) {
      if ((mask >> cell & 1) == 0)
        continue;
      local.expect(neighbours, cell);
      local.learn(last.size(), symbol(cell, frame), 0, false);
      last.push_back(local.sixteenths());
    }
  }
  return last;
}

TEST(LocalExpectation, AVoxelThatSharesTheSurfaceHasFewerPoints)
{
  // A plane at z = 0, of which each voxel in one octant shares its points with one at
  // z = 1.
  const auto isShared = [](unsigned int cell) { return cell < 8; };
  std::uint64_t mask = 0;
  for (unsigned int cell = 0; cell < block_cells; ++cell)
    if ((cell & 9) == 0 || (isShared(cell) && (cell & 1) != 0))
      mask |= std::uint64_t{1} << cell;
  const std::vector<std::uint32_t> expected = expectationsOf(
      mask, [&](unsigned int cell, int) { return isShared(cell) ? 20u : 40u; });
  std::size_t voxel = 0;
  for (unsigned int cell = 0; cell < block_cells; ++cell)
    if ((mask >> cell & 1) != 0) {
      const double symbol = isShared(cell) ? 20 : 40;
      EXPECT_NEAR(expected[voxel++] / 16.0, symbol, 0.3 * symbol) << cell;
    }
}

TEST(LocalExpectation, ExtremeSymbolsStayInRange)
{
  const std::vector<std::uint32_t> expected =
      expectationsOf(~std::uint64_t{0}, [](unsigned int cell, int frame) {
        return (cell ^ static_cast<unsigned int>(frame / 40)) % 2 == 0 ? 0u : 0xffffu;
      });
  EXPECT_LT(*std::max_element(expected.begin(), expected.end()), 2u << 20);
}

} // namespace

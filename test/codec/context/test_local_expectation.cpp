// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/local_expectation.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;

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

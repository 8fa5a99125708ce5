// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>

#include "outliers/block_neighbours.h"
#include "outliers/density_blocks.h"
#include "outliers/voxel_densities.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>

namespace {

using namespace pcl_ext;

TEST(DensityBlocks, FullSurroundingsDoNotOverflow)
{
  DensityBlocks blocks;
  for (int frame = 0; frame < 100; ++frame) {
    blocks.age();
    for (std::uint32_t x = 96; x < 108; ++x)
      for (std::uint32_t y = 96; y < 108; ++y)
        for (std::uint32_t z = 96; z < 108; ++z)
          blocks.add(blocks.blockAt(DensityBlocks::blockKey(x, y, z)),
                     DensityBlocks::cell(x, y, z),
                     255);
  }
  DensityWindow window;
  std::array<NeighbourhoodSums, 64> sums;
  const std::uint32_t middle = blocks.blockAt(DensityBlocks::blockKey(100, 100, 100));
  blocks.collect(middle, ~std::uint64_t{0}, window);
  sumNeighbourhoods<true>(window, ~std::uint64_t{0}, sums);
  for (const NeighbourhoodSums& sum : sums) {
    EXPECT_EQ(sum.core, 8 * 4 * 255);
    EXPECT_EQ(sum.ring, 20 * 4 * 255);
    EXPECT_EQ(sum.rim, 98 * 4 * 255);
    EXPECT_EQ(sum.all, 125 * 4 * 255);
    EXPECT_EQ(sum.occupied, 125);
  }
}

int
densityOf(const VoxelDensities& densities,
          unsigned int symbol,
          const io::VoxelPosition& at)
{
  io::VoxelFrame frame;
  frame.intensities = {static_cast<std::uint16_t>(symbol)};
  return densities.density(densities(frame, 0, at));
}

TEST(VoxelDensities, APointAtTheSensorOrBehindItCoversAFace)
{
  io::VoxelFrame frame;
  frame.grid.resolution = 0.04;
  frame.grid.depth = 9;
  frame.intensity_scale.bits = 8;
  frame.depth_model = io::depthModelOf({2, 15.0, 255.0},
                                       {0.5, 0.0, 0.0},
                                       {1.0, 0.0, 0.0},
                                       frame.grid,
                                       frame.intensity_scale);
  ASSERT_TRUE(frame.depth_model);
  VoxelDensities densities{AutomaticUnit()};
  densities.follow(frame, {0, 0, 0}, 0);
  for (std::uint32_t x = 0; x < 14; ++x)
    EXPECT_EQ(densityOf(densities, 1, {x, 3, 4}), 255) << x;
}

TEST(VoxelDensities, AreAtLeastOneAndAtMostAFace)
{
  io::VoxelFrame frame;
  frame.intensity_scale = {0.0f, 1.0f, 16};
  VoxelDensities points{PointsUnit()};
  EXPECT_TRUE(points.follow(frame, {0, 0, 0}, 0));
  EXPECT_EQ(densityOf(points, 0, {0, 0, 0}), 1);
  EXPECT_EQ(densityOf(points, 7, {0, 0, 0}), 7);
  EXPECT_EQ(densityOf(points, 65535, {0, 0, 0}), 255);
  // Another scale, of shares up to 2.
  frame.intensity_scale = {-1.0f, 2.0f, 8};
  VoxelDensities faces(FacesUnit{{}, 100.0f});
  EXPECT_TRUE(faces.follow(frame, {0, 0, 0}, 0));
  EXPECT_EQ(densityOf(faces, 0, {0, 0, 0}), 1);
  EXPECT_EQ(densityOf(faces, 20, {0, 0, 0}), 99); // 39 of 100
  EXPECT_EQ(densityOf(faces, 200, {0, 0, 0}), 255);
  // Nonsense for a face does no harm.
  for (const float nonsense : {0.0f, -1.0f, std::nanf("")}) {
    VoxelDensities none(FacesUnit{{}, nonsense});
    none.follow(frame, {0, 0, 0}, 0);
    for (std::uint16_t symbol = 0; symbol < 256; ++symbol) {
      EXPECT_GE(densityOf(none, symbol, {0, 0, 0}), 1);
      EXPECT_LE(densityOf(none, symbol, {0, 0, 0}), 255);
    }
  }
}

/** \brief The voxels of a set around a voxel, one by one. */
unsigned int
countOneByOne(const std::set<std::uint64_t>& keys, std::uint64_t key, std::int64_t size)
{
  const io::VoxelPosition at = io::voxelPosition(key);
  unsigned int count = 0;
  for (std::int64_t x = -1; x <= 1; ++x)
    for (std::int64_t y = -1; y <= 1; ++y)
      for (std::int64_t z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0)
          continue;
        const std::int64_t other[] = {at.x + x, at.y + y, at.z + z};
        if (std::all_of(std::begin(other), std::end(other), [&](std::int64_t i) {
              return i >= 0 && i < size;
            }))
          count += static_cast<unsigned int>(
              keys.count(io::mortonKey({static_cast<std::uint32_t>(other[0]),
                                        static_cast<std::uint32_t>(other[1]),
                                        static_cast<std::uint32_t>(other[2])})));
      }
  return count;
}

TEST(BlockNeighbours, AreTheTwentySixVoxelsAround)
{
  std::mt19937_64 random(1);
  for (const unsigned int depth : {1u, 2u, 3u, 4u}) {
    const std::uint64_t end = std::uint64_t{1} << 3 * depth;
    std::set<std::uint64_t> keys;
    for (std::uint64_t i = 0; i < end / 2; ++i)
      keys.insert(random() % end);
    BlockNeighbours neighbours;
    neighbours.assign({keys.begin(), keys.end()});
    for (std::uint64_t key = 0; key < end; ++key) {
      const unsigned int count = countOneByOne(keys, key, std::int64_t{1} << depth);
      EXPECT_EQ(neighbours.count(key), count) << depth << ' ' << key;
      for (unsigned int enough = 1; enough <= 26; ++enough)
        EXPECT_EQ(neighbours.count(key, enough) >= enough, count >= enough);
    }
  }
}

} // namespace

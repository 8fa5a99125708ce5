// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>

#include "outliers/block_neighbours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext;

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
    neighbours.assign({keys.begin(), keys.end()}, depth);
    for (std::uint64_t key = 0; key < end; ++key) {
      const unsigned int count = countOneByOne(keys, key, std::int64_t{1} << depth);
      EXPECT_EQ(neighbours.count(key), count) << depth << ' ' << key;
      for (unsigned int enough = 1; enough <= 26; ++enough)
        EXPECT_EQ(neighbours.count(key, enough) >= enough, count >= enough);
    }
  }
}

} // namespace

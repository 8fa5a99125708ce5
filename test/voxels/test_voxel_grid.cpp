// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>

#include "support/voxel_frames.h"

#include <pcl/octree/octree_key.h>

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

TEST(MortonKey, ComesBack)
{
  constexpr std::uint32_t last = (1u << max_grid_depth) - 1;
  std::mt19937_64 random(4);
  std::vector<VoxelPosition> positions;
  for (const std::uint32_t x : {0u, 1u, last})
    for (const std::uint32_t y : {0u, 1u, last})
      for (const std::uint32_t z : {0u, 1u, last})
        positions.push_back({x, y, z});
  for (int i = 0; i < 1000; ++i)
    positions.push_back({static_cast<std::uint32_t>(below(random, last)),
                         static_cast<std::uint32_t>(below(random, last)),
                         static_cast<std::uint32_t>(below(random, last))});
  for (const VoxelPosition& position : positions) {
    const VoxelPosition back = voxelPosition(mortonKey(position));
    EXPECT_EQ(back.x, position.x);
    EXPECT_EQ(back.y, position.y);
    EXPECT_EQ(back.z, position.z);
    EXPECT_LT(mortonKey(position), std::uint64_t{1} << 63);
  }
  EXPECT_EQ(mortonKey({last, last, last}), (std::uint64_t{1} << 63) - 1);
  static_assert(mortonKey({1, 0, 0}) == 4 && mortonKey({0, 1, 0}) == 2 &&
                    mortonKey({0, 0, 1}) == 1,
                "x is the highest of three bits");
}

TEST(MortonKey, ThreeBitsAreThePclChildIndex)
{
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const std::uint64_t key = below(random, std::uint64_t{1} << 63);
    const VoxelPosition position = voxelPosition(key);
    const pcl::octree::OctreeKey pcl_key(position.x, position.y, position.z);
    for (unsigned int level = 0; level < max_grid_depth; ++level)
      EXPECT_EQ(pcl_key.getChildIdxWithDepthMask(1u << level), key >> 3 * level & 7);
  }
}

TEST(VoxelGrid, NeedsDoublesBeyondTheLatticeOfTheWorldsOrigin)
{
  constexpr std::int32_t end = 1 << (max_grid_depth - 1);
  for (const double resolution : {1e-6, 0.001, 0.04, 1e6}) {
    EXPECT_FALSE(
        (VoxelGrid{resolution, {}, {-end, -end, -end}, max_grid_depth}).needsDoubles());
    // Centred on the multiples of the edge, as voxels of whole millimetres are.
    const double half = resolution / 2.0;
    EXPECT_FALSE(
        (VoxelGrid{
             resolution, {-half, -half, -half}, {-end, -end, -end}, max_grid_depth})
            .needsDoubles());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      VoxelGrid grid{resolution, {}, {0, 0, 0}, 3};
      EXPECT_FALSE(grid.needsDoubles());
      grid.origin[axis] = end * resolution;
      EXPECT_TRUE(grid.needsDoubles());
      grid.origin[axis] = -(end + 1) * resolution;
      EXPECT_TRUE(grid.needsDoubles());
    }
  }
}

} // namespace

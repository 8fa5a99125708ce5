// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxel_grid.h>

#include "support/voxel_frames.h"
#include "support/voxelized_stream.h"
#include "voxels/grid_fit.h"

#include <pcl/octree/octree_key.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <set>
#include <string>
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

TEST(GridFit, HoldsTheRangeInItsMiddle)
{
  std::mt19937_64 random(11);
  for (int i = 0; i < 2000; ++i) {
    LatticeRange range;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t extent = std::int64_t{1} << random() % 21;
      const std::int64_t lowest =
          static_cast<std::int64_t>(random() % (2 * lattice_end)) - lattice_end;
      range.lowest[axis] = static_cast<std::int32_t>(lowest);
      range.highest[axis] =
          static_cast<std::int32_t>(std::min(lowest + extent, lattice_end - 1));
    }
    VoxelGrid lattice;
    lattice.resolution = 0.5;
    const VoxelGrid grid = fitGrid(lattice, range);
    EXPECT_FALSE(leavesLattice(grid));
    EXPECT_TRUE(containsRange(grid, range));
    std::int64_t widest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t below = range.lowest[axis] - grid.first_index[axis];
      const std::int64_t above =
          grid.first_index[axis] + grid.size() - 1 - range.highest[axis];
      widest =
          std::max<std::int64_t>(widest, range.highest[axis] - range.lowest[axis] + 1);
      const bool at_end = grid.first_index[axis] == -lattice_end ||
                          grid.first_index[axis] + grid.size() == lattice_end;
      EXPECT_TRUE(at_end || std::abs(below - above) <= 1);
    }
    EXPECT_GE(grid.size(), widest);
    EXPECT_TRUE(grid.depth == 1 || grid.size() < 2 * widest) << "a level too many";
  }
}

VoxelFrame
randomFrame(std::uint64_t seed, unsigned int depth, std::size_t voxels)
{
  std::mt19937_64 random(seed);
  const std::uint64_t key_end = std::uint64_t{1} << (3 * depth);
  std::set<std::uint64_t> keys{0, key_end - 1};
  for (std::size_t i = 0; i < voxels; ++i)
    keys.insert(random() % key_end);
  VoxelFrame frame;
  frame.grid.resolution = static_cast<double>(uniform(random, 0.001, 1.0));
  frame.grid.depth = depth;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    frame.grid.first_index[axis] =
        static_cast<std::int32_t>(random() % 2000000) - 1000000;
    frame.grid.origin[axis] = static_cast<double>(uniform(random, -3.0, 3.0));
  }
  frame.keys.assign(keys.begin(), keys.end());
  for (std::size_t i = 0; i < frame.keys.size(); ++i)
    frame.intensities.push_back(static_cast<std::uint16_t>(random()));
  return frame;
}

/** \brief Expects the centres of a random frame, to the last bit. */
void
expectCentres(unsigned int depth, std::size_t voxels, const IntensityScale& scale)
{
  SCOPED_TRACE(std::to_string(depth) + ", " + std::to_string(voxels) + ", " +
               std::to_string(scale.bits));
  VoxelFrame frame = randomFrame(depth * 1000 + voxels, depth, voxels);
  frame.intensity_scale = scale;
  for (std::uint16_t& symbol : frame.intensities)
    symbol &= static_cast<std::uint16_t>(scale.maxSymbol());
  if (!frame.hasIntensities())
    frame.intensities.clear();
  ASSERT_TRUE(isConsistent(frame));
  std::size_t next = 0;
  forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    ASSERT_LT(next, frame.size());
    ASSERT_EQ((std::array<float, 3>{x, y, z}), centreOf(frame, next));
    ASSERT_TRUE(std::isfinite(intensity));
    ASSERT_EQ(intensity,
              frame.hasIntensities() ? scale.value(frame.intensities[next]) : 0.0f);
    ++next;
  });
  EXPECT_EQ(next, frame.size());
}

// Frames with at least three voxels for each position along an axis are looked up in
// tables, in grids of up to nine levels.
TEST(VoxelCentres, AreThoseOfTheGridAndTheScale)
{
  for (unsigned int depth = 1; depth <= max_grid_depth; ++depth)
    for (const std::size_t voxels : {0u, 1u, 61u, 62u, 63u, 64u, 500u})
      expectCentres(depth, voxels, {-7.25f, 0.3f, 16});
  for (unsigned int depth = 1; depth <= 11; ++depth)
    for (const unsigned int bits : {0u, 1u, 6u, 8u, 9u})
      for (const std::size_t voxels : {100u, 7000u})
        expectCentres(depth, voxels, {9.7f, 1.3f, bits});
}

TEST(VoxelCentres, IntensitiesAreThoseOfCompandedLevelsAndWithinTheFloats)
{
  for (const IntensityScale& scale :
       std::vector<IntensityScale>{{-7.5f, 0.25f, 1, 40000},
                                   {1.0f, 1.0f, 4, 254},
                                   {0.5f, 2.0f, 4, 300},
                                   {0.5f, 2.0f, 8, 300},
                                   {-largest, largest / 100.0f, 8, 40000},
                                   {-largest, largest / 100.0f, 8},
                                   {-largest, largest / 100.0f, 16},
                                   {0.0f, 1.0f, 9, 40000},
                                   {-7.5f, 0.25f, 15, 65535}})
    for (const std::size_t voxels : {100u, 1000u}) // fewer than symbols, or more
      expectCentres(5, voxels, scale);
}

} // namespace

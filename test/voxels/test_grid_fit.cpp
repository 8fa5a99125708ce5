// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxels/grid_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>

namespace {

using namespace pcl_ext::io;

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

} // namespace

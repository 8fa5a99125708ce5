// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/density_blocks.h"
#include "outliers/voxel_densities.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>

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

/** \brief Density of a cell of one voxel. */
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

} // namespace

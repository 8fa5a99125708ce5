// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/outlier_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace {

using namespace pcl_ext;

constexpr double cell_edge = 0.02;

/** \brief The same points in voxels of half the edge, in as many of them as there can
 * be. */
Voxels
halved(const Voxels& voxels, std::mt19937_64& random)
{
  Voxels fine;
  for (const auto& [index, points] : voxels) {
    auto part = static_cast<std::int64_t>(random() % 8);
    for (int i = 0; i < points; ++i) {
      ++fine[{2 * index[0] + (part & 1),
              2 * index[1] + (part >> 1 & 1),
              2 * index[2] + (part >> 2)}];
      part = (part + 3) % 8;
    }
  }
  return fine;
}

io::VoxelFrame
frameAt(double edge, const Voxels& voxels, const io::VoxelGrid& grid)
{
  io::VoxelFrame frame = frameOf(voxels, grid);
  frame.grid.resolution = edge;
  return frame;
}

void
expectThoseOfCells(const Scores& scores, const Scores& cells)
{
  ASSERT_GE(scores.size(), cells.size());
  for (const auto& [index, score] : scores) {
    LatticeIndex cell = index;
    for (std::int64_t& coordinate : cell)
      coordinate = coordinate >= 0 ? coordinate / 2 : (coordinate - 1) / 2;
    ASSERT_EQ(score, cells.at(cell));
  }
}

TEST(VoxelOutlierRemovalUnits, FineVoxelsHaveTheScoresOfTheirCells)
{
  for (const DensityUnit unit : {DensityUnit::Points, DensityUnit::Voxels}) {
    VoxelOutlierRemoval coarse(settingsOf(unit));
    VoxelOutlierRemoval fine(settingsOf(unit));
    std::mt19937_64 random(21);
    for (std::int32_t i = 0; i < 5; ++i) {
      Voxels voxels = wall(random, 15);
      for (auto& [index, points] : voxels)
        points = static_cast<std::uint16_t>(1 + points / 20);
      // Grids that begin within a cell, too, and below zero.
      const io::VoxelGrid grid = gridAt(7 - 3 * i, -5 * i, i - 1, 8);
      expectThoseOfCells(
          scoresOf(fine, frameAt(cell_edge / 2.0, halved(voxels, random), grid)),
          scoresOf(coarse, frameAt(cell_edge, voxels, gridAt(0, 0, 0))));
    }
  }
}

TEST(VoxelOutlierRemovalUnits, FineFacesHaveTheScoresOfTheirCells)
{
  // A camera at the origin that looks along x; a point fills a voxel of 1 cm from
  // 3.64 m on, and one of 2 cm from 7.29 m on.
  const auto frameOfPoints = [](double edge,
                                const Voxels& points,
                                double cut_off_depth) {
    Voxels shares;
    for (const auto& [index, number] : points) {
      const double depth = (static_cast<double>(index[0]) + 0.5) * edge / cut_off_depth;
      shares[index] = static_cast<std::uint16_t>(std::min(
          65535.0, std::round(65535.0 * number * std::min(1.0, depth * depth))));
    }
    io::VoxelGrid grid = gridAt(0, 0, 0, 10);
    grid.resolution = edge;
    io::VoxelFrame frame = frameOf(shares, grid, {0.0f, 255.0f / 65535.0f, 16});
    frame.depth_model = io::depthModelOf({2, cut_off_depth, 255.0},
                                         {},
                                         {1.0, 0.0, 0.0},
                                         frame.grid,
                                         frame.intensity_scale);
    EXPECT_TRUE(frame.depth_model);
    return frame;
  };
  std::mt19937_64 random(22);
  for (const std::int32_t place : {60, 150, 300}) { // 1.2, 3 and 6 m
    Voxels points = wall(random, place);
    for (auto& [index, number] : points)
      number = static_cast<std::uint16_t>(1 + number / 100);
    const Voxels fine_points = halved(points, random);
    VoxelOutlierRemoval coarse;
    VoxelOutlierRemoval fine;
    const Scores cells = scoresOf(coarse, frameOfPoints(cell_edge, points, 7.286));
    const Scores scores =
        scoresOf(fine, frameOfPoints(cell_edge / 2.0, fine_points, 3.643));
    for (const auto& [index, score] : scores)
      // But for the depth, which is that of voxels in one and of cells in the other.
      ASSERT_NEAR(score, cells.at({index[0] / 2, index[1] / 2, index[2] / 2}), 0.25f);
  }
}

TEST(VoxelOutlierRemovalUnits, NumbersOfPointsAreUsedWithoutIntensities)
{
  std::mt19937_64 random(23);
  VoxelOutlierRemoval on_counts(settingsOf(DensityUnit::Points));
  VoxelOutlierRemoval on_numbers(settingsOf(DensityUnit::Points));
  for (int i = 0; i < 4; ++i) {
    const io::VoxelFrame counts = frameOf(wall(random, 15), gridAt(0, 0, 0));
    io::VoxelFrame frame = counts;
    frame.intensity_scale.bits = 0;
    frame.intensities.clear();
    frame.has_point_counts = true;
    frame.point_counts.assign(counts.intensities.begin(), counts.intensities.end());
    ASSERT_TRUE(io::isConsistent(frame));
    expectSame(scoresOf(on_numbers, frame), scoresOf(on_counts, counts), 0.0f);
  }
}

TEST(VoxelOutlierRemovalUnits, IntensitiesOfUnknownMeaningAreNotUsed)
{
  std::mt19937_64 random(24);
  VoxelOutlierRemoval automatic;
  VoxelOutlierRemoval other;
  VoxelOutlierRemoval without;
  for (int i = 0; i < 4; ++i) {
    const io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
    io::VoxelFrame bright = frame;
    for (std::uint16_t& symbol : bright.intensities)
      symbol = static_cast<std::uint16_t>(random() % 256);
    io::VoxelFrame none = frame;
    none.intensity_scale.bits = 0;
    none.intensities.clear();
    const Scores scores = scoresOf(automatic, frame);
    expectSame(scoresOf(other, bright), scores, 0.0f);
    expectSame(scoresOf(without, none), scores, 0.0f);
  }
}

/** \brief Rings of a lidar on a wall, whose voxels do not touch those of the next ring,
 * and an echo between them that is elsewhere each time. */
Voxels
ringsAndEcho(std::int64_t frame, const LatticeIndex& echo)
{
  Voxels voxels;
  for (std::int64_t z = 10; z < 100; z += 9)
    for (std::int64_t y = 20; y < 80; ++y)
      if ((y + frame + z) % 4 != 0) // a part of the rays has no return
        voxels[{30, y, z}] = 10;
  voxels[echo] = 10;
  return voxels;
}

TEST(VoxelOutlierRemovalUnits, VoxelsThatStayAreSurfacesOfALidar)
{
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Voxels));
  for (std::int64_t frame = 0; frame < 12; ++frame) {
    const LatticeIndex echo = {20 - frame, 30, 23 + 4 * frame};
    const Scores scores =
        scoresOf(removal, frameOf(ringsAndEcho(frame, echo), gridAt(0, 0, 0)));
    if (frame < 4)
      continue;
    for (const auto& [index, score] : scores)
      EXPECT_EQ(score < 0.0f, index == echo) << score;
  }
}

TEST(VoxelOutlierRemovalUnits, AMovingLidarLosesNothing)
{
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Voxels));
  for (std::int64_t frame = 0; frame < 6; ++frame) {
    Voxels moved;
    for (const auto& [index, symbol] : ringsAndEcho(frame, {20, 30, 23}))
      moved[{index[0] + 7 * frame, index[1], index[2]}] = symbol;
    for (const auto& [index, score] :
         scoresOf(removal, frameOf(moved, gridAt(0, 0, 0))))
      if (index[0] == 30 + 7 * frame) {
        EXPECT_GE(score, 0.0f);
      }
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/outlier_frames.h"
#include "support/test_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using pcl_ext::test::MemoryUse;

io::VoxelFrame
withDepthModel(io::VoxelFrame frame)
{
  frame.depth_model = io::depthModelOf(
      {2, 15.0, 255.0}, {}, {0.6, 0.0, 0.8}, frame.grid, frame.intensity_scale);
  EXPECT_TRUE(frame.depth_model);
  return frame;
}

/** \brief Scores of the second of two frames. */
Scores
scoresBehind(const io::VoxelFrame& first,
             const io::VoxelFrame& second,
             const VoxelOutlierRemovalSettings& settings = {})
{
  VoxelOutlierRemoval removal(settings);
  scoresOf(removal, first);
  return scoresOf(removal, second);
}

Scores
scoresAlone(const io::VoxelFrame& frame,
            const VoxelOutlierRemovalSettings& settings = {})
{
  VoxelOutlierRemoval removal(settings);
  return scoresOf(removal, frame);
}

TEST(VoxelOutlierRemoval, DepthModelStaysWhereTheGridMoves)
{
  std::mt19937_64 random(12);
  const io::VoxelFrame first =
      withDepthModel(frameOf(wall(random, 15), gridAt(0, 0, 0)));
  const Voxels voxels = wall(random, 15);
  // The same voxels of the world, in frames without a model.
  const Scores expected = scoresBehind(first, frameOf(voxels, gridAt(0, 0, 0)));
  for (const io::VoxelGrid& grid :
       {gridAt(-100, 10, -700, 10), gridAt(10, 10, 10, 6), gridAt(3, 0, 1, 20)})
    expectSame(scoresBehind(first, frameOf(voxels, grid)), expected, 0.0f);
  // And in one whose intensities have half the step.
  io::VoxelFrame finer = frameOf(voxels, gridAt(0, 0, 0));
  finer.intensity_scale = {0.0f, 0.5f, 16};
  for (std::uint16_t& symbol : finer.intensities)
    symbol = static_cast<std::uint16_t>(2 * symbol);
  expectSame(scoresBehind(first, finer), expected, 0.0f);
}

TEST(VoxelOutlierRemoval, DepthModelMayChangeItsLaw)
{
  std::mt19937_64 random(16);
  const io::VoxelFrame quadratic =
      withDepthModel(frameOf(wall(random, 15), gridAt(0, 0, 0)));
  io::VoxelFrame linear = quadratic;
  linear.depth_model->exponent = 1;
  expectSame(scoresBehind(quadratic, linear), scoresAlone(linear), 0.0f);
  EXPECT_NE(scoresAlone(quadratic), scoresAlone(linear));
}

TEST(VoxelOutlierRemoval, OtherLatticesAndUnitsForgetHistoryAndDepthModel)
{
  std::mt19937_64 random(13);
  const io::VoxelFrame before = frameOf(wall(random, 15), gridAt(0, 0, 0));
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  // Below a full face near the sensor.
  for (std::uint16_t& symbol : frame.intensities)
    symbol = static_cast<std::uint16_t>(symbol / 16);
  io::VoxelFrame finer = frame;
  finer.grid.resolution = 0.02;
  io::VoxelFrame elsewhere = frame;
  elsewhere.grid.origin[2] = -0.01;
  io::VoxelFrame far_away = frame;
  far_away.grid.first_index[1] = std::numeric_limits<std::int32_t>::max();
  const auto expectForgotten =
      [](const io::VoxelFrame& first, const io::VoxelFrame& second, DensityUnit unit) {
        expectSame(scoresBehind(first, second, settingsOf(unit)),
                   scoresAlone(second, settingsOf(unit)),
                   0.0f);
      };
  for (const DensityUnit unit : {DensityUnit::Automatic, DensityUnit::Faces})
    for (const io::VoxelFrame& first : {before, withDepthModel(before)})
      for (const io::VoxelFrame& second : {finer,
                                           elsewhere,
                                           far_away,
                                           withDepthModel(finer),
                                           withDepthModel(far_away)})
        expectForgotten(first, second, unit);
  // A model changes the automatic unit.
  expectForgotten(before, withDepthModel(frame), DensityUnit::Automatic);
  // On the same lattice the frame before counts.
  EXPECT_NE(scoresBehind(before, frame), scoresAlone(frame));
}

// Positions count from 2^21 voxels below the first grid of a lattice, and grids lie
// within 4..2^23 - 4 of them.
constexpr std::int32_t lowest_first = 4 - (1 << 21);
constexpr std::int32_t highest_end = (1 << 23) - 4 - (1 << 21);
constexpr std::int32_t far_grid_size = 1 << 7;

TEST(VoxelOutlierRemoval, FramesBeforeCountUpToTheLastPosition)
{
  std::mt19937_64 random(17);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    VoxelOutlierRemoval moving(settingsOf(DensityUnit::Faces));
    // One that stays for each place, and sees nothing while the frames are elsewhere.
    const std::vector<std::int32_t> places{
        0, lowest_first, highest_end - far_grid_size};
    std::vector<VoxelOutlierRemoval> resting;
    for (std::size_t i = 0; i < places.size(); ++i)
      resting.emplace_back(settingsOf(DensityUnit::Faces));
    for (const std::size_t now : {0u, 1u, 2u, 1u, 2u, 0u, 1u}) {
      const Voxels voxels = wall(random, 15);
      std::array<std::int32_t, 3> first{};
      first[axis] = places[now];
      Voxels there;
      for (const auto& [index, symbol] : voxels) {
        LatticeIndex moved = index;
        moved[axis] += places[now];
        there[moved] = symbol;
      }
      const Scores scores =
          scoresOf(moving, frameOf(there, gridAt(first[0], first[1], first[2])));
      Scores expected;
      for (std::size_t i = 0; i < places.size(); ++i) {
        const Scores seen = scoresOf(
            resting[i], frameOf(i == now ? voxels : Voxels(), gridAt(0, 0, 0)));
        for (const auto& [index, score] : seen) {
          LatticeIndex moved = index;
          moved[axis] += places[now];
          expected[moved] = score;
        }
      }
      expectSame(scores, expected, 0.0f);
    }
  }
}

TEST(VoxelOutlierRemoval, FramesBeforeAreForgottenBeyondTheLastPosition)
{
  const auto remembered = [](std::size_t axis, std::int32_t first) {
    VoxelOutlierRemoval removal(settingsOf(DensityUnit::Faces));
    io::VoxelFrame frame;
    frame.keys = {0};
    frame.intensities = {200};
    frame.grid = gridAt(0, 0, 0);
    scoresOf(removal, frame);
    frame.grid.first_index[axis] = first;
    scoresOf(removal, frame);
    return removal.rememberedBlocks();
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(remembered(axis, lowest_first), 2u);
    EXPECT_EQ(remembered(axis, lowest_first - 1), 1u);
    EXPECT_EQ(remembered(axis, highest_end - far_grid_size), 2u);
    EXPECT_EQ(remembered(axis, highest_end - far_grid_size + 1), 1u);
  }
}

TEST(VoxelOutlierRemoval, GridsFarApartDoNotMeet)
{
  io::VoxelFrame first;
  first.keys = {5};
  first.intensities = {200};
  first.grid = gridAt(std::numeric_limits<std::int32_t>::min(), 0, 0, 21);
  io::VoxelFrame second = first;
  second.keys = {4};
  second.grid = gridAt(std::numeric_limits<std::int32_t>::max(), 0, 0, 21);
  const VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Faces);
  expectSame(
      scoresBehind(first, second, settings), scoresAlone(second, settings), 0.0f);
}

TEST(VoxelOutlierRemoval, ResetAndNoHistoryForget)
{
  std::mt19937_64 random(6);
  const io::VoxelFrame first = frameOf(wall(random, 15), gridAt(0, 0, 0));
  const io::VoxelFrame second = frameOf(wall(random, 15), gridAt(0, 0, 0));
  for (const bool has_model : {false, true}) {
    const VoxelOutlierRemovalSettings settings =
        settingsOf(has_model ? DensityUnit::Automatic : DensityUnit::Faces);
    VoxelOutlierRemoval removal(settings);
    scoresOf(removal, has_model ? withDepthModel(first) : first);
    removal.reset();
    EXPECT_EQ(removal.rememberedBlocks(), 0u);
    expectSame(scoresOf(removal, second), scoresAlone(second, settings), 0.0f);
  }
  const Scores expected = scoresAlone(second, settingsOf(DensityUnit::Faces));
  VoxelOutlierRemoval alone(settingsOf(DensityUnit::Faces, false));
  scoresOf(alone, first);
  EXPECT_EQ(alone.rememberedBlocks(), 0u);
  expectSame(scoresOf(alone, second), expected, 0.0f);
  EXPECT_NE(scoresBehind(first, second, settingsOf(DensityUnit::Faces)), expected);
}

/** \brief Voxels here and there, hardly two of them in a block. */
io::VoxelFrame
scattered(std::mt19937_64& random, std::size_t voxels)
{
  io::VoxelFrame frame;
  frame.grid = gridAt(0, 0, 0, 12);
  for (std::size_t i = 0; i < voxels; ++i)
    frame.keys.push_back(random() % (std::uint64_t{1} << 36));
  std::sort(frame.keys.begin(), frame.keys.end());
  frame.intensities.assign(voxels, 255);
  return frame;
}

TEST(VoxelOutlierRemoval, RemembersAsManyAsItMay)
{
  VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Faces);
  settings.max_blocks = 300;
  // A block for each number of each frame.
  using Numbers = std::pair<std::int64_t, std::int64_t>;
  const auto remembered = [&](const std::vector<Numbers>& frames) {
    VoxelOutlierRemoval removal(settings);
    VoxelOutlierRemoval filtering(settings);
    for (const auto& [first, last] : frames) {
      Voxels voxels;
      for (std::int64_t number = first; number <= last; ++number)
        voxels[{8 * number, 100, 100}] = 200;
      io::VoxelFrame frame = frameOf(voxels, gridAt(0, 0, 0, 12));
      EXPECT_EQ(scoresOf(removal, frame).size(), voxels.size());
      EXPECT_TRUE(filtering.filter(frame).ok());
      EXPECT_EQ(filtering.rememberedBlocks(), removal.rememberedBlocks());
    }
    return removal.rememberedBlocks();
  };
  EXPECT_EQ(remembered({{1, 300}}), 300u);
  EXPECT_EQ(remembered({{1, 301}}), 0u);
  EXPECT_EQ(remembered({{1, 100}, {101, 300}}), 300u);
  EXPECT_EQ(remembered({{1, 100}, {101, 301}}), 201u);
}

TEST(VoxelOutlierRemoval, RemembersTheLastFrameWhereThereIsNoRoomForMore)
{
  std::mt19937_64 random(18);
  const auto plate = [&](std::int64_t first_z) {
    Voxels voxels;
    for (std::int64_t y = 20; y < 45; ++y)
      for (std::int64_t z = first_z; z < 45; ++z)
        voxels[{15, y, z}] = static_cast<std::uint16_t>(30 + random() % 226);
    return voxels;
  };
  // Half of it comes first, together with what there is no room for, so that the blocks
  // are in another order than their places.
  Voxels first = plate(33);
  for (std::int64_t y = 0; y < 10; ++y)
    first[{100, 8 * y, 100}] = 200;
  const io::VoxelFrame second = frameOf(plate(20), gridAt(0, 0, 0));
  Voxels rest = plate(20); // what is missing is filled in by the frames before
  for (auto voxel = rest.begin(); voxel != rest.end();)
    voxel = random() % 2 == 0 ? rest.erase(voxel) : std::next(voxel);
  const io::VoxelFrame third = frameOf(rest, gridAt(0, 0, 0));
  VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Faces);
  VoxelOutlierRemoval roomy(settings);
  VoxelOutlierRemoval alone(settings);
  scoresOf(alone, second);
  settings.max_blocks = alone.rememberedBlocks();
  VoxelOutlierRemoval narrow(settings);
  for (VoxelOutlierRemoval* const removal : {&roomy, &narrow}) {
    scoresOf(*removal, frameOf(first, gridAt(0, 0, 0)));
    scoresOf(*removal, second);
  }
  EXPECT_EQ(narrow.rememberedBlocks(), settings.max_blocks);
  EXPECT_EQ(roomy.rememberedBlocks(), settings.max_blocks + 10);
  expectSame(scoresOf(narrow, third), scoresOf(roomy, third), 0.0f);
}

TEST(VoxelOutlierRemoval, ReleasesTheMemoryOfForgottenFrames)
{
  std::mt19937_64 random(19);
  const io::VoxelFrame large = scattered(random, 50000);
  std::vector<float> log_odds(large.size());
  constexpr std::size_t little = 100000; // less than any number for each voxel takes
  for (const bool resets : {false, true}) {
    VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Faces);
    settings.max_blocks = resets ? large.size() : 300;
    VoxelOutlierRemoval removal(settings);
    const MemoryUse memory_use;
    removal.score(large, log_odds);
    if (resets) {
      EXPECT_GT(memory_use.live(), 270 * large.size());
      removal.reset();
    }
    EXPECT_LT(memory_use.live(), little);
  }
}

TEST(VoxelOutlierRemoval, ForgetsWithinASecond)
{
  std::mt19937_64 random(8);
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Points));
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  EXPECT_GT(removal.filter(frame).removed, 0u);
  EXPECT_GT(removal.rememberedBlocks(), 0u);
  for (int i = 0; i < 20; ++i) {
    io::test::clearVoxels(frame);
    EXPECT_EQ(removal.filter(frame).removed, 0u);
  }
  EXPECT_EQ(removal.rememberedBlocks(), 0u);
}

TEST(VoxelOutlierRemoval, KeepsItsHistoryWhereItIsMoved)
{
  std::mt19937_64 random(10);
  const io::VoxelFrame first = frameOf(wall(random, 15), gridAt(0, 0, 0));
  const io::VoxelFrame second = frameOf(wall(random, 15), gridAt(0, 0, 0));
  VoxelOutlierRemoval removal;
  scoresOf(removal, first);
  VoxelOutlierRemoval moved = std::move(removal);
  expectSame(scoresOf(moved, second), scoresBehind(first, second), 0.0f);
}

} // namespace

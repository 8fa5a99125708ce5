// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Intensities and colours that TemporalVoxelFilter shows.
 */
#include "support/temporal_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::temporal;
using io::VoxelFrame;

TEST(TemporalVoxelFilter, NoiseOfIntensitiesIsHeldAndAJumpFollowsAtOnce)
{
  TemporalVoxelFilter filter;
  std::mt19937 random(2);
  std::poisson_distribution<int> noise(40);
  double shown_error = 0.0;
  double error = 0.0;
  std::size_t changes = 0;
  Voxels last;
  for (int i = 0; i < 100; ++i) {
    Voxels symbols = flatWall();
    for (auto& [index, symbol] : symbols)
      symbol = static_cast<std::uint16_t>(noise(random));
    const Voxels shown = shownOf(filter, symbols);
    for (const auto& [index, symbol] : shown)
      if (i >= 50) {
        shown_error += (symbol - 40.0) * (symbol - 40.0);
        error += (symbols[index] - 40.0) * (symbols[index] - 40.0);
        changes += symbol != last[index] ? 1 : 0;
      }
    last = shown;
  }
  EXPECT_LT(std::sqrt(shown_error / error), 0.5);
  EXPECT_LT(changes, 50u * wall_size * wall_size / 10);
  const Voxels brighter = flatWall(wall_depth, 140);
  EXPECT_EQ(shownOf(filter, brighter), brighter);
}

TEST(TemporalVoxelFilter, NoiseOfFineIntensitiesIsHeldSoonAfterTheStart)
{
  // 16 bits; the deviation of a count of this size would be 173.
  TemporalVoxelFilter filter;
  std::mt19937 random(6);
  std::normal_distribution<double> noise(30000.0, 3000.0);
  std::vector<std::uint16_t> last;
  std::size_t changes = 0;
  for (int i = 0; i < 30; ++i) {
    VoxelFrame frame = scene(flatWall());
    frame.intensity_scale.bits = 16;
    for (std::uint16_t& symbol : frame.intensities)
      symbol = static_cast<std::uint16_t>(std::clamp(noise(random), 0.0, 65535.0));
    ASSERT_TRUE(filter.filter(frame, {in_front, std::nullopt}).ok());
    for (std::size_t voxel = 0; voxel < frame.size() && i >= 10; ++voxel)
      changes += frame.intensities[voxel] != last[voxel] ? 1 : 0;
    last = frame.intensities;
  }
  EXPECT_LT(changes, 20u * wall_size * wall_size / 5);
}

TEST(TemporalVoxelFilter, IntensitiesMoveToAnotherScale)
{
  TemporalVoxelFilter filter;
  for (int i = 0; i < 10; ++i)
    shownOf(filter, flatWall());
  Voxels some;
  for (const auto& [index, symbol] : flatWall())
    if ((index[0] + index[1]) % 2 == 0)
      some[index] = 7;
  VoxelFrame frame = scene(some);
  frame.intensity_scale.offset = -256.0f;
  frame.intensity_scale.step = 2.0f;
  frame.intensity_scale.bits = 9;
  ASSERT_TRUE(filter.filter(frame, {in_front, std::nullopt}).ok());
  ASSERT_TRUE(isConsistent(frame));
  const Voxels shown = voxelsOf(frame);
  ASSERT_EQ(shown.size(), flatWall().size());
  // 9 is between -256 + 132 * 2 and -256 + 133 * 2.
  for (const auto& [index, symbol] : shown)
    EXPECT_EQ(symbol, some.count(index) != 0 ? 7 : 133);
}

TEST(TemporalVoxelFilter, WithADepthModelWholeNumbersOfPointsAreShown)
{
  TemporalVoxelFilter filter;
  io::DepthModel model;
  model.full_symbol = 255u << 8;
  model.origin = std::int64_t{1} << 30;
  std::mt19937 random(3);
  for (int i = 0; i < 30; ++i) {
    Voxels symbols = flatWall();
    for (auto& [index, symbol] : symbols)
      symbol = static_cast<std::uint16_t>(60 + random() % 9);
    VoxelFrame frame = scene(symbols);
    frame.depth_model = model;
    ASSERT_TRUE(filter.filter(frame).ok());
    ASSERT_EQ(frame.size(), symbols.size());
    // A sixteenth of a share for each point: 15.94.
    for (const std::uint16_t symbol : frame.intensities)
      EXPECT_EQ(symbol, 64);
  }
}

TEST(TemporalVoxelFilter, ColoursAreHeld)
{
  TemporalVoxelFilter filter;
  std::mt19937 random(4);
  std::vector<io::VoxelColour> last;
  std::size_t changes = 0;
  for (int i = 0; i < 100; ++i) {
    VoxelFrame frame = scene(flatWall());
    frame.intensity_scale.bits = 0;
    frame.intensities.clear();
    frame.colour_bits = 6;
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
      frame.colours.push_back({static_cast<std::uint8_t>(30 + random() % 5),
                               static_cast<std::uint8_t>(20 + random() % 5),
                               static_cast<std::uint8_t>(10 + random() % 5)});
    ASSERT_TRUE(filter.filter(frame).ok());
    ASSERT_TRUE(isConsistent(frame));
    for (std::size_t voxel = 0; voxel < frame.size() && i >= 70; ++voxel) {
      EXPECT_NEAR(frame.colours[voxel].r, 32, 1);
      EXPECT_NEAR(frame.colours[voxel].b, 12, 1);
      changes += frame.colours[voxel] == last[voxel] ? 0 : 1;
    }
    last = frame.colours;
  }
  EXPECT_LT(changes, 30u * wall_size * wall_size / 10);
}

} // namespace

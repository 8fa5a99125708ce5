// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/temporal_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <random>
#include <string>
#include <utility>
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
  TemporalVoxelFilter filter = filterBehind(flatWall());
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

TEST(TemporalVoxelFilter, TheHistoryMovesWithTheGridAndEndsWithTheLattice)
{
  const auto filterAnother = [](auto change) {
    TemporalVoxelFilter filter = filterBehind(flatWall());
    Voxels some;
    for (const auto& [index, symbol] : flatWall())
      if (index[1] >= 2 && (index[0] + index[1]) % 2 == 0)
        some[index] = symbol;
    VoxelFrame frame = frameOf(some, gridAt(-5, 2, -9));
    change(frame);
    VoxelFrame unknown = frame;
    EXPECT_TRUE(filter.filter(frame, {in_front, std::nullopt}).ok());
    TemporalVoxelFilter fresh;
    EXPECT_TRUE(fresh.filter(unknown, {in_front, std::nullopt}).ok());
    return std::pair(voxelsOf(frame), voxelsOf(unknown));
  };
  // Without the part of the wall that the moved grid does not have.
  Voxels moved;
  for (const auto& [index, symbol] : flatWall())
    if (index[1] >= 2)
      moved[index] = symbol;
  EXPECT_EQ(filterAnother([](VoxelFrame&) {}).first, moved);
  for (const auto& change : std::initializer_list<void (*)(VoxelFrame&)>{
           [](VoxelFrame& frame) { frame.grid.resolution = 0.05; },
           [](VoxelFrame& frame) { frame.grid.origin[0] = 1.0; },
           [](VoxelFrame& frame) {
             frame.colour_bits = 1;
             frame.colours.resize(frame.size());
           }}) {
    const auto [shown, of_fresh] = filterAnother(change);
    EXPECT_EQ(shown, of_fresh);
    EXPECT_LT(shown.size(), moved.size());
  }
}

TEST(TemporalVoxelFilter, AnotherSceneIsShownWithoutTheLast)
{
  const auto partOf = [](const Voxels& voxels, std::int64_t columns) {
    Voxels part;
    for (const auto& [index, symbol] : voxels)
      if (index[0] < columns)
        part[index] = symbol;
    return part;
  };
  const Voxels other = flatWall(wall_depth - 10);
  const auto shownAfterWall = [&](const Voxels& symbols) {
    TemporalVoxelFilter filter = filterBehind(flatWall(), 64);
    return shownOf(filter, symbols);
  };
  EXPECT_EQ(shownAfterWall({}), Voxels());
  EXPECT_EQ(shownAfterWall(other), other);
  const std::int64_t eighth = wall_size / 8;
  EXPECT_EQ(shownAfterWall(partOf(flatWall(), eighth)), flatWall());
  EXPECT_EQ(shownAfterWall(partOf(flatWall(), eighth - 1)),
            partOf(flatWall(), eighth - 1));
}

TEST(TemporalVoxelFilter, TheHistoryHasAMostSize)
{
  TemporalVoxelFilter filter(64);
  std::mt19937 random(7);
  const io::VoxelGrid grid = gridAt(0, 0, 0, 12);
  std::size_t most = 0;
  for (int i = 0; i < 15; ++i) {
    Voxels symbols = flatWall();
    for (int k = 0; k < 20000; ++k)
      symbols[{static_cast<std::int64_t>(random() % 4096),
               static_cast<std::int64_t>(random() % 4096),
               static_cast<std::int64_t>(random() % 4096)}] = 1;
    VoxelFrame frame = frameOf(symbols, grid);
    ASSERT_TRUE(filter.filter(frame).ok());
    most = std::max(most, filter.rememberedVoxels());
    EXPECT_LE(filter.rememberedVoxels(), 8 * symbols.size() + 65536);
  }
  EXPECT_GT(most, std::size_t{200000});
}

TEST(TemporalVoxelFilter, ForgetsNoiseAndWhatIsGone)
{
  TemporalVoxelFilter filter;
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    Voxels symbols = flatWall();
    for (int k = 0; k < 100; ++k)
      symbols[{static_cast<std::int64_t>(random() % 64),
               static_cast<std::int64_t>(random() % 64),
               static_cast<std::int64_t>(random() % 50)}] = 1;
    shownOf(filter, symbols);
    EXPECT_LT(filter.rememberedVoxels(), flatWall().size() + 600);
  }
  const Voxels left = {{{5, 5, 60}, 9}};
  for (int i = 0; i < 30; ++i)
    shownOf(filter, left);
  shownOf(filter, flatWall());
  filter.reset();
  EXPECT_EQ(filter.rememberedVoxels(), 0u);
}

TEST(TemporalVoxelFilter, RefusesWhatItCannotFilterAndLeavesIt)
{
  for (const unsigned int frames : {0u, 1u, 65u}) {
    TemporalVoxelFilter filter(frames);
    VoxelFrame frame = scene(flatWall());
    const TemporalFilterStatus status = filter.filter(frame);
    EXPECT_EQ(status.code(), TemporalFilterCode::InvalidSettings);
    EXPECT_EQ(status.message(),
              "frames is " + std::to_string(frames) + "; it must be 2 to 64");
    EXPECT_EQ(voxelsOf(frame), flatWall());
  }
  VoxelFrame counted = scene(flatWall());
  counted.has_point_counts = true;
  counted.point_counts.assign(counted.size(), 2);
  VoxelFrame of_points = scene({});
  of_points.points.width = of_points.points.height = 1;
  of_points.points.indices = {0};
  of_points.points.positions = {{0.0, 0.0, 0.0}};
  VoxelFrame with_field = scene(flatWall());
  with_field.fields.emplace_back();
  TemporalVoxelFilter filter;
  for (VoxelFrame frame : {counted, of_points, with_field}) {
    const std::size_t size = frame.size();
    EXPECT_EQ(filter.filter(frame).code(), TemporalFilterCode::HasPointCounts);
    EXPECT_EQ(frame.size(), size);
  }
  EXPECT_EQ(filter.rememberedVoxels(), 0u);
}

} // namespace

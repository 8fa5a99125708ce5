// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/impl/depth_model.h>

#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr std::int64_t farthest = std::int64_t{1} << 56;
constexpr std::int32_t steepest = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t deepest = std::numeric_limits<std::int32_t>::min();

VoxelGrid
gridOf(double resolution, std::int32_t first)
{
  VoxelGrid grid;
  grid.resolution = resolution;
  grid.first_index.fill(first);
  grid.depth = 10;
  return grid;
}

TEST(DepthModel, PointSymbolsFollowTheLaw)
{
  const std::array<double, 3> sensor{0.3, -2.0, 1.1};
  const std::array<double, 3> axis{0.48, 0.6, 0.64}; // of length 1
  const VoxelGrid grid = gridOf(0.05, -200);
  for (const unsigned int exponent : {1u, 2u})
    for (const double cut_off : {0.7, 4.0, 90.0}) {
      IntensityScale scale;
      scale.step = 0.02f;
      const DepthLaw law{exponent, cut_off, 3.0};
      const auto model = depthModelOf(law, sensor, axis, grid, scale);
      ASSERT_TRUE(model.has_value());
      EXPECT_TRUE(isConsistent(*model));
      std::mt19937_64 random(exponent);
      for (int i = 0; i < 1000; ++i) {
        const VoxelPosition position{static_cast<std::uint32_t>(below(random, 1024)),
                                     static_cast<std::uint32_t>(below(random, 1024)),
                                     static_cast<std::uint32_t>(below(random, 1024))};
        const double depth = axis[0] * (grid.centre(0, position.x) - sensor[0]) +
                             axis[1] * (grid.centre(1, position.y) - sensor[1]) +
                             axis[2] * (grid.centre(2, position.z) - sensor[2]);
        const double share = std::clamp(depth / cut_off, 0.0, 1.0);
        const double symbols = std::pow(share, exponent) * law.full_intensity /
                               static_cast<double>(scale.step);
        EXPECT_NEAR(static_cast<double>(model->pointSymbol(position)) / 65536.0,
                    symbols,
                    1e-4 * symbols + 1e-3);
      }
    }
}

TEST(DepthModel, NumbersAreRounded)
{
  VoxelGrid grid;
  grid.resolution = 0.1;
  grid.depth = 4;
  IntensityScale scale;
  scale.step = 1.5f;
  const auto model = depthModelOf({1, 1.0, 255.0}, {0, 0, 0}, {1, 0, 0}, grid, scale);
  ASSERT_TRUE(model);
  EXPECT_EQ(model->step[0], 429496730); // 2^32 / 10 = 429496729.6
  EXPECT_EQ(model->full_symbol, 43520u);
}

TEST(DepthModel, NoModelForNumbersOutOfRange)
{
  const std::array<double, 3> sensor{};
  const std::array<double, 3> axis{0.0, 0.0, 1.0};
  const DepthLaw law{2, 5.0, 255.0};
  const IntensityScale scale;
  const auto has = [&](const DepthLaw& some_law,
                       const std::array<double, 3>& some_sensor,
                       const VoxelGrid& grid,
                       const IntensityScale& some_scale) {
    return depthModelOf(some_law, some_sensor, axis, grid, some_scale).has_value();
  };
  const VoxelGrid grid = gridOf(0.04, 0);
  const double nan_value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(has(law, sensor, grid, scale));
  IntensityScale other = scale;
  other.offset = 1.0f;
  EXPECT_FALSE(has(law, sensor, grid, other));
  other = scale;
  other.companded_range = 256; // a point is not worth the same at each symbol
  EXPECT_FALSE(has(law, sensor, grid, other));
  other = scale;
  other.step = 1e-6f; // a point is worth more symbols than there can be
  EXPECT_FALSE(has(law, sensor, grid, other));
  EXPECT_FALSE(has(law, sensor, gridOf(10.0, 0), scale)); // beyond the cut-off depth
  EXPECT_TRUE(has(law, sensor, gridOf(2.0, 0), scale));
  EXPECT_FALSE(has(law, {0.0, 0.0, 1e12}, grid, scale));
  EXPECT_FALSE(has(law, {0.0, 0.0, nan_value}, grid, scale));
  EXPECT_FALSE(has({2, nan_value, 255.0}, sensor, grid, scale));
  EXPECT_FALSE(has({2, 5.0, nan_value}, sensor, grid, scale));
  EXPECT_FALSE(has({2, 5.0, -1.0}, sensor, grid, scale));
  EXPECT_FALSE(has({3, 5.0, 255.0}, sensor, grid, scale));
}

TEST(DepthModel, FieldsOutOfRangeAreInconsistent)
{
  DepthModel model;
  EXPECT_TRUE(isConsistent(model));
  model.full_symbol = (1u << 24) - 1;
  model.origin = -farthest;
  model.step = {steepest, deepest, 0};
  EXPECT_TRUE(isConsistent(model));
  model.origin = farthest;
  EXPECT_TRUE(isConsistent(model));
  DepthModel bad = model;
  for (const std::int64_t origin : {farthest + 1,
                                    -farthest - 1,
                                    std::numeric_limits<std::int64_t>::min(),
                                    std::numeric_limits<std::int64_t>::max()}) {
    bad.origin = origin;
    EXPECT_FALSE(isConsistent(bad));
  }
  bad = model;
  for (const std::uint32_t symbol : {1u << 24, 0xffffffffu}) {
    bad.full_symbol = symbol;
    EXPECT_FALSE(isConsistent(bad));
  }
  for (const int exponent : {0, 3, 255}) {
    bad = model;
    bad.exponent = static_cast<std::uint8_t>(exponent);
    EXPECT_FALSE(isConsistent(bad));
  }
  VoxelFrame frame = emptyFrame(4);
  frame.depth_model = model;
  EXPECT_TRUE(isConsistent(frame));
  frame.depth_model = bad;
  EXPECT_FALSE(isConsistent(frame));
}

TEST(DepthModel, ComparesAllFields)
{
  const DepthModel model = roomDepthModel(8, 8);
  EXPECT_TRUE(model == roomDepthModel(8, 8));
  for (int field = 0; field < 6; ++field) {
    DepthModel other = model;
    if (field == 0)
      other.exponent = 1;
    else if (field == 1)
      ++other.full_symbol;
    else if (field == 2)
      ++other.origin;
    else
      ++other.step[static_cast<std::size_t>(field) - 3];
    EXPECT_TRUE(other != model) << field;
  }
}

} // namespace

#include "outliers/density_blocks.h"
#include "outliers/voxel_densities.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>

namespace {

using namespace pcl_ext;

using Position = std::array<std::uint32_t, 3>;

/** \brief f of all voxels, in 2^-2. */
using Field = std::map<Position, std::int32_t>;

std::uint64_t
keyOf(const Position& at)
{
  return DensityBlocks::blockKey(at[0], at[1], at[2]);
}

unsigned int
cellOf(const Position& at)
{
  return DensityBlocks::cell(at[0], at[1], at[2]);
}

/** \brief Sums over a neighbourhood, voxel by voxel. */
NeighbourhoodSums
bruteForceSums(const Field& field, const Position& at)
{
  NeighbourhoodSums sums{};
  for (std::uint32_t x = at[0] - 2; x <= at[0] + 2; ++x)
    for (std::uint32_t y = at[1] - 2; y <= at[1] + 2; ++y)
      for (std::uint32_t z = at[2] - 2; z <= at[2] + 2; ++z) {
        const auto found = field.find({x, y, z});
        if (found == field.end() || found->second == 0)
          continue;
        const auto distance = [](std::uint32_t a, std::uint32_t b) {
          return a < b ? b - a : a - b;
        };
        const std::uint32_t dx = distance(x, at[0]);
        const std::uint32_t dy = distance(y, at[1]);
        const std::uint32_t dz = distance(z, at[2]);
        ++sums.occupied;
        sums.all += found->second;
        if (dx + dy + dz == 0)
          sums.core += 2 * found->second;
        else if (dx + dy + dz == 1)
          sums.core += found->second;
        else if (dx < 2 && dy < 2 && dz < 2)
          sums.ring += found->second;
        else
          sums.rim += found->second;
      }
  return sums;
}

void
expectSums(const DensityBlocks& blocks, std::uint32_t block, const Field& field)
{
  std::uint64_t cells = 0;
  std::map<unsigned int, Position> positions;
  for (const auto& [at, f] : field)
    if (DensityBlocks(blocks).blockAt(keyOf(at)) == block) {
      cells |= std::uint64_t{1} << cellOf(at);
      positions[cellOf(at)] = at;
    }
  DensityWindow window;
  blocks.collect(block, cells, window);
  std::array<NeighbourhoodSums, 64> sums;
  std::array<NeighbourhoodSums, 64> counted;
  sumNeighbourhoods<false>(window, cells, sums);
  sumNeighbourhoods<true>(window, cells, counted);
  for (const auto& [cell, at] : positions) {
    const NeighbourhoodSums expected = bruteForceSums(field, at);
    EXPECT_EQ(sums[cell].core, expected.core);
    EXPECT_EQ(sums[cell].ring, expected.ring);
    EXPECT_EQ(sums[cell].rim, expected.rim);
    EXPECT_EQ(sums[cell].all, expected.all);
    EXPECT_EQ(counted[cell].core, expected.core);
    EXPECT_EQ(counted[cell].rim, expected.rim);
    EXPECT_EQ(counted[cell].occupied, expected.occupied);
  }
}

TEST(DensityBlocks, SumsAreThoseOfEachVoxel)
{
  std::mt19937_64 random(1);
  // From one voxel here and there to voxels everywhere.
  for (const unsigned int percent : {1u, 10u, 50u, 100u}) {
    DensityBlocks blocks;
    Field field;
    for (std::uint32_t x = 102; x < 114; ++x)
      for (std::uint32_t y = 97; y < 111; ++y)
        for (std::uint32_t z = 99; z < 112; ++z) {
          if (random() % 100 >= percent)
            continue;
          const Position at{x, y, z};
          const auto density = static_cast<std::int16_t>(1 + random() % 255);
          blocks.add(blocks.blockAt(keyOf(at)), cellOf(at), density);
          field[at] = 4 * density;
        }
    for (std::uint32_t block = 0; block < blocks.size(); ++block)
      expectSums(blocks, block, field);
  }
}

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

/** \brief f of a voxel, whose block must be there, in 2^-2. */
std::int32_t
fieldAt(DensityBlocks& blocks, const Position& at)
{
  DensityWindow window;
  blocks.collect(blocks.blockAt(keyOf(at)), std::uint64_t{1} << cellOf(at), window);
  const std::size_t x = at[0] % 4 + DensityWindow::margin;
  const std::size_t y = at[1] % 4 + DensityWindow::margin;
  return window.rows[x * DensityWindow::width + y][at[2] % 4 + DensityWindow::margin];
}

TEST(DensityBlocks, ForgetsBlocksWithoutDensity)
{
  DensityBlocks blocks;
  // The first one goes, so that another takes its number.
  blocks.add(blocks.blockAt(DensityBlocks::blockKey(200, 100, 100)), 7, 1);
  blocks.add(blocks.blockAt(DensityBlocks::blockKey(100, 100, 100)), 7, 255);
  ASSERT_EQ(blocks.size(), 2u);
  blocks.age(); // a density of 1 is a mean of 1/4, and gone
  EXPECT_EQ(blocks.size(), 1u);
  EXPECT_EQ(blocks.blockAt(DensityBlocks::blockKey(100, 100, 100)), 0u);
  EXPECT_EQ(fieldAt(blocks, {100, 101, 103}), 255 * 3 / 8);
  for (int frame = 0; frame < 18; ++frame)
    blocks.age();
  EXPECT_EQ(blocks.size(), 1u);
  blocks.age();
  EXPECT_EQ(blocks.size(), 0u);
}

TEST(DensityBlocks, KeepsOnlyTheListedBlocks)
{
  const auto placeOf = [](std::uint32_t x) { return Position{100 + 4 * x, 101, 102}; };
  DensityBlocks blocks;
  for (std::uint32_t x = 0; x < 10; ++x)
    blocks.add(blocks.blockAt(keyOf(placeOf(x))),
               cellOf(placeOf(x)),
               static_cast<std::int16_t>(200 + x));
  blocks.keepOnly({2, 5, 9});
  ASSERT_EQ(blocks.size(), 3u);
  std::uint32_t index = 0;
  for (const std::uint32_t x : {2u, 5u, 9u}) {
    EXPECT_EQ(blocks.blockAt(keyOf(placeOf(x))), index++);
    EXPECT_EQ(fieldAt(blocks, placeOf(x)), 4 * static_cast<std::int32_t>(200 + x));
  }
  EXPECT_EQ(blocks.size(), 3u);
  // One that comes again begins anew.
  EXPECT_EQ(blocks.blockAt(keyOf(placeOf(3))), 3u);
  EXPECT_EQ(fieldAt(blocks, placeOf(3)), 0);
  blocks.add(3, cellOf(placeOf(3)), 103);
  EXPECT_EQ(blocks.size(), 4u);
  blocks.age();
  EXPECT_EQ(fieldAt(blocks, placeOf(3)), 103 * 3 / 8);
  // Half of a mean that has taken a quarter of it, and of that lost a quarter.
  for (const std::uint32_t x : {2u, 5u, 9u})
    EXPECT_EQ(fieldAt(blocks, placeOf(x)), static_cast<std::int32_t>(200 + x) * 3 / 8);
}

TEST(DensityBlocks, AreAsNewWhenCleared)
{
  DensityBlocks cleared;
  for (std::uint32_t x = 0; x < 10; ++x)
    cleared.add(
        cleared.blockAt(keyOf({100 + 4 * x, 101, 102})), cellOf({100, 101, 102}), 250);
  cleared.clear();
  EXPECT_EQ(cleared.size(), 0u);
  EXPECT_EQ(DensityBlocks(cleared).blockAt(keyOf({120, 101, 102})), 0u);
  DensityBlocks fresh;
  for (int frame = 0; frame < 3; ++frame) {
    for (DensityBlocks* const blocks : {&cleared, &fresh}) {
      blocks->age();
      for (std::uint32_t y = 0; y < 12; y += 3)
        blocks->add(blocks->blockAt(keyOf({100, 101 + y, 102})),
                    cellOf({100, 101 + y, 102}),
                    static_cast<std::int16_t>(20 * frame + y + 1));
    }
    ASSERT_EQ(cleared.size(), fresh.size());
    for (std::uint32_t y = 0; y < 12; ++y)
      EXPECT_EQ(fieldAt(cleared, {100, 101 + y, 102}),
                fieldAt(fresh, {100, 101 + y, 102}));
    // What was there, as well as what the last frame left.
    cleared.age();
    fresh.age();
    for (std::uint32_t y = 0; y < 12; y += 3)
      EXPECT_EQ(fieldAt(cleared, {100, 101 + y, 102}),
                fieldAt(fresh, {100, 101 + y, 102}));
  }
}

TEST(DensityBlocks, RememberAMeanDownToAQuarter)
{
  DensityBlocks blocks;
  blocks.add(blocks.blockAt(keyOf({100, 101, 102})), cellOf({100, 101, 102}), 4);
  // 64, 48, 36, 27, 21 and 16 in 2^-6; 12 are less than a quarter.
  for (int frame = 0; frame < 5; ++frame) {
    blocks.age();
    EXPECT_EQ(blocks.size(), 1u) << frame;
  }
  blocks.age();
  EXPECT_EQ(blocks.size(), 0u);
}

/** \brief A grid before a sensor at the origin that looks along x. */
io::VoxelFrame
frameBeforeSensor(unsigned int exponent, double cut_off_depth)
{
  io::VoxelFrame frame;
  frame.grid.resolution = 0.04;
  frame.grid.depth = 9;
  frame.intensity_scale.bits = 8;
  frame.depth_model = io::depthModelOf({exponent, cut_off_depth, 255.0},
                                       {0.0, 0.0, 0.0},
                                       {1.0, 0.0, 0.0},
                                       frame.grid,
                                       frame.intensity_scale);
  return frame;
}

/** \brief Density of a cell of one voxel. */
int
densityOf(const VoxelDensities& densities,
          unsigned int symbol,
          const io::VoxelPosition& at)
{
  io::VoxelFrame frame;
  frame.intensities = {static_cast<std::uint16_t>(symbol)};
  return VoxelDensities::density(densities(frame, 0, at));
}

TEST(VoxelDensities, LinearLawBecomesTheQuadraticOne)
{
  constexpr double cut_off_depth = 15.0;
  VoxelDensities quadratic(DensityUnit::Automatic, 255.0f);
  VoxelDensities linear(DensityUnit::Automatic, 255.0f);
  ASSERT_NE(quadratic.unit(), DensityUnit::Faces);
  EXPECT_FALSE(quadratic.follow(frameBeforeSensor(2, cut_off_depth), {0, 0, 0}, 0));
  EXPECT_FALSE(linear.follow(frameBeforeSensor(1, cut_off_depth), {0, 0, 0}, 0));
  ASSERT_EQ(quadratic.unit(), DensityUnit::Faces);
  for (std::uint32_t x = 10; x < 370; ++x) {
    const double share = (x + 0.5) * 0.04 / cut_off_depth;
    for (int points = 1; points * share <= 1.0 && points < 6; ++points) {
      const auto linear_symbol =
          static_cast<std::uint16_t>(std::lround(255.0 * points * share));
      const double quadratic_symbol = std::round(255.0 * points * share * share);
      // As dense as it need be with nine points to a face, where there can be as many.
      const double nine = std::max(1.0, 1.0 / (9.0 * share * share));
      const double expected =
          std::clamp(255.0 * points * share * share * nine, 1.0, 255.0);
      // Symbols and depths are rounded, the more where a symbol stands for many points.
      const double tolerance = 1.0 + nine + 0.03 * expected;
      const io::VoxelPosition at{x, 3, 4};
      EXPECT_NEAR(densityOf(linear, linear_symbol, at), expected, tolerance);
      EXPECT_NEAR(densityOf(quadratic, static_cast<unsigned int>(quadratic_symbol), at),
                  std::clamp(quadratic_symbol * nine, 1.0, 255.0),
                  tolerance);
    }
  }
}

TEST(VoxelDensities, APointAtTheSensorOrBehindItCoversAFace)
{
  io::VoxelFrame frame = frameBeforeSensor(2, 15.0);
  frame.depth_model = io::depthModelOf({2, 15.0, 255.0},
                                       {0.5, 0.0, 0.0},
                                       {1.0, 0.0, 0.0},
                                       frame.grid,
                                       frame.intensity_scale);
  ASSERT_TRUE(frame.depth_model);
  VoxelDensities densities(DensityUnit::Automatic, 255.0f);
  densities.follow(frame, {0, 0, 0}, 0);
  for (std::uint32_t x = 0; x < 14; ++x)
    EXPECT_EQ(densityOf(densities, 1, {x, 3, 4}), 255) << x;
}

TEST(VoxelDensities, StayFacesWhereAFrameHasNoModel)
{
  VoxelDensities densities(DensityUnit::Automatic, 255.0f);
  io::VoxelFrame frame = frameBeforeSensor(2, 15.0);
  EXPECT_FALSE(densities.follow(frame, {0, 0, 0}, 0));
  frame.depth_model.reset();
  EXPECT_TRUE(densities.follow(frame, {0, 0, 0}, 0));
  EXPECT_EQ(densities.unit(), DensityUnit::Faces);
  EXPECT_EQ(densityOf(densities, 100, {200, 2, 3}), 100); // 8 m away
  densities.reset();
  EXPECT_FALSE(densities.follow(frame, {0, 0, 0}, 0));
  EXPECT_EQ(densities.unit(), DensityUnit::Voxels);
}

TEST(VoxelDensities, AreAtLeastOneAndAtMostAFace)
{
  io::VoxelFrame frame;
  frame.intensity_scale = {0.0f, 1.0f, 16};
  VoxelDensities points(DensityUnit::Points, 255.0f);
  EXPECT_TRUE(points.follow(frame, {0, 0, 0}, 0));
  EXPECT_EQ(densityOf(points, 0, {0, 0, 0}), 1);
  EXPECT_EQ(densityOf(points, 7, {0, 0, 0}), 7);
  EXPECT_EQ(densityOf(points, 65535, {0, 0, 0}), 255);
  // Another scale, of shares up to 2.
  frame.intensity_scale = {-1.0f, 2.0f, 8};
  VoxelDensities faces(DensityUnit::Faces, 100.0f);
  EXPECT_TRUE(faces.follow(frame, {0, 0, 0}, 0));
  EXPECT_EQ(densityOf(faces, 0, {0, 0, 0}), 1);
  EXPECT_EQ(densityOf(faces, 20, {0, 0, 0}), 99); // 39 of 100
  EXPECT_EQ(densityOf(faces, 200, {0, 0, 0}), 255);
  // Nonsense for a face does no harm.
  for (const float nonsense : {0.0f, -1.0f, std::nanf("")}) {
    VoxelDensities none(DensityUnit::Faces, nonsense);
    none.follow(frame, {0, 0, 0}, 0);
    for (std::uint16_t symbol = 0; symbol < 256; ++symbol) {
      EXPECT_GE(densityOf(none, symbol, {0, 0, 0}), 1);
      EXPECT_LE(densityOf(none, symbol, {0, 0, 0}), 255);
    }
  }
}

} // namespace

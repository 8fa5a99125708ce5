// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/point_blocks.h"
#include "voxelizing/sorted_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;

using Positions = std::vector<VoxelPosition>;

void
begin(PointBlocks& voxels, const SummedFields& fields, std::size_t /*points*/)
{
  voxels.begin(fields);
}

void
begin(SortedVoxels& voxels, const SummedFields& fields, std::size_t points)
{
  voxels.begin(fields, points);
}

struct ExpectedVoxel {
  std::uint32_t count = 0;
  double intensity = 0.0;
  ColourSum colour;
};

/** \brief Adds points as the voxelizer does, and compares what comes out with a map. */
template <typename VoxelsT>
void
expectVoxels(VoxelsT& voxels,
             const Positions& positions,
             const SummedFields& fields = {true, true})
{
  begin(voxels, fields, positions.size());
  std::map<std::uint64_t, ExpectedVoxel> expected;
  std::map<std::uint64_t, std::uint32_t> blocks;
  std::mt19937 random(3);
  for (std::size_t first = 0; first < positions.size();
       first += LocatedPoints::capacity) {
    LocatedPoints located;
    for (std::size_t i = first;
         i < std::min(positions.size(), first + LocatedPoints::capacity);
         ++i) {
      const BlockVoxel block_voxel = blockVoxelOf(positions[i]);
      const std::uint64_t key = mortonKey(positions[i]);
      EXPECT_EQ(mortonKey(block_voxel), key);
      const auto colour = static_cast<std::uint32_t>(random());
      const auto intensity = static_cast<float>(random() % 1000) / 8.0f;
      located.blocks[located.count] = block_voxel.block;
      located.voxels[located.count] = block_voxel.voxel;
      located.points[located.count] = i;
      located.intensities[located.count] = intensity;
      located.colours[located.count] = colour;
      ++located.count;
      ExpectedVoxel& voxel = expected[key];
      ++voxel.count;
      voxel.intensity += static_cast<double>(intensity);
      voxel.colour.r += colour >> 16 & 0xff;
      voxel.colour.g += colour >> 8 & 0xff;
      voxel.colour.b += colour & 0xff;
      ++blocks[key >> 6];
    }
    voxels.add(located);
  }
  std::vector<std::uint64_t> keys(3, 7); // of an earlier cloud
  VoxelSums sums;
  voxels.writeVoxels(keys, sums);

  ASSERT_EQ(keys.size(), expected.size());
  ASSERT_EQ(sums.counts.size(), expected.size());
  ASSERT_EQ(sums.intensities.size(), fields.intensities ? expected.size() : 0);
  ASSERT_EQ(sums.colours.size(), fields.colours ? expected.size() : 0);
  EXPECT_EQ(voxels.occupiedBlocks(), blocks.size());
  std::size_t i = 0;
  for (const auto& [key, voxel] : expected) {
    ASSERT_EQ(keys[i], key);
    ASSERT_EQ(sums.counts[i], voxel.count);
    if (fields.intensities) {
      ASSERT_EQ(sums.intensities[i], voxel.intensity);
    }
    if (fields.colours) {
      ASSERT_EQ(sums.colours[i].r, voxel.colour.r);
      ASSERT_EQ(sums.colours[i].g, voxel.colour.g);
      ASSERT_EQ(sums.colours[i].b, voxel.colour.b);
    }
    ++i;
  }
}

Positions
randomPositions(std::uint64_t seed,
                std::size_t count,
                std::uint32_t low,
                std::uint32_t size)
{
  std::mt19937_64 random(seed);
  const auto coordinate = [&] {
    return low + static_cast<std::uint32_t>(random() % size);
  };
  Positions positions(count);
  for (VoxelPosition& position : positions)
    position = {coordinate(), coordinate(), coordinate()};
  return positions;
}

constexpr std::uint32_t grid_end = std::uint32_t{1} << max_grid_depth;

template <typename VoxelsT>
class VoxelSets : public ::testing::Test {};

using AllSets = ::testing::Types<PointBlocks, SortedVoxels>;
TYPED_TEST_SUITE(VoxelSets, AllSets);

TYPED_TEST(VoxelSets, AreThoseOfAMap)
{
  TypeParam voxels;
  expectVoxels(voxels, {});
  for (std::uint64_t seed = 1; seed < 8; ++seed)
    for (const std::uint32_t size : {1u, 2u, 5u, 30u, 1000u, grid_end})
      expectVoxels(voxels, randomPositions(seed, 3000, 0, size));
  expectVoxels(voxels, {});
  expectVoxels(voxels, randomPositions(8, 1000, grid_end - 50, 50));
}

TYPED_TEST(VoxelSets, AreTheSameWithoutIntensitiesAndColoursOfThePoints)
{
  TypeParam voxels;
  for (std::uint64_t seed = 1; seed < 4; ++seed)
    for (const std::uint32_t size : {1u, 30u, grid_end}) {
      expectVoxels(voxels, randomPositions(seed, 3000, 0, size), {false, false});
      expectVoxels(voxels, randomPositions(seed, 500, 0, size), {true, false});
      expectVoxels(voxels, randomPositions(seed, 1000, 0, size), {false, true});
    }
}

TYPED_TEST(VoxelSets, AreThoseOfCloudsOfAnySize)
{
  TypeParam voxels;
  for (const std::size_t count : {254u, 255u, 256u, 257u, 70000u}) { // in one voxel
    Positions positions(count, VoxelPosition{5, 6, 7});
    positions.push_back({5, 6, 8});
    expectVoxels(voxels, positions);
  }
  for (std::uint64_t seed = 1; seed < 3; ++seed) { // more runs than fit the cache
    expectVoxels(voxels, randomPositions(seed, 150000, 0, 6));
    expectVoxels(voxels, randomPositions(seed, 70000, 3, 9), {seed % 2 == 0, true});
    expectVoxels(voxels, randomPositions(seed, 150000, 3, 60)); // sparse
    expectVoxels(voxels, randomPositions(seed, 3000, 2, 9));
  }
  for (std::uint32_t step = 0; step < 200; ++step) // a cloud that wanders
    expectVoxels(voxels, randomPositions(step, 600, 97 * step, 40));
  for (const std::size_t count : {10u, 100000u, 10u, 20u, 0u, 50000u})
    expectVoxels(voxels, randomPositions(count, count, 1000, 300));
}

/** \brief Blocks with the same voxel in any table of the class, so that they replace
 * each other. */
TEST(PointBlocks, UniteBlocksThatCollide)
{
  constexpr std::uint64_t factor = 0x9e3779b97f4a7c15;
  Positions colliding;
  std::mt19937_64 random(9);
  while (colliding.size() < 60) {
    const VoxelPosition position{static_cast<std::uint32_t>(random() % grid_end),
                                 static_cast<std::uint32_t>(random() % grid_end),
                                 static_cast<std::uint32_t>(random() % grid_end)};
    std::uint64_t mixed = blockVoxelOf(position).block * factor;
    mixed = (mixed ^ mixed >> 32) * factor;
    if (mixed >> 52 == 0x7a5)
      colliding.push_back(position);
  }
  PointBlocks voxels;
  for (const int points : {20000, 100000, 20000, 20000}) {
    Positions positions;
    for (int i = 0; i < points; ++i) {
      VoxelPosition position = colliding[random() % colliding.size()];
      position.z = (position.z & ~3u) | static_cast<std::uint32_t>(random() % 4);
      positions.push_back(position);
    }
    expectVoxels(voxels, positions);
  }
}

} // namespace

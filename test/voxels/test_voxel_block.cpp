#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

using Masks = std::array<std::uint64_t, face_count>;

/** \brief Random masks from empty to full. */
std::uint64_t
randomMask(std::mt19937_64& random)
{
  switch (below(random, 6)) {
  case 0:
    return 0;
  case 1:
    return ~std::uint64_t{0};
  case 2:
    return random() & random() & random();
  case 3:
    return random() | random() | random();
  default:
    return random();
  }
}

/** \brief Steps to the neighbour across a face: one back or forth along an axis. */
std::array<std::int64_t, 3>
stepAcross(std::size_t face)
{
  std::array<std::int64_t, 3> step{};
  step[face % 3] = face < 3 ? -1 : 1;
  return step;
}

/** \brief Whether a cell's neighbour across a face is occupied, by its position. */
bool
isOccupiedAcross(std::uint64_t mask,
                 std::uint64_t neighbour,
                 std::size_t face,
                 unsigned int cell)
{
  const VoxelPosition position = voxelPosition(cell);
  std::array<std::int64_t, 3> place{position.x, position.y, position.z};
  bool is_inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] += stepAcross(face)[axis];
    is_inside = is_inside && place[axis] >= 0 && place[axis] < 4;
    place[axis] = (place[axis] + 4) % 4;
  }
  const std::uint64_t other = mortonKey({static_cast<std::uint32_t>(place[0]),
                                         static_cast<std::uint32_t>(place[1]),
                                         static_cast<std::uint32_t>(place[2])});
  return ((is_inside ? mask : neighbour) >> other & 1) != 0;
}

TEST(VoxelBlock, CellsAreCounted)
{
  std::mt19937_64 random(1);
  for (int round = 0; round < 2000; ++round) {
    const std::uint64_t mask = randomMask(random);
    unsigned int count = 0;
    unsigned int lowest = block_cells;
    std::array<unsigned int, 8> octants{};
    for (unsigned int cell = block_cells; cell-- > 0;)
      if ((mask >> cell & 1) != 0) {
        ++count;
        lowest = cell;
        ++octants[cell / 8];
      }
    ASSERT_EQ(pcl_ext::bitCount(mask), count);
    if (mask != 0) {
      ASSERT_EQ(pcl_ext::lowestBit(mask), lowest);
    }
    for (unsigned int octant = 0; octant < 8; ++octant)
      ASSERT_EQ(octantCount(mask, octant), octants[octant]);
  }
}

TEST(VoxelBlock, EachCellSeesItsNeighbours)
{
  std::mt19937_64 random(2);
  for (int round = 0; round < 2000; ++round) {
    const std::uint64_t mask = randomMask(random);
    const std::uint64_t neighbour = randomMask(random);
    for (std::size_t face = 0; face < face_count; ++face) {
      const std::uint64_t across = occupiedAcross(mask, neighbour, face);
      for (unsigned int cell = 0; cell < block_cells; ++cell)
        ASSERT_EQ((across >> cell & 1) != 0,
                  isOccupiedAcross(mask, neighbour, face, cell))
            << "face " << face << ", cell " << cell;
    }
  }
}

TEST(VoxelBlock, NeighboursAreCounted)
{
  std::mt19937_64 random(3);
  for (int round = 0; round < 2000; ++round) {
    const std::uint64_t mask = randomMask(random);
    Masks neighbours;
    std::generate(
        neighbours.begin(), neighbours.end(), [&] { return randomMask(random); });
    const NeighbourCounts counts = countNeighbours(mask, neighbours);
    std::array<unsigned int, 8> octants{};
    for (unsigned int cell = 0; cell < block_cells; ++cell) {
      unsigned int expected = 0;
      for (std::size_t face = 0; face < face_count; ++face)
        expected += isOccupiedAcross(mask, neighbours[face], face, cell) ? 1 : 0;
      ASSERT_EQ(counts.of(cell), expected);
      octants[cell / 8] += expected;
    }
    for (unsigned int octant = 0; octant < 8; ++octant)
      ASSERT_EQ(counts.sum(octant), octants[octant]);
  }
}

TEST(VoxelBlock, NeighbourBlocksEndAtTheGridsFaces)
{
  std::mt19937_64 random(4);
  for (unsigned int levels = 0; levels <= max_grid_depth - block_levels; ++levels) {
    const std::int64_t size = std::int64_t{1} << levels;
    for (int round = 0; round < 300; ++round) {
      std::array<std::int64_t, 3> place;
      for (std::int64_t& coordinate : place) {
        // At the faces, near the middle where all carries run, and anywhere.
        const std::int64_t candidates[] = {
            0,
            size - 1,
            size / 2,
            std::max<std::int64_t>(size / 2 - 1, 0),
            static_cast<std::int64_t>(below(random, static_cast<std::uint64_t>(size)))};
        coordinate = candidates[below(random, 5)];
      }
      const auto keyOf = [](const std::array<std::int64_t, 3>& at) {
        return mortonKey({static_cast<std::uint32_t>(at[0]),
                          static_cast<std::uint32_t>(at[1]),
                          static_cast<std::uint32_t>(at[2])});
      };
      for (std::size_t face = 0; face < face_count; ++face) {
        std::array<std::int64_t, 3> expected = place;
        expected[face % 3] += stepAcross(face)[face % 3];
        const bool is_in_grid = expected[face % 3] >= 0 && expected[face % 3] < size;
        std::uint64_t neighbour = 12345;
        ASSERT_EQ(neighbourBlock(keyOf(place), face, levels, neighbour), is_in_grid)
            << "levels " << levels << ", face " << face;
        if (is_in_grid) {
          ASSERT_EQ(neighbour, keyOf(expected));
        }
      }
    }
  }
}

/** \brief Neighbours of a voxel among all voxels of a frame, by position. */
unsigned int
neighboursOf(std::uint64_t key, const std::set<std::uint64_t>& keys, unsigned int depth)
{
  const VoxelPosition position = voxelPosition(key);
  unsigned int count = 0;
  for (std::size_t face = 0; face < face_count; ++face) {
    std::array<std::int64_t, 3> place{position.x, position.y, position.z};
    place[face % 3] += stepAcross(face)[face % 3];
    if (place[face % 3] < 0 || place[face % 3] >= std::int64_t{1} << depth)
      continue;
    count += static_cast<unsigned int>(
        keys.count(mortonKey({static_cast<std::uint32_t>(place[0]),
                              static_cast<std::uint32_t>(place[1]),
                              static_cast<std::uint32_t>(place[2])})));
  }
  return count;
}

TEST(VoxelBlock, BlocksOfAFrameSeeAllNeighboursOfAGrid)
{
  std::mt19937_64 random(5);
  for (const unsigned int depth : {1u, 2u, 3u, 4u, 5u}) {
    const std::size_t cells = std::size_t{1} << (3 * depth);
    for (const std::size_t voxels : {std::size_t{1}, cells / 4 + 1, cells / 2, cells}) {
      const VoxelFrame frame =
          randomFrame(random, depth, std::min<std::size_t>(voxels, 4000));
      const std::set<std::uint64_t> keys(frame.keys.begin(), frame.keys.end());
      BlockList blocks;
      blocks.assign(frame.keys);
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        ASSERT_EQ(blocks.masks[i] & ~cellsInGrid(depth), 0u);
        Masks neighbours{};
        for (std::size_t face = 0; face < face_count; ++face) {
          std::uint64_t key = 0;
          if (!neighbourBlock(blocks.keys[i], face, levelsAboveBlocks(depth), key))
            continue;
          const auto found =
              std::lower_bound(blocks.keys.begin(), blocks.keys.end(), key);
          if (found != blocks.keys.end() && *found == key)
            neighbours[face] =
                blocks.masks[static_cast<std::size_t>(found - blocks.keys.begin())];
        }
        const NeighbourCounts counts = countNeighbours(blocks.masks[i], neighbours);
        for (unsigned int cell = 0; cell < block_cells; ++cell)
          if ((cellsInGrid(depth) >> cell & 1) != 0) {
            ASSERT_EQ(
                counts.of(cell),
                neighboursOf(blocks.keys[i] << block_key_bits | cell, keys, depth));
          }
      }
    }
  }
}

TEST(BlockList, HoldsTheVoxelsInOrder)
{
  std::mt19937_64 random(6);
  BlockList blocks;
  for (const unsigned int depth : {1u, 2u, 3u, 8u, 21u})
    for (const std::size_t count : {0u, 1u, 8u, 3000u}) {
      const VoxelFrame frame = randomFrame(
          random, depth, std::min(count, std::size_t{1} << std::min(3 * depth, 20u)));
      blocks.assign(frame.keys);
      EXPECT_EQ(blocks.voxelCount(), frame.size());
      std::size_t voxels = 0;
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        ASSERT_NE(blocks.masks[i], 0u);
        ASSERT_TRUE(i == 0 || blocks.keys[i] > blocks.keys[i - 1]);
        ASSERT_EQ(blocks.first_voxels[i], voxels);
        ASSERT_EQ(frame.keys[voxels] >> block_key_bits, blocks.keys[i]);
        voxels += pcl_ext::bitCount(blocks.masks[i]);
      }
      std::vector<std::uint64_t> keys{7, 8, 9};
      blocks.voxelKeys(keys);
      EXPECT_EQ(keys, frame.keys);
    }
  blocks.clear();
  EXPECT_EQ(blocks.size(), 0u);
  EXPECT_EQ(blocks.voxelCount(), 0u);
}

TEST(BlockList, LevelsAboveBlocks)
{
  EXPECT_EQ(levelsAboveBlocks(1), 0u);
  EXPECT_EQ(levelsAboveBlocks(2), 0u);
  EXPECT_EQ(levelsAboveBlocks(3), 1u);
  EXPECT_EQ(levelsAboveBlocks(21), 19u);
  EXPECT_EQ(cellsInGrid(1), 0xffu);
  EXPECT_EQ(cellsInGrid(2), ~std::uint64_t{0});
}

} // namespace

#include <pcl_ext/compression/voxel_grid.h>

#include "codec/published/occupancy_tree.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::published;
using namespace pcl_ext::io::test;

/** \brief A level of a simple octree: the occupancy of each node by its path from the root,
 * the first three bits highest. */
using NaiveLevel = std::map<std::uint64_t, std::uint8_t>;

std::vector<NaiveLevel>
naiveTree(const std::set<std::uint64_t>& keys, unsigned int depth)
{
  std::vector<NaiveLevel> levels(depth);
  for (const std::uint64_t key : keys) {
    const VoxelPosition position = voxelPosition(key);
    std::uint64_t path = 0;
    for (unsigned int level = 0; level < depth; ++level) {
      const unsigned int bit = depth - 1 - level;
      const unsigned int child = (position.x >> bit & 1) << 2 |
                                 (position.y >> bit & 1) << 1 | (position.z >> bit & 1);
      std::uint8_t& occupancy = levels[level][path];
      occupancy = static_cast<std::uint8_t>(occupancy | 1u << child);
      path = path << 3 | child;
    }
  }
  return levels;
}

std::size_t
nodeCount(const OccupancyTree& tree)
{
  std::size_t count = 0;
  for (unsigned int level = 0; level < tree.depth(); ++level)
    count += tree.level(level).size();
  return count;
}

void
expectTree(const OccupancyTree& tree, const std::vector<NaiveLevel>& expected)
{
  ASSERT_EQ(tree.depth(), expected.size());
  for (unsigned int level = 0; level < tree.depth(); ++level) {
    NaiveLevel found;
    const OccupancyLevel& built = tree.level(level);
    ASSERT_EQ(built.nodes.size(), built.occupancy.size());
    for (std::size_t i = 0; i < built.size(); ++i) {
      found[built.nodes[i]] = built.occupancy[i];
      EXPECT_TRUE(i == 0 || built.nodes[i - 1] < built.nodes[i]);
    }
    EXPECT_EQ(found, expected[level]) << "level " << level;
    EXPECT_EQ(built.size(), expected[level].size());
  }
}

std::set<std::uint64_t>
randomKeys(std::mt19937_64& random, unsigned int depth, std::size_t count)
{
  const std::uint64_t end = std::uint64_t{1} << (3 * depth);
  std::set<std::uint64_t> keys;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t key = below(random, end);
    keys.insert(key);
    if (i % 2 == 0) // neighbours, so that nodes have more than one child
      keys.insert(key ^ below(random, 64) % end);
  }
  return keys;
}

TEST(OccupancyTree, IsThatOfANaiveOctree)
{
  std::mt19937_64 random(1);
  OccupancyTree tree; // one for all, so that nothing of the last one may stay
  for (unsigned int depth = max_grid_depth; depth >= 1; --depth)
    for (const std::size_t count : {1u, 2u, 30u, 500u}) {
      const std::set<std::uint64_t> keys = randomKeys(random, depth, count);
      tree.build({keys.begin(), keys.end()}, depth);
      expectTree(tree, naiveTree(keys, depth));
    }
}

TEST(OccupancyTree, CornersAndFullTrees)
{
  OccupancyTree tree;
  for (unsigned int depth = 1; depth <= max_grid_depth; ++depth) {
    const std::uint64_t last = (std::uint64_t{1} << (3 * depth)) - 1;
    const std::set<std::uint64_t> corners{0, last};
    tree.build({0, last}, depth);
    expectTree(tree, naiveTree(corners, depth));
    EXPECT_EQ(tree.level(0).occupancy[0], 0x81);
  }
  std::set<std::uint64_t> full;
  for (std::uint64_t key = 0; key < 512; ++key)
    full.insert(key);
  tree.build({full.begin(), full.end()}, 3);
  expectTree(tree, naiveTree(full, 3));
  EXPECT_EQ(nodeCount(tree), 73u);
}

TEST(OccupancyTree, EmptyHasNoNodes)
{
  OccupancyTree tree;
  tree.build({1, 2, 3}, 7);
  EXPECT_GT(nodeCount(tree), 0u);
  tree.build({}, 5);
  EXPECT_EQ(tree.depth(), 5u);
  EXPECT_EQ(nodeCount(tree), 0u);
  tree.build({1, 2, 3}, 7);
  tree.reset(7);
  EXPECT_EQ(nodeCount(tree), 0u);
  for (unsigned int level = 0; level < 7; ++level)
    EXPECT_EQ(tree.level(level).size(), 0u);
}

TEST(OccupancyCursor, FindsTheOccupancyOfEachNode)
{
  std::mt19937_64 random(2);
  const std::set<std::uint64_t> keys = randomKeys(random, 6, 300);
  OccupancyTree tree;
  tree.build({keys.begin(), keys.end()}, 6);
  const std::vector<NaiveLevel> expected = naiveTree(keys, 6);
  for (unsigned int level = 0; level < 6; ++level)
    for (const std::uint64_t most : {1u, 3u, 40u}) {
      OccupancyCursor cursor(tree.level(level));
      const std::uint64_t end = std::uint64_t{1} << (3 * level);
      for (std::uint64_t node = 0; node < end + 5; node += below(random, most) + 1) {
        const auto there = expected[level].find(node);
        const std::uint8_t occupancy =
            there == expected[level].end() ? std::uint8_t{0} : there->second;
        ASSERT_EQ(cursor.occupancyOf(node), occupancy);
        ASSERT_EQ(cursor.occupancyOf(node), occupancy) << "asked again";
      }
    }
  EXPECT_EQ(OccupancyCursor().occupancyOf(0), 0);
  EXPECT_EQ(OccupancyCursor(OccupancyLevel()).occupancyOf(0), 0);
}

TEST(MaxBranchNodes, HasTheDocumentedBound)
{
  constexpr std::size_t few = std::size_t{1} << 20;
  for (unsigned int depth = 1; depth <= max_grid_depth; ++depth) {
    EXPECT_EQ(maxBranchNodes(0, depth), depth); // of a branch without voxels
    EXPECT_EQ(maxBranchNodes(1, depth), 2u * depth);
    EXPECT_EQ(maxBranchNodes(1000, depth), 1001u * depth);
    EXPECT_EQ(maxBranchNodes(few, depth), (few + 1) * depth);
    EXPECT_EQ(maxBranchNodes(few + 1, depth), (few + 1) * depth + 2);
    EXPECT_EQ(maxBranchNodes(std::size_t{1} << 24, depth),
              (few + 1) * depth + 30 * few);
    EXPECT_GE(maxBranchNodes(std::numeric_limits<std::size_t>::max(), depth),
              maxBranchNodes(std::size_t{1} << 30, depth));
  }
}

TEST(MaxBranchNodes, AllowsEveryTreeOfFewVoxels)
{
  std::mt19937_64 random(3);
  for (unsigned int depth = 1; depth <= max_grid_depth; ++depth) {
    const std::set<std::uint64_t> keys = randomKeys(random, depth, 200);
    OccupancyTree tree;
    tree.build({keys.begin(), keys.end()}, depth);
    EXPECT_LE(nodeCount(tree), maxBranchNodes(keys.size(), depth));
  }
}

} // namespace

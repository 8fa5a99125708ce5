#include "codec/context/node_blocks.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>
#include <set>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using namespace pcl_ext::io::test;

using Place = std::array<int, 3>;

/** \brief Nodes of a small grid, by their places, and the node blocks of the same nodes. */
class Nodes {
public:
  static constexpr unsigned int depth = 4; // of the nodes
  static constexpr int width = 1 << depth;

  explicit Nodes(std::mt19937_64& random)
  {
    for (std::uint64_t key = 0; key < std::uint64_t{1} << (3 * depth); ++key) {
      const std::uint64_t node_block = key >> block_key_bits;
      if (below(random, 4) == 0) {
        present_.insert(key);
        blocks_of_level_[blocks_of_level_.findOrAppend(node_block)].present |=
            std::uint64_t{1} << (key & 63);
      }
      if (key % 8 == 0 && below(random, 4) == 0) {
        pending_.insert(key >> 3);
        blocks_of_level_[blocks_of_level_.findOrAppend(node_block)].pending |=
            static_cast<std::uint8_t>(1u << (key >> 3 & 7));
      }
    }
  }

  NodeBlockLevel&
  node_blocks()
  {
    return blocks_of_level_;
  }

  bool
  isPresent(const Place& place) const
  {
    return isInGrid(place) && present_.count(keyOf(place)) != 0;
  }

  bool
  isPending(const Place& place) const
  {
    return isInGrid(place) && pending_.count(keyOf(place) >> 3) != 0 &&
           !isPresent(place);
  }

private:
  static bool
  isInGrid(const Place& place)
  {
    for (const int coordinate : place)
      if (coordinate < 0 || coordinate >= width)
        return false;
    return true;
  }

  static std::uint64_t
  keyOf(const Place& place)
  {
    return mortonKey({static_cast<std::uint32_t>(place[0]),
                      static_cast<std::uint32_t>(place[1]),
                      static_cast<std::uint32_t>(place[2])});
  }

  std::set<std::uint64_t> present_;
  std::set<std::uint64_t> pending_; // parents
  NodeBlockLevel blocks_of_level_;
};

/** \brief 3 present, 2 pending, 0 absent. */
unsigned int
stateOf(const Nodes& nodes, const Place& place)
{
  return nodes.isPresent(place) ? 3 : nodes.isPending(place) ? 2 : 0;
}

/** \brief The place next to a child outside its parent, along some axes at once.
 * \param[in] place of the child
 * \param[in] axes sum of 4, 2, 1 for x, y, z
 */
Place
outsidePlace(const Place& place, unsigned int axes)
{
  Place outside = place;
  for (unsigned int axis = 0; axis < 3; ++axis)
    if ((axes >> (2 - axis) & 1) != 0)
      outside[axis] += place[axis] % 2 == 0 ? -1 : 1;
  return outside;
}

/** \brief States of the nodes outside a child's parent, as NodeSurroundings has them. */
unsigned int
expectedOutside(const Nodes& nodes, const Place& place)
{
  unsigned int outside = 0;
  for (unsigned int axis = 0; axis < 3; ++axis) {
    unsigned int state = stateOf(nodes, outsidePlace(place, 4u >> axis));
    // The four nodes that share the parent's face: by the siblings on that side.
    for (unsigned int sibling = 0; sibling < 8 && state == 0; ++sibling) {
      Place other = place;
      for (unsigned int i = 0; i < 3; ++i)
        if (i != axis)
          other[i] = place[i] / 2 * 2 + static_cast<int>(sibling >> i & 1);
      state = nodes.isPresent(outsidePlace(other, 4u >> axis)) ? 1 : 0;
    }
    outside |= (state >> 1) << (5 - axis) | (state & 1) << (2 - axis);
  }
  return outside;
}

TEST(NodeBlocks, HaveTheSurroundingsOfTheirNodes)
{
  std::mt19937_64 random(1);
  Nodes nodes(random);
  NodeBlockCursor cursor(nodes.node_blocks(), Nodes::depth - block_levels);
  for (std::uint64_t parent = 0; parent < std::uint64_t{1} << (3 * Nodes::depth - 3);
       ++parent) {
    const std::uint32_t node_block = nodes.node_blocks().find(parent >> 3);
    ASSERT_NE(node_block, BlockDirectory::not_found);
    cursor.moveTo(parent >> 3, node_block);
    const auto octant = static_cast<unsigned int>(parent & 7);
    const NodeSurroundings around = cursor.around<true>(octant);
    const NodeSurroundings across_faces = cursor.around<false>(octant);
    EXPECT_EQ(across_faces.outside, around.outside);
    EXPECT_EQ(across_faces.nodes, around.nodes);
    EXPECT_EQ(across_faces.beyond, 0u);
    for (unsigned int child = 0; child < 8; ++child) {
      const VoxelPosition at = voxelPosition(parent << 3 | child);
      const Place place = {
          static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)};
      ASSERT_EQ((around.nodes >> child & 1) != 0, nodes.isPresent(place));
      ASSERT_EQ(around.outside >> (8 * child) & 0xff, expectedOutside(nodes, place));
      unsigned int beyond = 0;
      for (const unsigned int axes : {6u, 5u, 3u, 7u})
        beyond = beyond << 1 | (stateOf(nodes, outsidePlace(place, axes)) != 0 ? 1 : 0);
      ASSERT_EQ(around.beyond >> (8 * child) & 0xff, beyond);
    }
  }
}

TEST(NodeBlocks, BytesOfBits)
{
  for (unsigned int bits = 0; bits < 256; ++bits)
    for (unsigned int bit = 0; bit < 8; ++bit)
      ASSERT_EQ(bytesOfBits(bits) >> (8 * bit) & 0xff, bits >> bit & 1);
}

} // namespace

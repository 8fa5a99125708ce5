#include "codec/context/tiles.h"
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

/** \brief Nodes of a small grid, by their places, and the tiles of the same nodes. */
class Nodes {
public:
  static constexpr unsigned int depth = 4; // of the nodes
  static constexpr int width = 1 << depth;

  explicit Nodes(std::mt19937_64& random)
  {
    for (std::uint64_t key = 0; key < std::uint64_t{1} << (3 * depth); ++key) {
      const std::uint64_t tile = key >> block_key_bits;
      if (below(random, 4) == 0) {
        present_.insert(key);
        tiles_[tiles_.findOrAppend(tile)].present |= std::uint64_t{1} << (key & 63);
      }
      if (key % 8 == 0 && below(random, 4) == 0) {
        pending_.insert(key >> 3);
        tiles_[tiles_.findOrAppend(tile)].pending |=
            static_cast<std::uint8_t>(1u << (key >> 3 & 7));
      }
    }
  }

  TileLevel&
  tiles()
  {
    return tiles_;
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
  TileLevel tiles_;
};

TEST(Tiles, WindowsHaveTheNodesAroundAnOctant)
{
  std::mt19937_64 random(1);
  Nodes nodes(random);
  TileCursor cursor(nodes.tiles(), Nodes::depth - block_levels);
  for (std::uint64_t parent = 0; parent < std::uint64_t{1} << (3 * Nodes::depth - 3);
       ++parent) {
    const std::uint32_t tile = nodes.tiles().find(parent >> 3);
    ASSERT_NE(tile, BlockDirectory::not_found);
    cursor.moveTo(parent >> 3, tile);
    const auto octant = static_cast<unsigned int>(parent & 7);
    const OctantWindow window = cursor.window<true>(octant);
    const VoxelPosition first = voxelPosition(parent << 3);
    for (unsigned int x = 0; x < 4; ++x)
      for (unsigned int y = 0; y < 4; ++y)
        for (unsigned int z = 0; z < 4; ++z) {
          const Place place = {static_cast<int>(first.x + x) - 1,
                               static_cast<int>(first.y + y) - 1,
                               static_cast<int>(first.z + z) - 1};
          const unsigned int bit = windowPlace(x, y, z);
          ASSERT_EQ((window.present >> bit & 1) != 0, nodes.isPresent(place));
          ASSERT_EQ((window.pending >> bit & 1) != 0, nodes.isPending(place));
          const bool is_inside =
              x - 1 < 2 && y - 1 < 2 && z - 1 < 2; // unsigned: 0 is outside
          if (is_inside) {
            ASSERT_EQ((window.nodes >> ((x - 1) * 4 + (y - 1) * 2 + (z - 1)) & 1) != 0,
                      nodes.isPresent(place));
          }
        }
  }
}

TEST(Tiles, WindowsWithoutEdgesHaveTheNodesAcrossFaces)
{
  std::mt19937_64 random(2);
  Nodes nodes(random);
  TileCursor cursor(nodes.tiles(), Nodes::depth - block_levels);
  for (std::uint64_t parent = 0; parent < std::uint64_t{1} << (3 * Nodes::depth - 3);
       ++parent) {
    cursor.moveTo(parent >> 3, nodes.tiles().find(parent >> 3));
    const auto octant = static_cast<unsigned int>(parent & 7);
    const OctantWindow whole = cursor.window<true>(octant);
    const OctantWindow window = cursor.window<false>(octant);
    for (unsigned int child = 0; child < 8; ++child)
      for (const unsigned int place : window_places[child].faces) {
        ASSERT_EQ(window.present >> place & 1, whole.present >> place & 1);
        ASSERT_EQ(window.pending >> place & 1, whole.pending >> place & 1);
      }
    ASSERT_EQ(wallsOf(window.present), wallsOf(whole.present));
  }
}

TEST(Tiles, WallsAreFoundByAnyOfTheirNodes)
{
  for (unsigned int place = 0; place < block_cells; ++place) {
    const std::uint64_t walls = wallsOf(std::uint64_t{1} << place);
    const bool is_beside_a_face = walls != 0;
    // One coordinate of a wall's node is 0 or 3, and the other two are 1 or 2.
    unsigned int outside = 0;
    for (const unsigned int axis : {2u, 1u, 0u}) {
      const unsigned int coordinate =
          (place >> (axis + 3) & 1) * 2 + (place >> axis & 1);
      outside += coordinate == 0 || coordinate == 3 ? 1 : 0;
    }
    EXPECT_EQ(is_beside_a_face, outside == 1) << place;
    if (is_beside_a_face) {
      EXPECT_EQ(pcl_ext::bitCount(walls), 4u);
      EXPECT_NE(walls >> place & 1, 0u);
    }
  }
}

TEST(Tiles, CellsOfOctants)
{
  for (unsigned int octants = 0; octants < 256; ++octants) {
    const std::uint64_t cells = cellsOfOctants(static_cast<std::uint8_t>(octants));
    for (unsigned int cell = 0; cell < block_cells; ++cell)
      ASSERT_EQ(cells >> cell & 1, octants >> (cell / 8) & 1);
  }
}

} // namespace

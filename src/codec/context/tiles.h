#pragma once

#include "bytes/reserve_ahead.h"
#include "simd/bit_operations.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief 4 x 4 x 4 nodes of one octree level, the grandchildren of one node: a block where
 * the nodes are voxels. Nodes are numbered as the cells of a block. */
struct Tile {
  std::uint64_t present = 0; ///< nodes that have voxels, as far as they are coded
  std::uint8_t pending = 0;  ///< octants whose nodes will be coded
};

/** \brief The tiles of one level while its nodes are coded. Kept so that its memory is
 * reused. */
class TileLevel {
public:
  /** \brief Removes all tiles.
   * \param[in] expected_tiles to be added, if that is known
   */
  void
  clear(std::size_t expected_tiles = 0)
  {
    directory_.clear(expected_tiles);
    tiles_.clear();
    last_key_ = no_key;
  }

  /** \brief Allocates memory for a number of further tiles at once. */
  void
  reserveFor(std::size_t further_tiles)
  {
    directory_.reserveFor(further_tiles);
    reserveAhead(tiles_, tiles_.size() + further_tiles);
  }

  /** \brief Adds a tile that is not there yet.
   * \return its index, the number of tiles so far
   */
  std::uint32_t
  append(std::uint64_t key)
  {
    directory_.insert(key);
    tiles_.emplace_back();
    last_key_ = key;
    return static_cast<std::uint32_t>(tiles_.size() - 1);
  }

  /** \brief The tile that was added last if it has a key, else a new one. */
  Tile&
  lastOrNew(std::uint64_t key)
  {
    if (key != last_key_)
      append(key);
    return tiles_.back();
  }

  /** \brief Index of a tile, which is added if it is not there. */
  std::uint32_t
  findOrAppend(std::uint64_t key)
  {
    const std::uint32_t index = find(key);
    return index != BlockDirectory::not_found ? index : append(key);
  }

  /** \brief Index of a tile, or BlockDirectory::not_found. */
  std::uint32_t
  find(std::uint64_t key) const
  {
    return directory_.find(key);
  }

  Tile&
  operator[](std::size_t index)
  {
    return tiles_[index];
  }

  const Tile&
  operator[](std::size_t index) const
  {
    return tiles_[index];
  }

private:
  static constexpr std::uint64_t no_key = ~std::uint64_t{0};

  BlockDirectory directory_;
  std::vector<Tile> tiles_;
  std::uint64_t last_key_ = no_key;
};

/** \brief Children of a node whose coordinate on an axis is the lower one, a mask.
 * \param[in] axis 4, 2, 1 for x, y, z
 */
constexpr unsigned int
lowerChildren(unsigned int axis)
{
  return axis == 4 ? 0x0f : axis == 2 ? 0x33 : 0x55;
}

/** \brief Exchanges the lower and the upper children on some axes.
 * \tparam Axes sum of 4, 2, 1 for x, y, z
 * \param[in] children a mask
 */
template <unsigned int Axes>
PCL_EXT_ALWAYS_INLINE constexpr unsigned int
exchanged(unsigned int children)
{
  const auto exchange = [&](unsigned int axis) {
    if ((Axes & axis) != 0)
      children = (children >> axis & lowerChildren(axis)) |
                 (children << axis & 0xff & ~lowerChildren(axis));
  };
  exchange(4);
  exchange(2);
  exchange(1);
  return children;
}

/** \brief A byte for each bit of a byte, 0 or 1, the lowest first. */
constexpr std::uint64_t
bytesOfBits(unsigned int bits)
{
  constexpr std::uint64_t ones = 0x0101010101010101;
  // Bit i of byte i is kept, and carried to the top of the byte.
  const std::uint64_t own = bits * ones & 0x8040201008040201;
  return (own + 0x7f * ones) >> 7 & ones;
}

/** \brief What is around the eight children of a node, a byte for each child. */
struct NodeSurroundings {
  /** \brief 8 H + G of the three nodes across its faces outside its parent, that along x
   * the highest: H and G are the bits of 3 present, 2 pending, 1 absent where one of the four
   * nodes that share the parent's face is present, 0. */
  std::uint64_t outside = 0;
  /** \brief 8, 4, 2, 1 for the nodes outside its parent in x and y, in x and z, in y and z
   * and in all three, where present or pending. */
  std::uint64_t beyond = 0;
  unsigned int nodes = 0; ///< children that are present, a mask
};

/** \brief A tile of a level and those around it, of which each is looked up once. */
class TileCursor {
public:
  /** \param[in] tiles of the level
   * \param[in] levels octree levels above the tiles, 0..19
   */
  TileCursor(TileLevel& tiles, unsigned int levels) : tiles_(tiles), levels_(levels) {}

  /** \brief Moves to a tile of the level. */
  void
  moveTo(std::uint64_t key, std::uint32_t index)
  {
    if (index == index_)
      return;
    key_ = key;
    index_ = index;
    fetched_ = 0;
  }

  /** \brief Ends the coding of an octant of the tile.
   * \param[in] octant 0..7
   * \param[in] children its nodes that have new voxels, a mask
   */
  void
  setChildren(unsigned int octant, unsigned int children)
  {
    Tile& tile = tiles_[index_];
    tile.present |= std::uint64_t{children} << (8 * octant);
    tile.pending &= static_cast<std::uint8_t>(~(1u << octant));
  }

  /** \brief What is around the nodes of an octant of the tile.
   * \param[in] octant 0..7
   * \tparam HasBeyond whether NodeSurroundings::beyond is needed; else it is 0
   */
  template <bool HasBeyond>
  NodeSurroundings
  around(unsigned int octant)
  {
    // By axes on which they are beside this one, on the octant's side: 4 x, 2 y, 1 z.
    std::array<Tile, 8> tiles{};
    tiles[0] = tiles_[index_];
    for (const unsigned int beside : {1u, 2u, 4u, 3u, 5u, 6u, 7u}) {
      if (!HasBeyond && beside == 3)
        break;
      tiles[beside] = tileBeside(octant, beside);
    }
    NodeSurroundings around;
    around.nodes = presentOf(tiles[0], octant);
    addOutside<4>(octant, tiles, around);
    addOutside<2>(octant, tiles, around);
    addOutside<1>(octant, tiles, around);
    if constexpr (HasBeyond)
      around.beyond = 8 * bytesOfBits(across<6>(octant, tiles, notAbsentOf)) |
                      4 * bytesOfBits(across<5>(octant, tiles, notAbsentOf)) |
                      2 * bytesOfBits(across<3>(octant, tiles, notAbsentOf)) |
                      bytesOfBits(across<7>(octant, tiles, notAbsentOf));
    return around;
  }

private:
  /** \brief The present nodes of an octant, a mask. */
  static unsigned int
  presentOf(const Tile& tile, unsigned int octant)
  {
    return static_cast<unsigned int>(tile.present >> (8 * octant) & 0xff);
  }

  /** \brief The present and the pending nodes of an octant, a mask. */
  static unsigned int
  notAbsentOf(const Tile& tile, unsigned int octant)
  {
    return presentOf(tile, octant) | ((tile.pending >> octant & 1u) * 0xff);
  }

  /** \brief Adds the states of the nodes along an axis to NodeSurroundings::outside. */
  template <unsigned int Axis>
  PCL_EXT_ALWAYS_INLINE static void
  addOutside(unsigned int octant,
             const std::array<Tile, 8>& tiles,
             NodeSurroundings& around)
  {
    constexpr unsigned int lower = lowerChildren(Axis);
    constexpr unsigned int upper = 0xff & ~lower;
    const unsigned int present = across<Axis>(octant, tiles, presentOf);
    const unsigned int not_absent = across<Axis>(octant, tiles, notAbsentOf);
    const unsigned int beside_present =
        ((present & lower) != 0 ? lower : 0) | ((present & upper) != 0 ? upper : 0);
    const unsigned int low = present | (beside_present & ~not_absent);
    around.outside |= bytesOfBits(not_absent) * (8 * Axis) | bytesOfBits(low) * Axis;
  }

  /** \brief For the nodes of an octant whether the next one outside their parent, along some
   * axes at once, is in a set.
   * \tparam Axes sum of 4, 2, 1 for x, y, z
   * \param[in] nodes_of the set's nodes of an octant of a tile
   */
  template <unsigned int Axes, typename NodesOfT>
  PCL_EXT_ALWAYS_INLINE static unsigned int
  across(unsigned int octant, const std::array<Tile, 8>& tiles, NodesOfT&& nodes_of)
  {
    return acrossFrom<Axes, Axes>(octant, 0, 0xff, tiles, nodes_of);
  }

  /** \brief The same for some of the children, whose nodes are in a tile beside this one as
   * far as the axes are decided. */
  template <unsigned int Axes, unsigned int UndecidedAxes, typename NodesOfT>
  PCL_EXT_ALWAYS_INLINE static unsigned int
  acrossFrom(unsigned int octant,
             unsigned int beside,
             unsigned int children,
             const std::array<Tile, 8>& tiles,
             NodesOfT&& nodes_of)
  {
    if constexpr (UndecidedAxes == 0)
      return children & exchanged<Axes>(nodes_of(tiles[beside], octant ^ Axes));
    else {
      constexpr unsigned int axis = UndecidedAxes >= 4 ? 4 : UndecidedAxes >= 2 ? 2 : 1;
      constexpr unsigned int lower = lowerChildren(axis);
      // The node is in the tile beside this one for the children on the octant's side.
      const unsigned int near = (octant & axis) != 0 ? ~lower : lower;
      return acrossFrom<Axes, UndecidedAxes - axis>(
                 octant, beside | axis, children & near, tiles, nodes_of) |
             acrossFrom<Axes, UndecidedAxes - axis>(
                 octant, beside, children & ~near, tiles, nodes_of);
    }
  }

  Tile
  tileBeside(unsigned int octant, unsigned int beside)
  {
    // Slots by 9 x + 3 y + z, each 0 at the lower side, 1 in the middle, 2 at the upper side.
    const auto side = [&](unsigned int bit) {
      return (beside & bit) == 0 ? 1u : (octant & bit) != 0 ? 2u : 0u;
    };
    const unsigned int slot = 9 * side(4) + 3 * side(2) + side(1);
    if ((fetched_ >> slot & 1) == 0) {
      fetched_ |= 1u << slot;
      slots_[slot] = find(octant, beside);
    }
    return slots_[slot] == BlockDirectory::not_found ? Tile() : tiles_[slots_[slot]];
  }

  /** \brief Index of the tile beside this one, or not_found. */
  std::uint32_t
  find(unsigned int octant, unsigned int beside) const
  {
    std::uint64_t key = key_;
    for (std::size_t face = 0; face < 3; ++face) {
      const unsigned int axis = 4u >> face;
      if ((beside & axis) != 0 &&
          !neighbourBlock(key, (octant & axis) != 0 ? face + 3 : face, levels_, key))
        return BlockDirectory::not_found;
    }
    return tiles_.find(key);
  }

  TileLevel& tiles_;
  unsigned int levels_;
  std::uint64_t key_ = 0;
  std::uint32_t index_ = BlockDirectory::not_found;
  std::uint32_t fetched_ = 0; // slots that were looked up
  std::array<std::uint32_t, 27> slots_{};
};

} // namespace context
} // namespace io
} // namespace pcl_ext

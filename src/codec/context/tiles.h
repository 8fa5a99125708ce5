#pragma once

#include "bytes/reserve_ahead.h"
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

/** \brief The cells of the octants of a mask. */
constexpr std::uint64_t
cellsOfOctants(std::uint8_t octants)
{
  // Seven copies side by side have bit o at bit 8 o; 0xff times that fills the octant.
  constexpr std::uint64_t copies = 0x0002040810204081;
  constexpr std::uint64_t lowest = 0x0101010101010101;
  return (((octants & 0x7f) * copies & lowest) | std::uint64_t{octants} >> 7 << 56) *
         0xff;
}

/** \brief An octant of a tile, which is a node's children, with the nodes around it: 4 x 4 x 4
 * nodes, those of the octant in the middle. */
struct OctantWindow {
  std::uint64_t present = 0; ///< nodes that have voxels
  std::uint64_t pending = 0; ///< others that will be coded
  unsigned int nodes = 0;    ///< present ones of the octant
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

  /** \brief The nodes around an octant of the tile.
   * \param[in] octant 0..7
   * \tparam HasEdges also those beyond the edges and corners of the tile; else they count
   * as absent
   */
  template <bool HasEdges>
  OctantWindow
  window(unsigned int octant)
  {
    // By bits: 4 the tile beside this one along x, 2 y, 1 z, on the octant's side.
    std::array<Tile, 8> tiles{};
    tiles[0] = tiles_[index_];
    for (const unsigned int beside : {1u, 2u, 4u, 3u, 5u, 6u, 7u}) {
      if (!HasEdges && beside == 3)
        break;
      tiles[beside] = tileBeside(octant, beside);
    }
    OctantWindow window;
    window.nodes = static_cast<unsigned int>(tiles[0].present >> (8 * octant) & 0xff);
    std::array<std::uint64_t, 8> masks;
    for (unsigned int i = 0; i < 8; ++i)
      masks[i] = tiles[i].present;
    window.present = shifted(octant, masks);
    for (unsigned int i = 0; i < 8; ++i)
      masks[i] = cellsOfOctants(tiles[i].pending);
    window.pending = shifted(octant, masks) & ~window.present;
    return window;
  }

private:
  /** \brief The part of a tile and those beside it that is an octant's window. */
  static std::uint64_t
  shifted(unsigned int octant, const std::array<std::uint64_t, 8>& masks)
  {
    const auto along =
        [&](unsigned int axis, std::uint64_t mask, std::uint64_t beside) {
          return (octant & (4u >> axis)) != 0 ? occupiedAcross(mask, beside, axis + 3)
                                              : occupiedAcross(mask, beside, axis);
        };
    const auto row = [&](unsigned int i) { return along(2, masks[i], masks[i | 1]); };
    const auto column = [&](unsigned int i) { return along(1, row(i), row(i | 2)); };
    return along(0, column(0), column(4));
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
      slots_[slot] = BlockDirectory::not_found;
      std::uint64_t key = key_;
      bool exists = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        if ((beside >> (2 - axis) & 1) != 0)
          exists =
              exists &&
              neighbourBlock(
                  key, (octant >> (2 - axis) & 1) != 0 ? axis + 3 : axis, levels_, key);
      if (exists)
        slots_[slot] = tiles_.find(key);
    }
    return slots_[slot] == BlockDirectory::not_found ? Tile() : tiles_[slots_[slot]];
  }

  TileLevel& tiles_;
  unsigned int levels_;
  std::uint64_t key_ = 0;
  std::uint32_t index_ = BlockDirectory::not_found;
  std::uint32_t fetched_ = 0; // slots that were looked up
  std::array<std::uint32_t, 27> slots_{};
};

/** \brief Bit of a node in a window by its coordinates, 0..3. */
constexpr unsigned int
windowPlace(unsigned int x, unsigned int y, unsigned int z)
{
  return (x >> 1) << 5 | (y >> 1) << 4 | (z >> 1) << 3 | (x & 1) << 2 | (y & 1) << 1 |
         (z & 1);
}

/** \brief Places in a window of the nodes beside a child and outside its parent. */
struct WindowPlaces {
  std::array<std::uint8_t, 3> faces; ///< along x, y, z
  std::array<std::uint8_t, 3> edges; ///< along x and y, x and z, y and z
  std::uint8_t corner;
};

constexpr std::array<WindowPlaces, 8>
makeWindowPlaces()
{
  std::array<WindowPlaces, 8> places{};
  for (unsigned int child = 0; child < 8; ++child) {
    const std::array<unsigned int, 3> in = {
        1 + (child >> 2 & 1), 1 + (child >> 1 & 1), 1 + (child & 1)};
    const std::array<unsigned int, 3> out = {
        (child >> 2 & 1) * 3, (child >> 1 & 1) * 3, (child & 1) * 3};
    const auto place = [](unsigned int x, unsigned int y, unsigned int z) {
      return static_cast<std::uint8_t>(windowPlace(x, y, z));
    };
    places[child].faces = {place(out[0], in[1], in[2]),
                           place(in[0], out[1], in[2]),
                           place(in[0], in[1], out[2])};
    places[child].edges = {place(out[0], out[1], in[2]),
                           place(out[0], in[1], out[2]),
                           place(in[0], out[1], out[2])};
    places[child].corner = place(out[0], out[1], out[2]);
  }
  return places;
}

inline constexpr std::array<WindowPlaces, 8> window_places = makeWindowPlaces();

/** \brief By face: the four nodes of a window that touch the octant in the middle. */
constexpr std::array<std::uint64_t, face_count>
makeWalls()
{
  std::array<std::uint64_t, face_count> walls{};
  for (unsigned int i = 1; i < 3; ++i)
    for (unsigned int j = 1; j < 3; ++j)
      for (unsigned int side = 0; side < 2; ++side) {
        walls[3 * side] |= std::uint64_t{1} << windowPlace(3 * side, i, j);
        walls[3 * side + 1] |= std::uint64_t{1} << windowPlace(i, 3 * side, j);
        walls[3 * side + 2] |= std::uint64_t{1} << windowPlace(i, j, 3 * side);
      }
  return walls;
}

/** \brief The walls of a window of which a node is present. */
inline std::uint64_t
wallsOf(std::uint64_t present)
{
  constexpr std::array<std::uint64_t, face_count> walls = makeWalls();
  std::uint64_t found = 0;
  for (const std::uint64_t wall : walls)
    found |= wall & (0 - std::uint64_t{isNotZero(present & wall)});
  return found;
}

/** \brief Number of bits of 0..7. */
inline constexpr std::array<std::uint8_t, 8> bit_counts = {0, 1, 1, 2, 1, 2, 2, 3};

} // namespace context
} // namespace io
} // namespace pcl_ext

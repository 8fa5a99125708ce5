// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

class OctantList;

/** \brief A block is 4 x 4 x 4 voxels, the two lowest levels of the octree. The low six
 * bits of a voxel's Morton key are its cell in the block, and cell c is bit c of a
 * mask. */
constexpr unsigned int block_key_bits = 6;
constexpr unsigned int block_levels = 2;
constexpr unsigned int block_cells = 64;

/** \brief Levels of the octree above the blocks in a grid of some depth. A grid of one
 * level is the lowest octant of a single block. */
constexpr unsigned int
levelsAboveBlocks(unsigned int grid_depth)
{
  return grid_depth > block_levels ? grid_depth - block_levels : 0;
}

/** \brief The cells of a block that are in a grid of some depth: all, or one octant. */
constexpr std::uint64_t
cellsInGrid(unsigned int grid_depth)
{
  return grid_depth >= block_levels ? ~std::uint64_t{0} : std::uint64_t{0xff};
}

/** \brief The octants of a block that have occupied cells. */
constexpr unsigned int
occupiedOctants(std::uint64_t cells)
{
  constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7f;
  const std::uint64_t high = (((cells & low) + low) | cells) & ~low;
  return static_cast<unsigned int>((high >> 7) * 0x0102040810204080 >> 56);
}

/** \brief Number of blocks of ascending voxels. */
std::size_t
countBlocks(const std::vector<std::uint64_t>& voxel_keys);

/** \brief Groups ascending voxels into blocks.
 * \param[out] keys,masks of the blocks, ascending; memory for countBlocks() of them
 * \return number of blocks
 */
std::size_t
collectBlocks(const std::vector<std::uint64_t>& voxel_keys,
              std::uint64_t* keys,
              std::uint64_t* masks);

/** \brief The blocks of one frame, ascending; their voxels are in Morton order. */
struct BlockList {
  std::vector<std::uint64_t> keys;         ///< Morton keys of the blocks
  std::vector<std::uint64_t> masks;        ///< occupied cells, never 0
  std::vector<std::uint32_t> first_voxels; ///< index of a block's first voxel

  std::size_t
  size() const
  {
    return keys.size();
  }

  /** \brief Number of voxels in all blocks. */
  std::size_t
  voxelCount() const
  {
    return size() == 0 ? 0 : first_voxels.back() + bitCount(masks.back());
  }

  void
  clear();

  /** \brief Appends a block with a key above all others.
   * \param[in] key Morton key of the block
   * \param[in] mask its cells, not 0
   * \param[in] first_voxel number of voxels in the blocks before it
   */
  void
  append(std::uint64_t key, std::uint64_t mask, std::uint32_t first_voxel);

  /** \brief Sets the blocks to those of ascending voxel keys. */
  void
  assign(const std::vector<std::uint64_t>& voxel_keys);

  /** \brief Lists the voxel keys of the blocks, ascending.
   * \param[out] octants scratch memory
   */
  void
  voxelKeys(OctantList& octants, std::vector<std::uint64_t>& voxel_keys) const;
};

/** \brief Face neighbours in the order -x, -y, -z, +x, +y, +z. */
constexpr std::size_t face_count = 6;

/** \brief Key of the block that shares a face with a block.
 * \param[in] key Morton key of the block, below 2^(3 levels)
 * \param[in] face 0..5
 * \param[in] levels octree levels above the blocks, 0..19
 * \param[out] neighbour key of the neighbour
 * \return false if the block is at that face of the grid
 */
inline bool
neighbourBlock(std::uint64_t key,
               std::size_t face,
               unsigned int levels,
               std::uint64_t& neighbour)
{
  // Bits of x, y and z; x is the highest of each three.
  constexpr std::array<std::uint64_t, 3> axis_bits = {
      0x4924924924924924, 0x2492492492492492, 0x9249249249249249};
  const bool is_below = face < 3;
  const std::size_t axis_index = is_below ? face : face - 3;
  const std::uint64_t axis =
      axis_bits[axis_index] & ((std::uint64_t{1} << (3 * levels)) - 1);
  const std::uint64_t one = std::uint64_t{4} >> axis_index;
  const std::uint64_t position = key & axis;
  // Carries and borrows pass the bits of the other axes, which are 1 for the sum and 0
  // for the difference.
  const std::uint64_t moved =
      is_below ? (position - one) & axis : ((position | ~axis) + one) & axis;
  neighbour = moved | (key & ~axis);
  return position != (is_below ? 0 : axis);
}

/** \brief By axis and bit: the cells with the low (0) or high (1) bit of the coordinate
 * set. */
constexpr std::array<std::array<std::uint64_t, 2>, 3>
makeCellsWithBit()
{
  std::array<std::array<std::uint64_t, 2>, 3> cells{};
  for (unsigned int axis = 0; axis < 3; ++axis)
    for (unsigned int level = 0; level < 2; ++level)
      for (unsigned int cell = 0; cell < block_cells; ++cell)
        if ((cell >> (3 * level + 2 - axis) & 1) != 0)
          cells[axis][level] |= std::uint64_t{1} << cell;
  return cells;
}

inline constexpr auto cells_with_bit = makeCellsWithBit();

/** \brief For each cell of a block whether its neighbour across a face is occupied.
 * \param[in] mask the block's occupied cells
 * \param[in] neighbour those of the block across that face, 0 if there is none
 * \param[in] face 0..5
 */
PCL_EXT_ALWAYS_INLINE constexpr std::uint64_t
occupiedAcross(std::uint64_t mask, std::uint64_t neighbour, std::size_t face)
{
  const std::size_t axis = face % 3;
  const std::uint64_t low = cells_with_bit[axis][0];
  const std::uint64_t high = cells_with_bit[axis][1];
  // Difference of cell numbers for a coordinate's low and high bit.
  const unsigned int low_bit = 4u >> axis;
  const unsigned int high_bit = 8 * low_bit;
  if (face < 3)
    return (mask << low_bit & low) | (mask << (high_bit - low_bit) & high & ~low) |
           (neighbour >> (high_bit + low_bit) & ~high & ~low);
  return (mask >> low_bit & ~low) | (mask >> (high_bit - low_bit) & ~high & low) |
         (neighbour << (high_bit + low_bit) & high & low);
}

/** \brief The cells of a block that share a face with an occupied one of the block. */
constexpr std::uint64_t
cellsBeside(std::uint64_t cells)
{
  return occupiedAcross(cells, 0, 0) | occupiedAcross(cells, 0, 1) |
         occupiedAcross(cells, 0, 2) | occupiedAcross(cells, 0, 3) |
         occupiedAcross(cells, 0, 4) | occupiedAcross(cells, 0, 5);
}

/** \brief The same for single cells. */
constexpr std::array<std::uint64_t, block_cells>
makeCellsBeside()
{
  std::array<std::uint64_t, block_cells> cells{};
  for (unsigned int cell = 0; cell < block_cells; ++cell)
    cells[cell] = cellsBeside(std::uint64_t{1} << cell);
  return cells;
}

inline constexpr std::array<std::uint64_t, block_cells> cells_beside =
    makeCellsBeside();

/** \brief Number of occupied face neighbours, 0..6, of each cell of a block: the three
 * masks have one bit of the number each, lowest first. */
struct NeighbourCounts {
  std::array<std::uint64_t, 3> bits{};

  /** \brief Number of one cell, 0..6. */
  unsigned int
  of(unsigned int cell) const
  {
    return static_cast<unsigned int>((bits[0] >> cell & 1) |
                                     (bits[1] >> cell & 1) << 1 |
                                     (bits[2] >> cell & 1) << 2);
  }

  /** \brief The cells with a number of occupied neighbours, 0..6. */
  std::uint64_t
  cellsWith(std::uint32_t count) const
  {
    const auto bit = [&](unsigned int index) {
      return (count >> index & 1) != 0 ? bits[index] : ~bits[index];
    };
    return bit(0) & bit(1) & bit(2);
  }
};

/** \brief Counts the occupied neighbours of all cells.
 * \param[in] mask the block's occupied cells
 * \param[in] neighbours those of the six blocks around it
 */
NeighbourCounts
countNeighbours(std::uint64_t mask,
                const std::array<std::uint64_t, face_count>& neighbours);

} // namespace pcl_ext::PCL_EXT_ABI::io

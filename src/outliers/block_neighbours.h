// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief By axis, coordinate and whether a face is crossed: the cells of a block that
 * are at most one voxel away from a cell along the axis, of its own block or of the
 * next one. */
using CellsNear = std::array<std::array<std::array<std::uint64_t, 2>, 4>, 3>;

constexpr CellsNear
makeCellsNear()
{
  CellsNear cells{};
  for (unsigned int axis = 0; axis < 3; ++axis)
    for (unsigned int from = 0; from < 4; ++from)
      for (unsigned int cell = 0; cell < io::block_cells; ++cell) {
        const unsigned int to =
            (cell >> (5 - axis) & 1) << 1 | (cell >> (2 - axis) & 1);
        const std::uint64_t bit = std::uint64_t{1} << cell;
        cells[axis][from][0] |= to + 1 >= from && to <= from + 1 ? bit : 0;
        cells[axis][from][1] |=
            (from == 0 && to == 3) || (from == 3 && to == 0) ? bit : 0;
      }
  return cells;
}

inline constexpr CellsNear cells_near = makeCellsNear();

/** \brief Finds the blocks around a block. What is counted there is a set of voxels: a
 * mask for each block, in the order of the blocks. Blocks are found by the node blocks
 * that they are in, which are so few that they stay in the processor's cache. */
class BlocksAround {
public:
  /** \brief Sets the blocks.
   * \param[in] keys Morton keys of the blocks, ascending
   * \param[in] depth of the grid of their voxels
   */
  void
  assign(const std::vector<std::uint64_t>& keys, unsigned int depth)
  {
    levels_ = io::levelsAboveBlocks(depth);
    nodes_.assign(keys);
    directory_.assign(nodes_.keys);
  }

  /** \brief The cells of a block that are in a set. */
  std::uint64_t
  maskOf(const std::vector<std::uint64_t>& set, std::uint64_t block) const
  {
    const std::uint32_t node = directory_.find(block >> io::block_key_bits);
    if (node == io::BlockDirectory::not_found)
      return 0;
    const std::uint64_t bit = std::uint64_t{1} << block % io::block_cells;
    const std::uint64_t blocks = nodes_.masks[node];
    return (blocks & bit) == 0
               ? 0
               : set[nodes_.first_voxels[node] + bitCount(blocks & (bit - 1))];
  }

  /** \brief Number of the 26 voxels around a voxel that are in a set.
   * \param[in] own the cells of the voxel's block that are in the set
   * \param[in] key of the voxel
   * \param[in] enough counting ends when it has reached this number
   */
  unsigned int
  count(const std::vector<std::uint64_t>& set,
        std::uint64_t own,
        std::uint64_t key,
        unsigned int enough) const
  {
    const std::uint64_t block = key >> io::block_key_bits;
    const auto cell = static_cast<unsigned int>(key % io::block_cells);
    const std::array<unsigned int, 3> at = {(cell >> 5 & 1) << 1 | (cell >> 2 & 1),
                                            (cell >> 4 & 1) << 1 | (cell >> 1 & 1),
                                            (cell >> 3 & 1) << 1 | (cell & 1)};
    unsigned int number =
        bitCount(own & ~(std::uint64_t{1} << cell) & cells_near[0][at[0]][0] &
                 cells_near[1][at[1]][0] & cells_near[2][at[2]][0]);
    if (number >= enough)
      return number;
    // A bit for each axis on which the next block is near, and how its key differs.
    unsigned int edges = 0;
    std::array<std::uint64_t, 3> differences{};
    for (unsigned int axis = 0; axis < 3; ++axis) {
      std::uint64_t next = block;
      if ((at[axis] == 0 && io::neighbourBlock(block, axis, levels_, next)) ||
          (at[axis] == 3 && io::neighbourBlock(block, axis + 3, levels_, next)))
        edges |= 1u << axis;
      differences[axis] = next ^ block;
    }
    // The non-empty subsets of the edges.
    for (unsigned int crossed = edges; crossed != 0 && number < enough;
         crossed = (crossed - 1) & edges) {
      std::uint64_t other = block;
      for (unsigned int axis = 0; axis < 3; ++axis)
        other ^= differences[axis] & (0 - std::uint64_t{crossed >> axis & 1});
      const std::uint64_t near =
          maskOf(set, other) & cells_near[0][at[0]][crossed & 1] &
          cells_near[1][at[1]][crossed >> 1 & 1] & cells_near[2][at[2]][crossed >> 2];
      number += near == 0 ? 0 : bitCount(near);
    }
    return number;
  }

  /** \brief Those of some cells of a block, none of a set, that have a voxel of the set
   * among the 26 around them.
   * \param[in] own the cells of the block that are in the set */
  std::uint64_t
  nextTo(const std::vector<std::uint64_t>& set,
         std::uint64_t own,
         std::uint64_t block,
         std::uint64_t cells) const
  {
    std::uint64_t near = own;
    for (std::size_t axis = 0; axis < 3; ++axis)
      near |= io::occupiedAcross(near, 0, axis) | io::occupiedAcross(near, 0, axis + 3);
    std::uint64_t found = cells & near;
    for (std::uint64_t left = cells & ~near; left != 0; left &= left - 1)
      if (count(set, 0, block << io::block_key_bits | lowestBit(left), 1) != 0)
        found |= left & (0 - left);
    return found;
  }

private:
  unsigned int levels_ = 0;
  io::BlockList nodes_; // whose voxels are the blocks
  io::BlockDirectory directory_;
};

/** \brief A set of voxels in which neighbours are counted. */
class BlockNeighbours {
public:
  /** \brief Sets the voxels.
   * \param[in] keys Morton keys, ascending
   * \param[in] depth of their grid
   */
  void
  assign(const std::vector<std::uint64_t>& keys, unsigned int depth)
  {
    blocks_.assign(keys);
    around_.assign(blocks_.keys, depth);
  }

  /** \brief Removes the voxels, and releases memory. */
  void
  releaseMemory()
  {
    *this = BlockNeighbours();
  }

  /** \brief Their blocks. */
  const io::BlockList&
  blocks() const
  {
    return blocks_;
  }

  /** \brief Number of the 26 voxels around a voxel that are in the set.
   * \param[in] key of the voxel
   * \param[in] enough counting ends when it has reached this number
   */
  unsigned int
  count(std::uint64_t key, unsigned int enough = 26) const
  {
    return around_.count(blocks_.masks, ownOf(key), key, enough);
  }

  /** \brief True if a voxel, or one of the 26 around it, is in the set. */
  bool
  isNear(std::uint64_t key) const
  {
    const std::uint64_t own = ownOf(key);
    return (own >> key % io::block_cells & 1) != 0 ||
           around_.count(blocks_.masks, own, key, 1) != 0;
  }

  /** \brief As BlocksAround::nextTo(). */
  std::uint64_t
  nextTo(std::uint64_t own, std::uint64_t block, std::uint64_t cells) const
  {
    return around_.nextTo(blocks_.masks, own, block, cells);
  }

private:
  std::uint64_t
  ownOf(std::uint64_t key) const
  {
    return around_.maskOf(blocks_.masks, key >> io::block_key_bits);
  }

  io::BlockList blocks_;
  BlocksAround around_;
};

} // namespace pcl_ext::PCL_EXT_ABI

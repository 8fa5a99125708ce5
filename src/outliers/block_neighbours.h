// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

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
    levels_ = io::levelsAboveBlocks(depth);
    blocks_.assign(keys);
    directory_.assign(blocks_.keys);
  }

  /** \brief Removes the voxels, and releases memory. */
  void
  releaseMemory()
  {
    blocks_ = io::BlockList();
    directory_ = io::BlockDirectory();
  }

  /** \brief Number of the 26 voxels around a voxel that are in the set.
   * \param[in] key of the voxel
   * \param[in] enough counting ends when it has reached this number
   */
  unsigned int
  count(std::uint64_t key, unsigned int enough = 26) const
  {
    const std::uint64_t block = key >> io::block_key_bits;
    const auto cell = static_cast<unsigned int>(key % io::block_cells);
    const std::array<unsigned int, 3> at = {(cell >> 5 & 1) << 1 | (cell >> 2 & 1),
                                            (cell >> 4 & 1) << 1 | (cell >> 1 & 1),
                                            (cell >> 3 & 1) << 1 | (cell & 1)};
    unsigned int number =
        bitCount(maskOf(block) & ~(std::uint64_t{1} << cell) & cells_near[0][at[0]][0] &
                 cells_near[1][at[1]][0] & cells_near[2][at[2]][0]);
    unsigned int edges = 0; // a bit for each axis on which the next block is near
    for (unsigned int axis = 0; axis < 3; ++axis)
      edges |= at[axis] == 0 || at[axis] == 3 ? 1u << axis : 0u;
    // The non-empty subsets of the edges.
    for (unsigned int crossed = edges; crossed != 0 && number < enough;
         crossed = (crossed - 1) & edges) {
      std::uint64_t other = block;
      if (cross(crossed, at, other))
        number += bitCount(maskOf(other) & cells_near[0][at[0]][crossed & 1] &
                           cells_near[1][at[1]][crossed >> 1 & 1] &
                           cells_near[2][at[2]][crossed >> 2]);
    }
    return number;
  }

  /** \brief True if a voxel, or one of the 26 around it, is in the set. */
  bool
  isNear(std::uint64_t key) const
  {
    return (maskOf(key >> io::block_key_bits) >> key % io::block_cells & 1) != 0 ||
           count(key, 1) != 0;
  }

private:
  /** \brief Replaces a block by the next one on some axes.
   * \return false at the end of the grid
   */
  bool
  cross(unsigned int axes,
        const std::array<unsigned int, 3>& at,
        std::uint64_t& block) const
  {
    for (unsigned int axis = 0; axis < 3; ++axis)
      if ((axes >> axis & 1) != 0 &&
          !io::neighbourBlock(block, at[axis] == 0 ? axis : axis + 3, levels_, block))
        return false;
    return true;
  }

  std::uint64_t
  maskOf(std::uint64_t block) const
  {
    const std::uint32_t index = directory_.find(block);
    return index == io::BlockDirectory::not_found ? 0 : blocks_.masks[index];
  }

  unsigned int levels_ = 0;
  io::BlockList blocks_;
  io::BlockDirectory directory_;
};

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

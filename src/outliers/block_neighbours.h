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

/** \brief By cell and the axes on which a face is crossed, a bit for each: the cells, of
 * its own block or of the next one, that are at most one voxel away, without itself. */
using CellsNear = std::array<std::array<std::uint64_t, 8>, io::block_cells>;

constexpr CellsNear
makeCellsNear()
{
  CellsNear cells{};
  // Each offset, as the position in four blocks of which the cell is in the middle ones.
  for (unsigned int cell = 0; cell < io::block_cells; ++cell)
    for (unsigned int offset = 0; offset < 27; ++offset) {
      unsigned int crossed = 0;
      unsigned int other = 0;
      for (unsigned int axis = 0, rest = offset; axis < 3; ++axis, rest /= 3) {
        const unsigned int at =
            (cell >> (5 - axis) & 1) << 1 | (cell >> (2 - axis) & 1);
        const unsigned int to = at + rest % 3 + 3; // 4..7 in the cell's block
        crossed |= (to < 4 || to > 7 ? 1u : 0u) << axis;
        other |= (to >> 1 & 1) << (5 - axis) | (to & 1) << (2 - axis);
      }
      if (other != cell)
        cells[cell][crossed] |= std::uint64_t{1} << other;
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
    // Bits of x, y and z; x is the highest of each three.
    const std::uint64_t all =
        (std::uint64_t{1} << 3 * io::levelsAboveBlocks(depth)) - 1;
    axes_ = {
        0x4924924924924924 & all, 0x2492492492492492 & all, 0x9249249249249249 & all};
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
    // Without a branch, which would be mispredicted.
    const std::uint64_t blocks = nodes_.masks[node];
    const std::uint64_t is_there = 0 - (blocks >> block % io::block_cells & 1);
    const std::uint64_t before =
        blocks & ((std::uint64_t{1} << block % io::block_cells) - 1);
    return set[(nodes_.first_voxels[node] + bitCount(before)) & is_there] & is_there;
  }

  /** \brief Number of the 26 voxels around a voxel that are in a set.
   * \param[in] own the cells of the voxel's block that are in the set
   * \param[in] key of the voxel
   * \param[in] enough counting ends when it has reached this number
   */
  PCL_EXT_NEVER_INLINE unsigned int
  count(const std::vector<std::uint64_t>& set,
        std::uint64_t own,
        std::uint64_t key,
        unsigned int enough) const
  {
    const std::uint64_t block = key >> io::block_key_bits;
    const auto cell = static_cast<unsigned int>(key % io::block_cells);
    const std::array<std::uint64_t, 8>& near = cells_near[cell];
    unsigned int number = bitCount(own & near[0]);
    if (number >= enough)
      return number;
    // A bit for each axis on which the next block is near, and how its key differs.
    unsigned int edges = 0;
    std::array<std::uint64_t, 3> differences{};
    for (unsigned int axis = 0; axis < 3; ++axis) {
      const std::uint64_t is_above = 0 - std::uint64_t{cell >> (5 - axis) & 1};
      const std::uint64_t position = block & axes_[axis];
      // Carries and borrows pass the bits of the other axes.
      const std::uint64_t one = std::uint64_t{4} >> axis;
      const std::uint64_t next = (position | (~axes_[axis] & is_above)) +
                                 ((one & is_above) - (one & ~is_above));
      differences[axis] = (next & axes_[axis]) ^ position;
      edges |=
          static_cast<unsigned int>((~(cell >> (5 - axis) ^ cell >> (2 - axis)) & 1 &
                                     (position != (axes_[axis] & is_above) ? 1u : 0u))
                                    << axis);
    }
    // The non-empty subsets of the edges, faces first.
    for (unsigned int crossed = edges & (0 - edges); crossed != 0 && number < enough;
         crossed = (crossed - edges) & edges) {
      std::uint64_t other = block;
      for (unsigned int axis = 0; axis < 3; ++axis)
        other ^= differences[axis] & (0 - std::uint64_t{crossed >> axis & 1});
      number += bitCount(maskOf(set, other) & near[crossed]);
    }
    return number;
  }

  /** \brief Those of some cells of a block, none of a set, that have a voxel of the set
   * among the 26 around them.
   * \param[in] own the cells of the block that are in the set */
  PCL_EXT_NEVER_INLINE std::uint64_t
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
  std::array<std::uint64_t, 3> axes_{}; // the bits of x, y and z of a block's key
  io::BlockList nodes_;                 // whose voxels are the blocks
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

  /** \brief Sets the voxels to those, twice as wide, that have voxels of another set.
   * \param[in] depth of their grid */
  void
  assignOctants(const BlockNeighbours& finer, unsigned int depth)
  {
    blocks_.clear();
    for (std::size_t i = 0; i < finer.blocks_.size(); ++i) {
      const std::uint64_t key = finer.blocks_.keys[i] >> 3;
      const std::uint64_t octants = io::occupiedOctants(finer.blocks_.masks[i]);
      if (blocks_.keys.empty() || blocks_.keys.back() != key)
        blocks_.append(key, 0, static_cast<std::uint32_t>(blocks_.voxelCount()));
      blocks_.masks.back() |= octants << 8 * (finer.blocks_.keys[i] & 7);
    }
    around_.assign(blocks_.keys, depth);
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

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

/** \brief The cells at most one voxel away from a cell of a block, without itself. */
struct CellsNear {
  /** \brief The axes, a bit for each, on which the cell is at a face of its block. Some of
   * the others are in the blocks across one, two or three of these faces. */
  unsigned int faces = 0;
  /** \brief By the faces that are crossed: cells of the block there. */
  std::array<std::uint64_t, 8> cells{};
};

constexpr std::array<CellsNear, io::block_cells>
makeCellsNear()
{
  std::array<CellsNear, io::block_cells> all{};
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
      all[cell].faces |= crossed;
      if (other != cell)
        all[cell].cells[crossed] |= std::uint64_t{1} << other;
    }
  return all;
}

inline constexpr std::array<CellsNear, io::block_cells> cells_near = makeCellsNear();

/** \brief The cells of a block that have an occupied one of the block at most one voxel
 * away. */
PCL_EXT_ALWAYS_INLINE std::uint64_t
cellsAround(std::uint64_t occupied)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    occupied |= io::occupiedAcross(occupied, 0, axis) |
                io::occupiedAcross(occupied, 0, axis + 3);
  return occupied;
}

/** \brief Finds the blocks around a block, by the node blocks that they are in, which are
 * so few that they stay in the processor's cache. Without branches, which would be
 * mispredicted: a block that is not there has an index, too, at most their number. */
class BlocksAround {
public:
  void
  clear()
  {
    directory_.clear(nodes_.size());
    nodes_.clear();
    nodes_.append(0, 0, 0); // of blocks that are not there
  }

  /** \brief Appends a block.
   * \param[in] key Morton key, above those of the others
   * \param[in] index number of the others */
  void
  append(std::uint64_t key, std::size_t index)
  {
    const std::uint64_t node = key >> io::block_key_bits;
    if (nodes_.size() == 1 || nodes_.keys.back() != node) {
      directory_.insert(node);
      nodes_.append(node, 0, static_cast<std::uint32_t>(index));
    }
    nodes_.masks.back() |= std::uint64_t{1} << key % io::block_cells;
  }

  struct Place {
    std::size_t index;      ///< of a block
    std::uint64_t is_there; ///< all bits, or none
  };

  Place
  placeOf(std::uint64_t block) const
  {
    // Those that are not found have the node of index 0.
    const std::uint32_t node = directory_.find(block >> io::block_key_bits) + 1;
    const std::uint64_t blocks = nodes_.masks[node];
    const std::uint64_t bit = std::uint64_t{1} << block % io::block_cells;
    return {nodes_.first_voxels[node] + bitCount(blocks & (bit - 1)),
            0 - std::uint64_t{isNotZero(blocks & bit)}};
  }

  /** \brief Visits the blocks that have some of the 26 voxels around a voxel, without its
   * own.
   * \param[in] visit called with the index of a block and these voxels, a mask of its cells;
   * those of all blocks are different cells, and none are of a block that is not there */
  template <typename VisitT>
  void
  visitOthers(std::uint64_t key, VisitT&& visit) const
  {
    const std::uint64_t block = key >> io::block_key_bits;
    const CellsNear& near = cells_near[key % io::block_cells];
    // By the faces that are crossed, how the key of the other block differs. Outside of
    // the grid it has bits that no block has.
    std::array<std::uint64_t, 8> differences;
    differences[0] = 0;
    for (unsigned int axis = 0; axis < 3; ++axis) {
      // Carries and borrows pass the bits of the other axes.
      const std::uint64_t bits = std::uint64_t{0x1249249249249249} << (2 - axis);
      const std::uint64_t one = std::uint64_t{4} >> axis;
      const std::uint64_t above = (block | ~bits) + one;
      const std::uint64_t below = (block & bits) - one;
      const std::uint64_t is_above = 0 - (key >> (5 - axis) & 1);
      const std::uint64_t next = (above & is_above) | (below & ~is_above);
      for (unsigned int others = 0; others < 1u << axis; ++others)
        differences[others | 1u << axis] =
            differences[others] ^ ((next ^ block) & bits);
    }
    for (unsigned int crossed = near.faces & (0 - near.faces); crossed != 0;
         crossed = (crossed - near.faces) & near.faces) {
      const Place other = placeOf(block ^ differences[crossed]);
      visit(other.index, near.cells[crossed] & other.is_there);
    }
  }

private:
  io::BlockList nodes_; // whose voxels are the blocks
  io::BlockDirectory directory_;
};

/** \brief A set of voxels in which neighbours are counted. */
class BlockNeighbours {
public:
  /** \brief Sets the voxels.
   * \param[in] keys Morton keys, ascending */
  void
  assign(const std::vector<std::uint64_t>& keys)
  {
    blocks_.assign(keys);
    findBlocks();
  }

  /** \brief Sets the voxels to those, twice as wide, that have voxels of another set. */
  void
  assignOctants(const BlockNeighbours& finer)
  {
    blocks_.clear();
    for (std::size_t i = 0; i < finer.blocks_.size(); ++i) {
      const std::uint64_t key = finer.blocks_.keys[i] >> 3;
      const std::uint64_t octants = io::occupiedOctants(finer.blocks_.masks[i]);
      if (blocks_.keys.empty() || blocks_.keys.back() != key)
        blocks_.append(key, 0, 0);
      blocks_.masks.back() |= octants << 8 * (finer.blocks_.keys[i] & 7);
    }
    findBlocks();
  }

  /** \brief Their blocks, and one mask more. */
  const io::BlockList&
  blocks() const
  {
    return blocks_;
  }

  /** \brief Number of the 26 voxels around a voxel that are in the set.
   * \param[in] key of the voxel
   * \param[in] enough from this number on it may be too low
   */
  unsigned int
  count(std::uint64_t key, unsigned int enough = 26) const
  {
    std::uint64_t occupied = ownOf(key) & cells_near[key % io::block_cells].cells[0];
    if (bitCount(occupied) < enough)
      around_.visitOthers(key, [&](std::size_t block, std::uint64_t cells) {
        occupied |= blocks_.masks[block] & cells;
      });
    return bitCount(occupied);
  }

  /** \brief True if a voxel, or one of the 26 around it, is in the set. */
  bool
  isNear(std::uint64_t key) const
  {
    return (ownOf(key) >> key % io::block_cells & 1) != 0 || count(key, 1) != 0;
  }

private:
  void
  findBlocks()
  {
    around_.clear();
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      around_.append(blocks_.keys[i], i);
    blocks_.masks.push_back(0); // of blocks that are not there
  }

  std::uint64_t
  ownOf(std::uint64_t key) const
  {
    const BlocksAround::Place own = around_.placeOf(key >> io::block_key_bits);
    return blocks_.masks[own.index] & own.is_there;
  }

  io::BlockList blocks_;
  BlocksAround around_;
};

} // namespace pcl_ext::PCL_EXT_ABI

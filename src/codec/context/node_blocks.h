// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "simd/bit_operations.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief 4 x 4 x 4 nodes of one octree level, the grandchildren of one node: a block
 * where the nodes are voxels. Nodes are numbered as the cells of a block. */
struct NodeBlock {
  std::uint64_t present = 0; ///< nodes that have voxels, as far as they are coded
  std::uint8_t pending = 0;  ///< octants whose nodes will be coded
};

/** \brief The node blocks of one level while its nodes are coded. Kept so that its
 * memory is reused. */
class NodeBlockLevel {
public:
  /** \brief Removes all node blocks.
   * \param[in] expected_blocks to be added, if that is known
   */
  void
  clear(std::size_t expected_blocks = 0)
  {
    directory_.clear(expected_blocks);
    blocks_of_level_.clear();
    last_key_ = no_key;
  }

  /** \brief Allocates memory for a number of further node blocks at once. */
  void
  reserveFor(std::size_t further_blocks)
  {
    directory_.reserveFor(further_blocks);
    reserveAhead(blocks_of_level_, blocks_of_level_.size() + further_blocks);
  }

  /** \brief Adds a node block that is not there yet.
   * \return its index, the number of node blocks so far
   */
  std::uint32_t
  append(std::uint64_t key)
  {
    directory_.insert(key);
    blocks_of_level_.emplace_back();
    last_key_ = key;
    return static_cast<std::uint32_t>(blocks_of_level_.size() - 1);
  }

  /** \brief The node block that was added last if it has a key, else a new one. */
  NodeBlock&
  lastOrNew(std::uint64_t key)
  {
    if (key != last_key_)
      append(key);
    return blocks_of_level_.back();
  }

  /** \brief Index of a node block, which is added if it is not there. */
  std::uint32_t
  findOrAppend(std::uint64_t key)
  {
    const std::uint32_t index = find(key);
    return index != BlockDirectory::not_found ? index : append(key);
  }

  /** \brief Index of a node block, or BlockDirectory::not_found. */
  std::uint32_t
  find(std::uint64_t key) const
  {
    return directory_.find(key);
  }

  NodeBlock&
  operator[](std::size_t index)
  {
    return blocks_of_level_[index];
  }

  const NodeBlock&
  operator[](std::size_t index) const
  {
    return blocks_of_level_[index];
  }

private:
  static constexpr std::uint64_t no_key = ~std::uint64_t{0};

  BlockDirectory directory_;
  std::vector<NodeBlock> blocks_of_level_;
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
 * \param[in] children any number of masks of 8 bits each
 */
template <unsigned int Axes>
PCL_EXT_ALWAYS_INLINE constexpr unsigned int
exchanged(unsigned int children)
{
  const auto exchange = [&](unsigned int axis) {
    const unsigned int lower = lowerChildren(axis) * 0x01010101u;
    if ((Axes & axis) != 0)
      children = (children >> axis & lower) | (children & lower) << axis;
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
  /** \brief States of the nodes across the child's faces that are outside its parent.
   *
   *     bit     5  4  3     2  1  0
   *     axis    x  y  z     x  y  z
   *             1  1  1     1  1  1    present
   *             1  1  1     0  0  0    pending
   *             0  0  0     1  1  1    absent, but one of the four nodes that share
   *                                    this face of the parent is present
   *             0  0  0     0  0  0    absent, and so are these
   */
  std::uint64_t outside = 0;
  /** \brief Nodes outside the parent on several axes that are present or pending.
   *
   *     bit     3   2   1   0
   *     axes    xy  xz  yz  xyz
   */
  std::uint64_t beyond = 0;
  unsigned int nodes = 0; ///< children that are present, a mask
};

/** \brief A node block of a level and those around it, of which each is looked up
 * once. */
class NodeBlockCursor {
public:
  /** \param[in] node_blocks of the level
   * \param[in] levels octree levels above the node blocks, 0..19
   */
  NodeBlockCursor(NodeBlockLevel& node_blocks, unsigned int levels)
  : level_(node_blocks), levels_(levels)
  {}

  /** \brief Moves to a node block of the level. */
  void
  moveTo(std::uint64_t key, std::uint32_t index)
  {
    if (index == index_)
      return;
    key_ = key;
    index_ = index;
    fetched_ = 0;
  }

  /** \brief Ends the coding of an octant of the node block.
   * \param[in] octant 0..7
   * \param[in] children its nodes that have new voxels, a mask
   */
  void
  setChildren(unsigned int octant, unsigned int children)
  {
    NodeBlock& node_block = level_[index_];
    node_block.present |= std::uint64_t{children} << (8 * octant);
    node_block.pending &= static_cast<std::uint8_t>(~(1u << octant));
  }

  /** \brief What is around the nodes of an octant of the node block.
   * \param[in] octant 0..7
   * \tparam HasBeyond whether NodeSurroundings::beyond is needed; else it is 0
   */
  template <bool HasBeyond>
  NodeSurroundings
  around(unsigned int octant)
  {
    // By axes on which they are beside this one, on the octant's side: 4 x, 2 y, 1 z.
    std::array<const NodeBlock*, 8> node_blocks{};
    node_blocks[0] = &level_[index_];
    node_blocks[4] = blockBeside<4>(octant);
    node_blocks[2] = blockBeside<2>(octant);
    node_blocks[1] = blockBeside<1>(octant);
    NodeSurroundings around;
    around.nodes =
        static_cast<unsigned int>(node_blocks[0]->present >> (8 * octant) & 0xff);
    addOutside<4>(octant, node_blocks, around);
    addOutside<2>(octant, node_blocks, around);
    addOutside<1>(octant, node_blocks, around);
    if constexpr (HasBeyond) {
      node_blocks[6] = blockBeside<6>(octant);
      node_blocks[5] = blockBeside<5>(octant);
      node_blocks[3] = blockBeside<3>(octant);
      node_blocks[7] = blockBeside<7>(octant);
      around.beyond = 8 * bytesOfBits(across<6>(octant, node_blocks) >> 8) |
                      4 * bytesOfBits(across<5>(octant, node_blocks) >> 8) |
                      2 * bytesOfBits(across<3>(octant, node_blocks) >> 8) |
                      bytesOfBits(across<7>(octant, node_blocks) >> 8);
    }
    return around;
  }

private:
  /** \brief The nodes of an octant as two masks of eight bits: in the lower one those
   * that are present, in the upper one those that are present or pending. */
  static unsigned int
  nodesOf(const NodeBlock& node_block, unsigned int octant)
  {
    const auto present =
        static_cast<unsigned int>(node_block.present >> (8 * octant) & 0xff);
    return present * 0x101 | (node_block.pending >> octant & 1u) * 0xff00;
  }

  /** \brief Adds the states of the nodes along an axis to NodeSurroundings::outside. */
  template <unsigned int Axis>
  PCL_EXT_ALWAYS_INLINE static void
  addOutside(unsigned int octant,
             const std::array<const NodeBlock*, 8>& node_blocks,
             NodeSurroundings& around)
  {
    constexpr unsigned int lower = lowerChildren(Axis);
    constexpr unsigned int upper = 0xff & ~lower;
    const unsigned int nodes = across<Axis>(octant, node_blocks);
    const unsigned int present = nodes & 0xff;
    const unsigned int not_absent = nodes >> 8;
    const unsigned int beside_present =
        ((present & lower) != 0 ? lower : 0) | ((present & upper) != 0 ? upper : 0);
    const unsigned int low = present | (beside_present & ~not_absent);
    around.outside |= bytesOfBits(not_absent) * (8 * Axis) | bytesOfBits(low) * Axis;
  }

  /** \brief For the nodes of an octant the next one outside their parent, along some
   * axes at once.
   * \tparam Axes sum of 4, 2, 1 for x, y, z
   * \return two masks as nodesOf()
   */
  template <unsigned int Axes>
  PCL_EXT_ALWAYS_INLINE static unsigned int
  across(unsigned int octant, const std::array<const NodeBlock*, 8>& node_blocks)
  {
    return exchanged<Axes>(acrossFrom<Axes, Axes>(octant, 0, 0xffff, node_blocks));
  }

  /** \brief Some of the nodes that across() finds, before they are exchanged: those in
   * a node block beside this one as far as the axes are decided. */
  template <unsigned int Axes, unsigned int UndecidedAxes>
  PCL_EXT_ALWAYS_INLINE static unsigned int
  acrossFrom(unsigned int octant,
             unsigned int beside,
             unsigned int nodes,
             const std::array<const NodeBlock*, 8>& node_blocks)
  {
    if constexpr (UndecidedAxes == 0)
      return nodes & nodesOf(*node_blocks[beside], octant ^ Axes);
    else {
      constexpr unsigned int axis = UndecidedAxes >= 4 ? 4 : UndecidedAxes >= 2 ? 2 : 1;
      constexpr unsigned int lower = lowerChildren(axis) * 0x101;
      // In the node block beside this one, the nodes on the side of this one.
      const unsigned int beyond = (octant & axis) != 0 ? lower : ~lower;
      return acrossFrom<Axes, UndecidedAxes - axis>(
                 octant, beside | axis, nodes & beyond, node_blocks) |
             acrossFrom<Axes, UndecidedAxes - axis>(
                 octant, beside, nodes & ~beyond, node_blocks);
    }
  }

  /** \brief The node block that is on the octant's side beside this one on some
   * axes. */
  template <unsigned int Axes>
  const NodeBlock*
  blockBeside(unsigned int octant)
  {
    // A slot for each side of each set of axes, of which one has 8 at most.
    const unsigned int slot = 8 * Axes + (octant & Axes);
    if ((fetched_ >> slot & 1) == 0) {
      fetched_ |= std::uint64_t{1} << slot;
      slots_[slot] = find<Axes>(octant);
    }
    return slots_[slot];
  }

  /** \brief The node block beside this one, an empty one if there is none. */
  template <unsigned int Axes>
  PCL_EXT_NEVER_INLINE const NodeBlock*
  find(unsigned int octant) const
  {
    static constexpr NodeBlock empty{};
    std::uint64_t key = key_;
    for (std::size_t face = 0; face < 3; ++face) {
      const unsigned int axis = 4u >> face;
      if ((Axes & axis) != 0 &&
          !neighbourBlock(key, (octant & axis) != 0 ? face + 3 : face, levels_, key))
        return &empty;
    }
    const std::uint32_t index = level_.find(key);
    return index != BlockDirectory::not_found ? &level_[index] : &empty;
  }

  NodeBlockLevel& level_;
  unsigned int levels_;
  std::uint64_t key_ = 0;
  std::uint32_t index_ = BlockDirectory::not_found;
  std::uint64_t fetched_ = 0; // slots that were looked up, see blockBeside()
  std::array<const NodeBlock*, 64> slots_{};
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

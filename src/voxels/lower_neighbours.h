// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the face neighbours of voxels that come before them in Morton order:
 * those below them on each axis. */
class LowerNeighbours {
public:
  /** \brief Looks in a frame.
   * \param[in] frame its blocks
   * \param[in] levels octree levels above the blocks
   * \param[in] directory memory for one of the blocks
   */
  LowerNeighbours(const BlockList& frame,
                  unsigned int levels,
                  BlockDirectory& directory)
  : frame_(frame), levels_(levels), directory_(directory)
  {}

  void
  begin()
  {
    directory_.assign(frame_.keys);
  }

  /** \brief Selects a block of the frame. */
  void
  moveTo(std::size_t block)
  {
    here_ = {frame_.masks[block], frame_.first_voxels[block]};
    for (std::size_t face = 0; face < lower_faces; ++face)
      lower_[face] = blockAt(indexAcross(block, face));
  }

  /** \brief Calls a function for the lower side of a cell on each axis, whether or not
   * a voxel is there, so that the caller needs no branch, which would be mispredicted.
   * \param[in] cell of the selected block
   * \param[in] visit_side called with the index of the voxel and 1, or with any index
   * of the frame's and 0
   */
  template <typename VisitT>
  void
  visitEachSide(unsigned int cell, VisitT&& visit_side) const
  {
    for (std::size_t face = 0; face < lower_faces; ++face) {
      const unsigned int low = 1u << (2 - face);
      const Block& block = (cell & (low | low << 3)) != 0 ? here_ : lower_[face];
      // One down on the axis: 3 -> 2, 2 -> 1, 1 -> 0, and 0 -> 3 of the next block.
      const unsigned int other = (cell & low) != 0 ? cell - low : cell ^ low ^ low << 3;
      const auto is_there = static_cast<std::uint32_t>(block.mask >> other & 1);
      const std::size_t voxel =
          block.first_voxel + bitCount(block.mask & ((std::uint64_t{1} << other) - 1));
      visit_side(voxel * is_there, is_there);
    }
  }

  /** \brief Calls a function with the index of each lower neighbour of a cell's voxel.
   * \param[in] cell of the selected block
   */
  template <typename VisitT>
  void
  visit(unsigned int cell, VisitT&& visit_voxel) const
  {
    visitEachSide(cell, [&](std::size_t voxel, std::uint32_t is_there) {
      if (is_there != 0)
        visit_voxel(voxel);
    });
  }

protected:
  static constexpr std::size_t lower_faces = 3;

  /** \brief The cells of a block, and the index of its first voxel. */
  struct Block {
    std::uint64_t mask = 0;
    std::size_t first_voxel = 0;
  };

  const Block&
  selected() const
  {
    return here_;
  }

  static constexpr std::uint32_t none = BlockDirectory::not_found;

  /** \brief Index of the block across a face of a block of the frame, or none. */
  std::uint32_t
  indexAcross(std::size_t block, std::size_t face) const
  {
    std::uint64_t key = 0;
    if (!neighbourBlock(frame_.keys[block], face, levels_, key))
      return none;
    if ((key ^ frame_.keys[block]) >= 8)
      return directory_.find(key);
    // Parts of the same branch are next to each other.
    std::size_t other = block;
    if (face < lower_faces)
      while (other > 0 && frame_.keys[other] > key)
        --other;
    else
      while (other + 1 < frame_.size() && frame_.keys[other] < key)
        ++other;
    return frame_.keys[other] == key ? static_cast<std::uint32_t>(other) : none;
  }

  /** \brief A block of the frame; empty for none. */
  Block
  blockAt(std::uint32_t index) const
  {
    return index == none ? Block()
                         : Block{frame_.masks[index], frame_.first_voxels[index]};
  }

  std::size_t
  blockCount() const
  {
    return frame_.size();
  }

  /** \brief Selects a block whose lower ones are known.
   * \param[in] lower their indices, or none
   */
  void
  select(std::size_t block, const std::uint32_t* lower)
  {
    here_ = {frame_.masks[block], frame_.first_voxels[block]};
    for (std::size_t face = 0; face < lower_faces; ++face)
      lower_[face] = blockAt(lower[face]);
  }

private:
  const BlockList& frame_;
  unsigned int levels_;
  BlockDirectory& directory_;
  Block here_; // the selected one
  std::array<Block, lower_faces> lower_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

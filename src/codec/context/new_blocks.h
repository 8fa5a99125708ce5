// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/reserve_ahead.h"
#include "codec/context/children.h"
#include "codec/context/frame_blocks.h"
#include "codec/context/history.h"
#include "codec/context/node_blocks.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Codes the voxels of blocks that the history does not have, for either
 * direction: as an octree, level by level, so that the nodes around a node are known
 * one level above its children.
 * \tparam CodingT DecisionCoding
 */
template <typename CodingT>
class NewBlockPass {
public:
  /** \brief A pass over one frame.
   * \param[in,out] frame the voxels of its tracked blocks have been coded
   * \param[in] parameters of the frame
   * \param[in] max_voxels,max_blocks of the pass; a decoder fails where there are more
   */
  NewBlockPass(CodingT& coding,
               ChildModels& models,
               FrameBlocks& frame,
               const FrameParameters& parameters,
               std::size_t max_voxels,
               std::size_t max_blocks)
  : coding_(coding)
  , models_(models)
  , frame_(frame)
  , tracked_(parameters.history.blocks())
  , depth_(parameters.grid_depth)
  , max_voxels_(max_voxels)
  , max_blocks_(max_blocks)
  {}

  /** \brief Codes the new blocks.
   * \return false if the decoded voxels are invalid or more than max_voxels
   */
  bool
  run()
  {
    return codeBlocks() && codeOctants() && codeCells();
  }

  /** \brief Whether it failed since there are more than max_blocks. */
  bool
  hasTooManyBlocks() const
  {
    return has_too_many_blocks_;
  }

private:
  bool
  codeBlocks()
  {
    frame_.children.clear();
    if (!coding_.codeBypass(!frame_.target_keys.empty()))
      return true;
    // A grid of one block: it is new only if the history is empty.
    if (levelsAboveBlocks(depth_) == 0 && !tracked_.empty())
      return false;
    frame_.children.push_back(0);
    for (unsigned int height = depth_; height-- > block_levels;)
      if (!codeBranches(height))
        return false;
    frame_.new_keys.assign(frame_.children.begin(), frame_.children.end());
    frame_.blocks.reserveFor(frame_.new_keys.size());
    for (const std::uint64_t key : frame_.new_keys)
      frame_.blocks.append(key);
    return true;
  }

  /** \brief Codes which nodes of a level have new blocks, or are new ones.
   * \param[in] height of the nodes above the voxels; 2: blocks
   */
  bool
  codeBranches(unsigned int height)
  {
    frame_.parents.swap(frame_.children);
    frame_.children.clear();
    reserveAhead(frame_.children, std::min(8 * frame_.parents.size(), max_voxels_));
    const unsigned int shift = 3 * (height - block_levels);
    beginBranchNodeBlocks(shift);
    beginPending(frame_.parents.size());
    for (const std::uint64_t parent : frame_.parents)
      addPending(parent);
    NodeBlockCursor cursor(frame_.node_blocks, levelsAboveNodeBlocks(height));
    std::size_t next_target = 0;
    std::size_t next_tracked = 0;
    for (std::size_t i = 0; i < frame_.parents.size(); ++i) {
      const std::uint64_t key = frame_.parents[i];
      ParentNode parent;
      for (; next_target < frame_.target_keys.size() &&
             frame_.target_keys[next_target] >> shift >> 3 == key;
           ++next_target)
        parent.target |= 1u << (frame_.target_keys[next_target] >> shift & 7);
      if (height == block_levels) {
        parent.candidates &= ~trackedChildren(key, next_tracked);
        if (parent.candidates == 0)
          return false;
      }
      unsigned int children = codeNode(cursor, parent, key, frame_.parent_blocks[i]);
      const std::size_t nodes = frame_.children.size() + child_masks.count[children];
      if (nodes > std::min(max_voxels_, max_blocks_)) {
        has_too_many_blocks_ = nodes <= max_voxels_;
        return false;
      }
      for (; children != 0; children &= children - 1)
        frame_.children.push_back(key << 3 | lowestBit(children));
    }
    return true;
  }

  /** \brief Makes the node blocks of the nodes that have blocks of the history.
   * \param[in] shift bits of a block's key below that of a node
   */
  void
  beginBranchNodeBlocks(unsigned int shift)
  {
    frame_.node_blocks.clear();
    for (std::size_t i = 0; i < tracked_.size();) {
      const std::uint64_t node = tracked_[i].key >> shift;
      frame_.node_blocks.lastOrNew(node >> 6).present |= std::uint64_t{1}
                                                         << (node & 63);
      i = firstFrom(i, (node + 1) << shift);
    }
  }

  /** \brief Index of the first block of the history from a key on.
   * \param[in] index of a block before it, near to it as a rule
   * \param[in] key the key
   */
  std::size_t
  firstFrom(std::size_t index, std::uint64_t key) const
  {
    std::size_t step = 1;
    while (index + step < tracked_.size() && tracked_[index + step].key < key) {
      index += step;
      step *= 2;
    }
    const HistoryBlock* const blocks = tracked_.data();
    const HistoryBlock* const end = blocks + std::min(index + step, tracked_.size());
    const auto is_before = [](const HistoryBlock& block, std::uint64_t least) {
      return block.key < least;
    };
    return static_cast<std::size_t>(
        std::lower_bound(blocks + index + 1, end, key, is_before) - blocks);
  }

  /** \brief The children of a node above blocks that are blocks of the history, a mask.
   * \param[in] key of the node
   * \param[in,out] next index of a block not above these
   */
  unsigned int
  trackedChildren(std::uint64_t key, std::size_t& next) const
  {
    unsigned int children = 0;
    while (next < tracked_.size() && tracked_[next].key >> 3 < key)
      ++next;
    for (; next < tracked_.size() && tracked_[next].key >> 3 == key; ++next)
      children |= 1u << (tracked_[next].key & 7);
    return children;
  }

  /** \brief Codes which octants of the new blocks have voxels. */
  bool
  codeOctants()
  {
    if (frame_.new_keys.empty())
      return true;
    frame_.node_blocks.clear();
    for (std::size_t i = 0; i < tracked_.size(); ++i)
      frame_.node_blocks.lastOrNew(tracked_[i].key >> 3).present |=
          std::uint64_t{occupiedOctants(frame_.blocks[i].present)}
          << (8 * (tracked_[i].key & 7));
    beginPending(frame_.new_keys.size());
    for (const std::uint64_t key : frame_.new_keys)
      addPending(key);
    NodeBlockCursor cursor(frame_.node_blocks, levelsAboveNodeBlocks(1));
    std::size_t octants = 0;
    for (std::size_t i = 0; i < frame_.new_keys.size(); ++i) {
      ParentNode parent;
      parent.candidates = occupiedOctants(cellsInGrid(depth_));
      parent.target = occupiedOctants(targetCells(i));
      const unsigned int found =
          codeNode(cursor, parent, frame_.new_keys[i], frame_.parent_blocks[i]);
      frame_.blocks[tracked_.size() + i].pending = static_cast<std::uint8_t>(found);
      octants += child_masks.count[found];
    }
    return octants <= max_voxels_;
  }

  /** \brief Codes which cells of the octants are voxels. */
  bool
  codeCells()
  {
    NodeBlockCursor cursor(frame_.blocks, levelsAboveNodeBlocks(0));
    std::size_t voxels = 0;
    for (std::size_t i = 0; i < frame_.new_keys.size(); ++i) {
      const auto node_block = static_cast<std::uint32_t>(tracked_.size() + i);
      for (unsigned int octants = frame_.blocks[node_block].pending; octants != 0;
           octants &= octants - 1) {
        const unsigned int octant = lowestBit(octants);
        ParentNode parent;
        parent.target =
            static_cast<unsigned int>(targetCells(i) >> (8 * octant) & 0xff);
        voxels += child_masks.count[codeNode(
            cursor, parent, frame_.new_keys[i] << 3 | octant, node_block)];
      }
      if (voxels > max_voxels_)
        return false;
    }
    return true;
  }

  /** \brief Encoder only: the voxels of a new block. */
  std::uint64_t
  targetCells(std::size_t new_block) const
  {
    return CodingT::is_decoder ? 0 : frame_.target_masks[new_block];
  }

  /** \brief Codes the children of a node.
   * \param[in,out] cursor in the node blocks of the children
   * \param[in] parent the node
   * \param[in] key of the node
   * \param[in] node_block index of the children's node block
   * \return the children as a mask
   */
  unsigned int
  codeNode(NodeBlockCursor& cursor,
           const ParentNode& parent,
           std::uint64_t key,
           std::uint32_t node_block)
  {
    const auto octant = static_cast<unsigned int>(key & 7);
    cursor.moveTo(key >> 3, node_block);
    const NodeSurroundings around = cursor.around<CodingT::is_small>(octant);
    const unsigned int children = codeChildren(coding_, models_, parent, around);
    cursor.setChildren(octant, children);
    return children;
  }

  /** \brief Prepares for a number of calls of addPending(). */
  void
  beginPending(std::size_t parents)
  {
    frame_.node_blocks.reserveFor(parents);
    frame_.parent_blocks.clear();
    reserveAhead(frame_.parent_blocks, parents);
  }

  /** \brief Marks the children of a node as pending, and notes their node block. */
  void
  addPending(std::uint64_t parent)
  {
    const std::uint32_t node_block = frame_.node_blocks.findOrAppend(parent >> 3);
    frame_.node_blocks[node_block].pending |=
        static_cast<std::uint8_t>(1u << (parent & 7));
    frame_.parent_blocks.push_back(node_block);
  }

  unsigned int
  levelsAboveNodeBlocks(unsigned int height) const
  {
    return depth_ > height + block_levels ? depth_ - height - block_levels : 0;
  }

  CodingT& coding_;
  ChildModels& models_;
  FrameBlocks& frame_;
  const std::vector<HistoryBlock>& tracked_;
  unsigned int depth_;
  std::size_t max_voxels_;
  std::size_t max_blocks_;
  bool has_too_many_blocks_ = false;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

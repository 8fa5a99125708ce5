// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/new_blocks.h"

#include "bytes/reserve_ahead.h"
#include "codec/rans/entropy_coder.h"
#include "simd/bit_operations.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

void
NewBlocks::Level::ensure(std::size_t size)
{
  ensureSize(keys, size);
  ensureSize(masks, size);
  ensureSize(first_child, size);
  ensureSize(lower, size);
  ensureSize(upper, size);
}

/** \brief For an encoder: collects the masks of all nodes, from octants to the root. */
void
NewBlocks::collectMasks(const FrameBlocks& frame)
{
  const unsigned int levels = levelsAboveBlocks(frame.depth) + block_levels;
  if (node_masks_.size() < levels)
    node_masks_.resize(levels);
  for (std::vector<std::uint8_t>& masks : node_masks_)
    masks.clear();
  for (const std::uint64_t mask : frame.new_masks) {
    const unsigned int octants = occupiedOctants(mask);
    node_masks_[1].push_back(static_cast<std::uint8_t>(octants));
    for (unsigned int left = octants; left != 0; left &= left - 1)
      node_masks_[0].push_back(
          static_cast<std::uint8_t>(mask >> (8 * lowestBit(left)) & 0xff));
  }
  reserveAhead(node_keys_, frame.new_keys.size());
  node_keys_.assign(frame.new_keys.begin(), frame.new_keys.end());
  for (unsigned int level = block_levels; level < levels; ++level) {
    std::vector<std::uint8_t>& masks = node_masks_[level];
    std::size_t count = 0;
    for (const std::uint64_t key : node_keys_) {
      // In place: parents overwrite children that were read.
      if (count == 0 || node_keys_[count - 1] != key >> 3) {
        node_keys_[count++] = key >> 3;
        masks.push_back(0);
      }
      masks.back() = static_cast<std::uint8_t>(masks.back() | 1u << (key & 7));
    }
    node_keys_.resize(count);
  }
  if (frame.new_keys.empty())
    node_masks_[levels - 1].push_back(0);
}

/** \brief Codes the masks of a level.
 * \param[in] masks encoder only
 * \param[in] is_root whether it is the root's level
 * \param[in] max_children more are invalid
 */
template <class Coder>
bool
NewBlocks::codeMasks(Coder& coder_now,
                     NodeModels& models,
                     const std::vector<std::uint8_t>& masks,
                     bool is_root,
                     std::size_t max_children)
{
  coder_now.reserve(2 * level_.count);
  Coder coder = coder_now;
  // Local pointers (doc/implementation_notes.md, "Pointers in local variables").
  std::uint8_t* const all_masks = level_.masks.data();
  std::uint32_t* const first_child = level_.first_child.data();
  const std::array<std::uint32_t, 3>* const all_lower = level_.lower.data();
  const std::size_t count = level_.count;
  std::uint8_t* const upper = level_.upper.data();
  std::fill_n(upper, count, std::uint8_t{0});
  for (std::size_t i = 1; i < count; ++i)
    for (unsigned int axis = 0; axis < 3; ++axis)
      upper[all_lower[i][axis]] =
          static_cast<std::uint8_t>(upper[all_lower[i][axis]] | 4u >> axis);
  std::uint32_t child = 1;
  for (std::size_t i = 1; i < count; ++i) {
    const std::array<std::uint32_t, 3> lower = all_lower[i];
    const unsigned int likely = (all_masks[lower[0]] >> 4 & 0x0fu) |
                                (all_masks[lower[1]] >> 2 & 0x33u) |
                                (all_masks[lower[2]] >> 1 & 0x55u);
    const unsigned int mask = codeNode(
        coder, models, likely, upper[i], Coder::is_decoder ? 0u : masks[i - 1]);
    all_masks[i] = static_cast<std::uint8_t>(mask);
    first_child[i] = child;
    child += child_masks.count[mask];
    if (Coder::is_decoder &&
        (coder.isOverrun() || child - 1 > max_children || (mask == 0 && !is_root))) {
      child_count_ = child - 1;
      return false;
    }
  }
  child_count_ = child - 1;
  coder_now = coder;
  return true;
}

/** \brief Index of a child of a node, 0 if there is no such child. */
inline std::uint32_t
NewBlocks::childOf(const Level& level, std::uint32_t node, unsigned int child)
{
  const unsigned int mask = level.masks[node];
  const std::uint32_t index =
      level.first_child[node] + child_masks.count[mask & ((1u << child) - 1)];
  return index & (0u - (mask >> child & 1));
}

/** \brief Proceeds to the children of all nodes. */
void
NewBlocks::descend()
{
  next_level_.ensure(child_count_ + 1);
  std::size_t next = 1;
  for (std::size_t i = 1; i < level_.count; ++i) {
    const std::array<std::uint32_t, 3> lower = level_.lower[i];
    for (unsigned int left = level_.masks[i]; left != 0; left &= left - 1) {
      const unsigned int child = lowestBit(left);
      next_level_.keys[next] = level_.keys[i] << 3 | child;
      for (unsigned int axis = 0; axis < 3; ++axis) {
        const unsigned int bit = 4u >> axis;
        const std::uint32_t parent =
            (child & bit) != 0 ? static_cast<std::uint32_t>(i) : lower[axis];
        next_level_.lower[next][axis] = childOf(level_, parent, child ^ bit);
      }
      ++next;
    }
  }
  next_level_.count = next;
  std::swap(level_, next_level_);
}

template <class Coder>
bool
NewBlocks::code(Coder& coder, NodeModels& models, FrameBlocks& frame)
{
  if (!Coder::is_decoder)
    collectMasks(frame);
  const unsigned int levels = levelsAboveBlocks(frame.depth) + block_levels;
  // Each node has at least one voxel.
  const std::size_t max_nodes =
      Coder::is_decoder ? frame.voxel_count - frame.found_voxels : 0;
  static const std::vector<std::uint8_t> no_masks;
  level_.ensure(2);
  next_level_.ensure(2);
  level_.masks[0] = 0;
  next_level_.masks[0] = 0;
  level_.count = 2;
  level_.keys[1] = 0;
  level_.lower[1] = {0, 0, 0};
  for (unsigned int level = levels; level-- > 0;) {
    const bool is_above_blocks = level >= block_levels;
    if (!codeMasks(coder,
                   models,
                   Coder::is_decoder ? no_masks : node_masks_[level],
                   level + 1 == levels,
                   is_above_blocks ? std::min(max_nodes, frame.max_blocks)
                                   : max_nodes)) {
      frame.has_too_many_blocks = is_above_blocks && child_count_ > frame.max_blocks &&
                                  child_count_ <= max_nodes;
      return false;
    }
    if (level > 0)
      descend();
  }
  return !Coder::is_decoder || setCells(frame);
}

/** \brief Sets the new blocks of a frame to those of the octants. */
bool
NewBlocks::setCells(FrameBlocks& frame) const
{
  frame.new_keys.clear();
  frame.new_masks.clear();
  for (std::size_t i = 1; i < level_.count; ++i) {
    const std::uint64_t block = level_.keys[i] >> 3;
    if (frame.new_keys.empty() || frame.new_keys.back() != block) {
      frame.new_keys.push_back(block);
      frame.new_masks.push_back(0);
    }
    frame.new_masks.back() |= std::uint64_t{level_.masks[i]}
                              << (8 * (level_.keys[i] & 7));
  }
  if (child_count_ == 0)
    return true;
  frame.found_voxels += child_count_;
  return (frame.new_masks.back() & ~cellsInGrid(frame.depth)) == 0;
}

template bool
NewBlocks::code(rans::NibbleEncoder&, NodeModels&, FrameBlocks&);
template bool
NewBlocks::code(rans::NibbleDecoder&, NodeModels&, FrameBlocks&);

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

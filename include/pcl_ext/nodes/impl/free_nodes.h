// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include <octomap/OcTree.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::detail {

/** \brief Nodes of an OctoMap that rays go through, each of which counts as one miss.
 *
 * The result is that of map.updateNode(key, false) for each of them. As these are some
 * millions in a frame, they are kept as blocks of 4 x 4 x 4 nodes, in the order of the
 * tree, which is walked once; nodes whose parts all get the same stay whole. */
class FreeNodes {
public:
  /** \brief Adds the nodes from a point to another one, without the last one. Both are
   * in the map. */
  void
  addRay(const octomap::OcTree& map,
         const octomap::point3d& origin,
         const octomap::point3d& end)
  {
    if (!map.computeRayKeys(origin, end, ray_))
      return;
    for (const octomap::OcTreeKey& key : ray_) {
      const std::uint64_t node = mortonKeyOf(key);
      if (block_ == nullptr || node / nodes_of_block != block_key_) {
        block_key_ = node / nodes_of_block;
        block_ = &blocks_[block_key_];
      }
      *block_ |= bitOf(node);
    }
  }

  void
  remove(const octomap::OcTreeKey& key)
  {
    const std::uint64_t node = mortonKeyOf(key);
    if (const auto block = blocks_.find(node / nodes_of_block); block != blocks_.end())
      block->second &= ~bitOf(node);
  }

  /** \brief Updates the map, with its inner nodes above these. */
  void
  countAsMissed(octomap::OcTree& map)
  {
    std::vector<Block> blocks;
    blocks.reserve(blocks_.size());
    for (const auto& block : blocks_)
      if (block.second != 0)
        blocks.push_back(block);
    if (blocks.empty())
      return;
    std::sort(blocks.begin(), blocks.end());
    constexpr bool lazily = true;
    // It notes the keys of nodes that change, which only updateNode() does.
    if (map.isChangeDetectionEnabled()) {
      for (const auto& [block, nodes] : blocks)
        for (std::uint64_t i = 0; i < nodes_of_block; ++i)
          if ((nodes >> i & 1) != 0)
            map.updateNode(keyOf(block * nodes_of_block + i), false, lazily);
      return;
    }
    if (map.getRoot() == nullptr)
      makeRoot(map, blocks.front());
    Walk{map}.visit(*map.getRoot(), false, 0, blocks.data(), blocks.size());
  }

private:
  static constexpr std::uint64_t nodes_of_block = 64;
  static constexpr unsigned int block_depth = 14;        // two levels above the leaves
  using Block = std::pair<std::uint64_t, std::uint64_t>; // its Morton key, its nodes

  static std::uint64_t
  mortonKeyOf(const octomap::OcTreeKey& key)
  {
    return io::mortonKey({key[0], key[1], key[2]});
  }

  static std::uint64_t
  bitOf(std::uint64_t node)
  {
    return std::uint64_t{1} << node % nodes_of_block;
  }

  static octomap::OcTreeKey
  keyOf(std::uint64_t node)
  {
    const io::VoxelPosition position = io::voxelPosition(node);
    return {static_cast<octomap::key_type>(position.x),
            static_cast<octomap::key_type>(position.y),
            static_cast<octomap::key_type>(position.z)};
  }

  /** \brief Makes the root of an empty map by the first node of a block. */
  static void
  makeRoot(octomap::OcTree& map, Block& block)
  {
    std::uint64_t first = 0;
    while ((block.second >> first & 1) == 0)
      ++first;
    map.updateNode(keyOf(block.first * nodes_of_block + first), false, true);
    block.second &= ~bitOf(first);
  }

  /** \brief Follows the tree to the blocks. */
  struct Walk {
    octomap::OcTree& map;

    /** \brief Counts the nodes of blocks, all in a node, as missed.
     * \param[in] is_new it was created for that, and is not a leaf that stands for all of
     * its nodes
     * \param[in] depth of the node
     * \param[in] blocks ascending
     */
    void
    visit(octomap::OcTreeNode& node,
          bool is_new,
          unsigned int depth,
          const Block* blocks,
          std::size_t count) const
    {
      if (!is_new && isLeast(node))
        return;
      if (depth == block_depth) {
        visitNodes(node, is_new, depth, blocks->second);
        return;
      }
      const unsigned int shift = 3 * (block_depth - 1 - depth);
      const Block* const end = blocks + count;
      while (blocks != end) {
        const std::uint64_t child = blocks->first >> shift;
        const Block* const next = std::find_if(
            blocks, end, [&](const Block& b) { return b.first >> shift != child; });
        const auto [part, part_is_new] = childOf(node, is_new, child % 8);
        visit(*part,
              part_is_new,
              depth + 1,
              blocks,
              static_cast<std::size_t>(next - blocks));
        blocks = next;
      }
      complete(node);
    }

    /** \brief As visit(), within a block.
     * \param[in] nodes a bit for each of the lowest ones in the node
     */
    void
    visitNodes(octomap::OcTreeNode& node,
               bool is_new,
               unsigned int depth,
               std::uint64_t nodes) const
    {
      if (nodes == 0 || (!is_new && isLeast(node)))
        return;
      const bool is_block = depth == block_depth;
      const std::uint64_t all =
          is_block ? std::numeric_limits<std::uint64_t>::max() : std::uint64_t{0xff};
      const bool is_leaf = !map.nodeHasChildren(&node);
      if (depth == map.getTreeDepth() || (is_leaf && nodes == all)) {
        map.updateNodeLogOdds(&node, map.getProbMissLog());
        return;
      }
      const unsigned int bits = is_block ? 8 : 1; // of a child
      for (unsigned int i = 0; i < 8; ++i) {
        const std::uint64_t of_child =
            nodes >> i * bits & ((std::uint64_t{1} << bits) - 1);
        if (of_child == 0)
          continue;
        const auto [child, child_is_new] = childOf(node, is_new, i);
        visitNodes(*child, child_is_new, depth + 1, of_child);
      }
      complete(node);
    }

    /** \brief True for a leaf that misses do not change. */
    bool
    isLeast(const octomap::OcTreeNode& node) const
    {
      return !map.nodeHasChildren(&node) &&
             node.getLogOdds() <= map.getClampingThresMinLog();
    }

    /** \brief A child of a node; of a leaf after it was divided, or else made anew.
     * \param[in] is_new whether the node was created for that
     * \param[in] octant three bits of a Morton key
     * \return whether the child is new
     */
    std::pair<octomap::OcTreeNode*, bool>
    childOf(octomap::OcTreeNode& node, bool is_new, std::uint64_t octant) const
    {
      const auto place = static_cast<unsigned int>(octant >> 2 | (octant & 2) |
                                                   (octant & 1) << 2); // x the lowest
      if (!is_new && !map.nodeHasChildren(&node))
        map.expandNode(&node);
      if (map.nodeHasChildren(&node) && map.nodeChildExists(&node, place))
        return {map.getNodeChild(&node, place), false};
      return {map.createNodeChild(&node, place), true};
    }

    void
    complete(octomap::OcTreeNode& node) const
    {
      if (!map.pruneNode(&node))
        node.updateOccupancyChildren();
    }
  };

  std::unordered_map<std::uint64_t, std::uint64_t> blocks_; // nodes by Morton key
  std::uint64_t block_key_ = 0;                             // of block_
  std::uint64_t* block_ = nullptr;                          // the last one; null: none
  octomap::KeyRay ray_;                                     // keeps its memory
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes::detail

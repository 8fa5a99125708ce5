// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/published/tree_serialization.h"

#include "voxels/child_masks.h"

#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

namespace {

/** \brief One cursor for each level of the reference, if there is one. */
using ReferenceCursors = std::array<OccupancyCursor, max_grid_depth>;

ReferenceCursors
cursorsOf(const OccupancyTree* reference)
{
  ReferenceCursors cursors;
  if (reference != nullptr)
    for (unsigned int level = 0; level < reference->depth(); ++level)
      cursors[level] = OccupancyCursor(reference->level(level));
  return cursors;
}

class TreeWriter {
public:
  TreeWriter(const OccupancyTree& tree,
             const OccupancyTree* reference,
             std::vector<std::uint8_t>& symbols)
  : tree_(tree), symbols_(symbols), reference_(cursorsOf(reference))
  {}

  /** \brief Writes the next node of a level and all below it. */
  void
  write(unsigned int level)
  {
    // Depth first visits the nodes of one level in ascending order.
    const std::size_t index = next_[level]++;
    const std::uint64_t node = tree_.level(level).nodes[index];
    const std::uint8_t occupancy = tree_.level(level).occupancy[index];
    symbols_.push_back(
        static_cast<std::uint8_t>(occupancy ^ reference_[level].occupancyOf(node)));
    if (level + 1 == tree_.depth())
      return;
    for (unsigned int child = child_masks.count[occupancy]; child > 0; --child)
      write(level + 1);
  }

private:
  const OccupancyTree& tree_;
  std::vector<std::uint8_t>& symbols_;
  ReferenceCursors reference_;
  std::array<std::size_t, max_grid_depth> next_{};
};

class TreeReader {
public:
  TreeReader(const std::vector<std::uint8_t>& symbols,
             const OccupancyTree* reference,
             std::size_t voxel_count,
             OccupancyTree& tree,
             std::vector<std::uint64_t>& keys)
  : symbols_(symbols)
  , voxel_count_(voxel_count)
  , tree_(tree)
  , keys_(keys)
  , reference_(cursorsOf(reference))
  {}

  /** \brief Reads a node and all below it; false if the symbols are not a tree or its
   * voxels too many.
   *
   * A branch may have no children: where PCL enlarges an octree that has no voxel of
   * the frame yet, the old root stays below the new one. Such a branch is not kept: the
   * next frame's differences to it are the same as to a branch that does not exist.
   */
  bool
  read(unsigned int level, std::uint64_t node)
  {
    if (position_ == symbols_.size())
      return false;
    const auto occupancy = static_cast<std::uint8_t>(
        symbols_[position_++] ^ reference_[level].occupancyOf(node));
    if (occupancy == 0)
      return true;
    tree_.level(level).push(node, occupancy);
    if (level + 1 == tree_.depth())
      return addVoxels(node, occupancy);
    for (unsigned int i = 0; i < child_masks.count[occupancy]; ++i)
      if (!read(level + 1, node << 3 | child_masks.children[occupancy][i]))
        return false;
    return true;
  }

  /** \brief True if all symbols were read and all voxels found. */
  bool
  isComplete() const
  {
    return position_ == symbols_.size() && keys_.size() == voxel_count_;
  }

private:
  bool
  addVoxels(std::uint64_t branch, std::uint8_t occupancy)
  {
    const unsigned int count = child_masks.count[occupancy];
    if (keys_.size() + count > voxel_count_)
      return false;
    for (unsigned int i = 0; i < count; ++i)
      keys_.push_back(branch << 3 | child_masks.children[occupancy][i]);
    return true;
  }

  const std::vector<std::uint8_t>& symbols_;
  std::size_t voxel_count_;
  OccupancyTree& tree_;
  std::vector<std::uint64_t>& keys_;
  ReferenceCursors reference_;
  std::size_t position_ = 0;
};

} // namespace

void
serializeTree(const OccupancyTree& tree,
              const OccupancyTree* reference,
              std::vector<std::uint8_t>& symbols)
{
  symbols.clear();
  if (tree.level(0).size() == 0)
    symbols.push_back(0);
  else
    TreeWriter(tree, reference, symbols).write(0);
}

bool
deserializeTree(const std::vector<std::uint8_t>& symbols,
                const OccupancyTree* reference,
                std::size_t voxel_count,
                OccupancyTree& tree,
                std::vector<std::uint64_t>& keys)
{
  keys.clear();
  TreeReader reader(symbols, reference, voxel_count, tree, keys);
  return reader.read(0, 0) && reader.isComplete();
}

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

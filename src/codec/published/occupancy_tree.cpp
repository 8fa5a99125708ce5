// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/published/occupancy_tree.h"

#include <algorithm>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

namespace {

/** \brief Builds the parents of ascending children. */
void
buildParents(const std::vector<std::uint64_t>& children, OccupancyLevel& parents)
{
  parents.nodes.resize(children.size());
  parents.occupancy.resize(children.size());
  std::uint64_t* nodes = parents.nodes.data();
  std::uint8_t* occupancy = parents.occupancy.data();
  std::size_t last = 0;
  nodes[0] = children[0] >> 3;
  occupancy[0] = 0;
  for (const std::uint64_t child : children) {
    const std::uint64_t node = child >> 3;
    // Arithmetic instead of a branch that would be mispredicted.
    const bool is_new = node != nodes[last];
    last += is_new ? 1 : 0;
    nodes[last] = node;
    occupancy[last] =
        static_cast<std::uint8_t>((is_new ? 0 : occupancy[last]) | (1u << (child & 7)));
  }
  parents.nodes.resize(last + 1);
  parents.occupancy.resize(last + 1);
}

} // namespace

void
OccupancyTree::reset(unsigned int depth)
{
  depth_ = depth;
  for (OccupancyLevel& level : levels_)
    level.clear();
}

void
OccupancyTree::build(const std::vector<std::uint64_t>& keys, unsigned int depth)
{
  reset(depth);
  if (keys.empty())
    return;
  const std::vector<std::uint64_t>* children = &keys;
  for (unsigned int index = depth; index-- > 0;) {
    buildParents(*children, levels_[index]);
    children = &levels_[index].nodes;
  }
}

std::size_t
maxBranchNodes(std::uint64_t voxels, unsigned int depth)
{
  // With 64 bits on every machine.
  constexpr std::uint64_t few = std::uint64_t{1} << 20;
  voxels = std::min(voxels, std::uint64_t{1} << 40);
  const std::uint64_t nodes =
      (std::min(voxels, few) + 1) * depth + 2 * (voxels - std::min(voxels, few));
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(nodes, std::numeric_limits<std::size_t>::max()));
}

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>

#include "voxels/ascending_keys.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

/** \brief Branch nodes of one level of an octree, in Morton order. */
struct OccupancyLevel {
  std::vector<std::uint64_t> nodes;    ///< upper bits of the voxels' Morton keys
  std::vector<std::uint8_t> occupancy; ///< bit i set: child i is occupied

  std::size_t
  size() const
  {
    return nodes.size();
  }

  void
  clear()
  {
    nodes.clear();
    occupancy.clear();
  }

  void
  push(std::uint64_t node, std::uint8_t bits)
  {
    nodes.push_back(node);
    occupancy.push_back(bits);
  }
};

/** \brief An octree as levels of occupancy bytes, without pointers.
 *
 * Level 0 is the root; the children on the last level are voxels. An empty octree has
 * no nodes.
 */
class OccupancyTree {
public:
  /** \brief Builds the octree of a set of voxels.
   * \param[in] keys Morton keys, strictly ascending, below 8^depth
   * \param[in] depth number of levels, 1..max_grid_depth
   */
  void
  build(const std::vector<std::uint64_t>& keys, unsigned int depth);

  /** \brief Empties the octree; nodes may then be added to its levels.
   * \param[in] depth number of levels, 1..max_grid_depth
   */
  void
  reset(unsigned int depth);

  unsigned int
  depth() const
  {
    return depth_;
  }

  const OccupancyLevel&
  level(unsigned int index) const
  {
    return levels_[index];
  }

  OccupancyLevel&
  level(unsigned int index)
  {
    return levels_[index];
  }

private:
  unsigned int depth_ = 0;
  std::array<OccupancyLevel, max_grid_depth> levels_;
};

/** \brief The most branch nodes that a decoder accepts in a frame of so many voxels:
 * for each of up to 2^20 voxels one a level, for each further voxel two; and one more a
 * level for the branch without voxels that remains where PCL enlarged an octree. */
std::size_t
maxBranchNodes(std::uint64_t voxels, unsigned int depth);

/** \brief Looks up the occupancy of nodes of a level in ascending order; 0 for a node
 * that does not exist. */
class OccupancyCursor {
public:
  OccupancyCursor() = default;
  explicit OccupancyCursor(const OccupancyLevel& level)
  : occupancy_(level.occupancy.data()), lookup_(level.nodes)
  {}

  std::uint8_t
  occupancyOf(std::uint64_t node)
  {
    const std::size_t index = lookup_.find(node);
    return index != not_in_list ? occupancy_[index] : std::uint8_t{0};
  }

private:
  const std::uint8_t* occupancy_ = nullptr;
  AscendingLookup<std::uint64_t> lookup_;
};

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "bytes/reserve_ahead.h"
#include "outliers/held_value.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief A voxel of the last frames. */
struct TrackedVoxel {
  std::uint16_t occupancy = 0;  ///< running mean, 2^16 is 1
  std::uint8_t empty_ticks = 0; ///< of a shown one, since the last frame that had it
  bool is_shown = false;
  HeldValue intensity;
};

using HeldColour = std::array<HeldValue, 3>;

/** \brief The voxels of the last frames and their blocks, ascending. */
struct TrackedVoxels {
  std::vector<std::uint64_t> blocks; ///< their keys
  std::vector<std::uint64_t> shown;  ///< cells of each block that are shown
  std::vector<std::uint64_t> seldom; ///< that are not
  // One for each voxel, up to a count: longer vectors are not initialised each frame.
  std::vector<TrackedVoxel> voxels;
  std::vector<HeldColour> colours; ///< empty without colours
  std::size_t count = 0;

  void
  clear()
  {
    blocks.clear();
    shown.clear();
    seldom.clear();
    count = 0;
  }

  void
  shrinkToFit()
  {
    blocks.shrink_to_fit();
    shown.shrink_to_fit();
    seldom.shrink_to_fit();
    voxels.resize(count);
    colours.resize(colours.empty() ? 0 : count);
    voxels.shrink_to_fit();
    colours.shrink_to_fit();
  }

  /** \brief Allocates memory for a number of voxels. */
  void
  reserve(std::size_t number, std::size_t block_number, bool has_colours)
  {
    io::reserveAhead(blocks, block_number);
    io::reserveAhead(shown, block_number);
    io::reserveAhead(seldom, block_number);
    io::ensureSize(voxels, number);
    io::ensureSize(colours, has_colours ? number : 0);
  }

  /** \brief Appends the block of the last voxels, if it has any, or adds some of its
   * cells. */
  void
  pushBlock(std::uint64_t key, std::uint64_t shown_cells, std::uint64_t seldom_cells)
  {
    if ((shown_cells | seldom_cells) == 0)
      return;
    if (blocks.empty() || blocks.back() != key) {
      blocks.push_back(key);
      shown.push_back(0);
      seldom.push_back(0);
    }
    shown.back() |= shown_cells;
    seldom.back() |= seldom_cells;
  }
};

/** \brief The key of a voxel in another grid of the same lattice; none outside. */
inline std::optional<std::uint64_t>
keyInGrid(const io::VoxelGrid& grid, const io::VoxelGrid& from, std::uint64_t key)
{
  const io::VoxelPosition at = io::voxelPosition(key);
  std::array<std::int64_t, 3> to = {at.x, at.y, at.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to[axis] += std::int64_t{from.first_index[axis]} - grid.first_index[axis];
    if (to[axis] < 0 || to[axis] >= static_cast<std::int64_t>(grid.size()))
      return std::nullopt;
  }
  return io::mortonKey({static_cast<std::uint32_t>(to[0]),
                        static_cast<std::uint32_t>(to[1]),
                        static_cast<std::uint32_t>(to[2])});
}

} // namespace pcl_ext::PCL_EXT_ABI

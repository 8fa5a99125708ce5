// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "outliers/held_value.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
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
  reserve(std::size_t number, bool has_colours)
  {
    io::ensureSize(voxels, number);
    io::ensureSize(colours, has_colours ? number : 0);
  }

  /** \brief Appends a voxel, for which there is memory; its block comes after its
   * voxels. */
  void
  push(const TrackedVoxel& voxel, const HeldColour* colour)
  {
    voxels[count] = voxel;
    if (colour != nullptr)
      colours[count] = *colour;
    ++count;
  }

  /** \brief The colour of a voxel, if it has one. */
  const HeldColour*
  colourOf(std::size_t voxel) const
  {
    return colours.empty() ? nullptr : &colours[voxel];
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

} // namespace pcl_ext::PCL_EXT_ABI

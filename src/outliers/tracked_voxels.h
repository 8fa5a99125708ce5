// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "bytes/reserve_ahead.h"
#include "outliers/block_neighbours.h"
#include "outliers/held_value.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief How often a voxel was occupied in the last frames. */
struct TrackedVoxel {
  std::uint16_t occupancy = 0;  ///< running mean, 2^16 is 1
  std::uint8_t empty_ticks = 0; ///< of a shown one, since the last frame that had it
};

using HeldColour = std::array<HeldValue, 3>;

/** \brief A block of voxels of the last frames. Each of its octants that has tracked cells
 * has eight records, one for each of its voxels. */
struct TrackedBlock {
  std::uint64_t key;
  std::uint64_t shown;                  ///< cells that are shown
  std::uint64_t seldom;                 ///< that are tracked and are not
  std::uint64_t hits;                   ///< that the current frame has
  std::array<std::uint32_t, 8> records; ///< the first one of each octant

  std::uint32_t
  recordOf(unsigned int cell) const
  {
    return records[cell >> 3] + (cell & 7);
  }
};

/** \brief The records of voxels. They stay where they are as long as their octant has
 * cells, as moving them would take longer than what is done with them. */
struct VoxelRecords {
  std::vector<TrackedVoxel> voxels;
  std::vector<HeldValue> intensities; ///< empty without intensities
  std::vector<HeldColour> colours;    ///< empty without colours
  std::vector<std::uint32_t> unused;  ///< the first ones of octants that have no cells

  /** \brief Gives an octant its records.
   * \return the first one, below 2^31
   * \throws std::bad_alloc if there are no more */
  std::uint32_t
  allocate(bool has_intensities, bool has_colours)
  {
    if (unused.empty()) {
#if defined(__cpp_exceptions) // else, as in WebAssembly, there is no memory for as many
      if (voxels.size() >> 31 != 0)
        throw std::bad_alloc();
#endif
      unused.push_back(static_cast<std::uint32_t>(voxels.size()));
      const auto append = [](auto& vector) {
        io::reserveAhead(vector, vector.size() + 8);
        vector.resize(vector.size() + 8);
      };
      append(voxels);
      if (has_intensities)
        append(intensities);
      if (has_colours)
        append(colours);
    }
    const std::uint32_t first = unused.back();
    unused.pop_back();
    return first;
  }
};

/** \brief The blocks of what is tracked and of a frame, as they were before it: ascending,
 * and one more, of blocks that are not there. */
struct MergedBlocks {
  std::vector<TrackedBlock> blocks;
  BlocksAround around;
};

/** \brief The key of a voxel in another grid of the same lattice; none outside. */
inline std::optional<std::uint64_t>
keyInGrid(const io::VoxelGrid& grid, const io::VoxelGrid& from, std::uint64_t key)
{
  if (grid == from)
    return key;
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

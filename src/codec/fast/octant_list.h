// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/symbol_lanes.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace fast {

// A list of the occupied octants of many blocks: its elements are 8 times the index of
// the block plus the octant. A loop over it has no loops over octants or cells inside,
// whose ends would be mispredicted (doc/implementation_notes.md, "Branches").

/** \brief Elements or cells that are written at a time, also beyond the end of a
 * list. */
constexpr std::size_t list_excess = 8;

/** \brief Appends the occupied octants of a block.
 * \param[in] block its index
 * \param[in] cells occupied ones
 * \param[out] end end of the list; `list_excess` elements are written
 * \return the new end
 */
inline std::uint32_t*
appendOctants(std::uint32_t block, std::uint64_t cells, std::uint32_t* end)
{
  const unsigned int octants = occupiedOctants(cells);
  addToBytes(child_masks.children[octants].data(), 8 * block, end);
  return end + child_masks.count[octants];
}

/** \brief The occupied cells of an element of the list.
 * \param[in] cells of the blocks
 */
inline unsigned int
cellsOfOctant(std::uint32_t element, const std::uint64_t* cells)
{
  return static_cast<unsigned int>(cells[element / 8] >> (8 * (element % 8))) & 0xff;
}

/** \brief Adds the cells of an octant to a number.
 * \param[in] cells occupied ones
 * \param[in] number index or key of the octant's first cell
 * \param[out] sums `list_excess` of them; those beyond the number of cells have any
 * value
 */
template <class Number>
void
addCells(unsigned int cells, Number number, Number* sums)
{
  addToBytes(child_masks.children[cells].data(), number, sums);
}

} // namespace fast
} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "simd/symbol_lanes.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The occupied octants of many blocks, to list the voxels of these. A loop over
 * octants has no loops over octants or cells inside, whose ends would be mispredicted
 * (doc/implementation_notes.md, "Branches"). */
class OctantList {
public:
  /** \brief Sets the octants to those of some blocks.
   * \param[in] blocks number of them, below 2^29
   * \param[in] voxels upper bound of their number
   * \param[in] cells_of returns the occupied cells of a block
   */
  template <class CellsOf>
  void
  assign(std::size_t blocks, std::size_t voxels, const CellsOf& cells_of)
  {
    ensureSize(octants_, voxels + excess);
    std::uint32_t* end = octants_.data();
    for (std::size_t i = 0; i < blocks; ++i) {
      const unsigned int octants = occupiedOctants(cells_of(i));
      end = appendCells(octants, static_cast<std::uint32_t>(8 * i), end);
    }
    count_ = static_cast<std::size_t>(end - octants_.data());
  }

  /** \brief Visits the octants, ascending.
   * \param[in] cells_of as above
   * \param[in] visit_octant called with the index of the block, the octant's first cell
   * and a mask of its eight cells
   */
  template <class CellsOf, class Visit>
  void
  visit(const CellsOf& cells_of, Visit visit_octant) const
  {
    const std::uint32_t* const end = octants_.data() + count_;
    for (const std::uint32_t* octant = octants_.data(); octant != end; ++octant) {
      const std::size_t block = *octant / 8;
      const std::uint32_t first_cell = 8 * (*octant % 8);
      visit_octant(block,
                   first_cell,
                   static_cast<unsigned int>(cells_of(block) >> first_cell) & 0xff);
    }
  }

  /** \brief Lists the Morton keys of the voxels, ascending.
   * \param[in] voxels their number
   * \param[in] cells_of as above
   * \param[in] key_of returns the Morton key of a block
   */
  template <class CellsOf, class KeyOf>
  void
  listKeys(std::size_t voxels,
           const CellsOf& cells_of,
           const KeyOf& key_of,
           std::vector<std::uint64_t>& keys) const
  {
    reserveAhead(keys, voxels + excess);
    keys.resize(voxels + excess);
    const auto append = [&, end = keys.data()](std::size_t block,
                                               std::uint32_t first_cell,
                                               unsigned int cells) mutable {
      end = appendCells(cells, (key_of(block) << block_key_bits) + first_cell, end);
    };
    visit(cells_of, append);
    keys.resize(voxels);
  }

  /** \brief Appends the numbers of an octant's cells.
   * \param[in] cells mask of them
   * \param[in] first number of the octant's first cell; the others follow
   * \param[out] end of the list; `excess` numbers are written
   * \return the new end
   */
  template <class Number>
  static Number*
  appendCells(unsigned int cells, Number first, Number* end)
  {
    addToBytes(child_masks.children[cells].data(), first, end);
    return end + child_masks.count[cells];
  }

  /** \brief Numbers that are written at a time, also beyond the end of a list. */
  static constexpr std::size_t excess = 8;

private:
  std::vector<std::uint32_t>
      octants_;           ///< 8 times the index of the block plus the octant
  std::size_t count_ = 0; ///< elements from here on are unused
};

} // namespace pcl_ext::PCL_EXT_ABI::io

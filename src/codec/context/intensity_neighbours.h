// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "codec/context/frame_blocks.h"
#include "voxels/lower_neighbours.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief The face neighbours of a voxel whose symbol is coded: all voxels of the frame
 * are known, and the symbols of those before it, which are the lower ones on each
 * axis. */
class IntensityNeighbours : public LowerNeighbours {
public:
  /** \brief Looks in a frame.
   * \param[in] frame its blocks
   * \param[in] levels octree levels above the blocks
   * \param[in] directory memory for one of the blocks
   */
  IntensityNeighbours(const BlockList& frame,
                      unsigned int levels,
                      FrameDirectory& directory)
  : LowerNeighbours(frame, levels, directory), beside_(directory.beside)
  {}

  /** \brief Finds the neighbours of all blocks of the frame. */
  void
  begin()
  {
    LowerNeighbours::begin();
    std::array<std::uint32_t, face_count> alone;
    alone.fill(none);
    reserveAhead(beside_, blockCount());
    beside_.assign(blockCount(), alone);
    for (std::uint32_t block = 0; block < beside_.size(); ++block)
      for (std::size_t face = 0; face < lower_faces; ++face) {
        const std::uint32_t lower = indexAcross(block, face);
        beside_[block][face] = lower;
        if (lower != none)
          beside_[lower][face + lower_faces] = block;
      }
  }

  /** \brief Selects a block of the frame. */
  void
  moveTo(std::size_t block)
  {
    select(block, beside_[block].data());
    for (std::size_t face = 0; face < face_count; ++face)
      across_[face] =
          occupiedAcross(selected().mask, blockAt(beside_[block][face]).mask, face);
  }

  /** \brief Across which faces of a cell there are voxels: bits 0..5. */
  std::uint32_t
  facesOf(unsigned int cell) const
  {
    std::uint32_t faces = 0;
    for (std::size_t face = 0; face < face_count; ++face)
      faces |= static_cast<std::uint32_t>(across_[face] >> cell & 1) << face;
    return faces;
  }

  /** \brief Average symbol of a cell's lower neighbours, in sixteenths.
   * \param[in] cell of the block
   * \param[in] symbols of the frame's voxels, of which those before this one are coded
   * \param[in] otherwise returned if it has none
   */
  std::uint32_t
  averageOf(unsigned int cell,
            const std::vector<std::uint16_t>& symbols,
            std::uint32_t otherwise) const
  {
    std::uint32_t sum = 0;
    std::uint32_t count = 0;
    visitEachSide(cell, [&](std::size_t voxel, std::uint32_t is_there) {
      sum += symbols[voxel] * is_there;
      count += is_there;
    });
    return count == 0 ? otherwise : count == 3 ? 16 * sum / 3 : 16 * sum >> (count - 1);
  }

private:
  std::vector<std::array<std::uint32_t, face_count>>& beside_;
  std::array<std::uint64_t, face_count> across_{}; ///< cells with a neighbour there
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

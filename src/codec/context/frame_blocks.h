// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "bytes/reserve_ahead.h"
#include "codec/context/history.h"
#include "codec/context/node_blocks.h"
#include "codec/depth_split.h"
#include "voxels/block_directory.h"
#include "voxels/octant_list.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Parameters of coding a frame, the same in encoder and decoder. */
struct FrameParameters {
  const History& history;        ///< of the previous frames; may be empty
  unsigned int grid_depth;       ///< 1..21
  unsigned int symbol_bits;      ///< 1..16, or 0: neither intensities nor points
  const DepthModel* depth_model; ///< null if intensities do not depend on depth

  std::uint32_t
  maxSymbol() const
  {
    return (std::uint32_t{1} << symbol_bits) - 1;
  }
};

/** \brief Finds the blocks of a frame, and has memory for what is around its voxels. */
struct FrameDirectory : BlockDirectory {
  /** \brief Of each block, those across the six faces. */
  std::vector<std::array<std::uint32_t, face_count>> beside;
  std::vector<std::uint32_t> smoothed; ///< see LocalExpectation
};

/** \brief The blocks of a frame while its occupancy is coded; passed from stage to
 * stage. Kept from frame to frame so that its memory is reused. */
struct FrameBlocks {
  /** \brief The occupied cells: of the blocks of the history, then of the new
   * blocks. */
  NodeBlockLevel blocks;
  std::vector<std::uint64_t> new_keys; ///< of the new blocks, ascending
  /** \brief Of each block of the history, those of it across the six faces; and one
   * element after them, which is not used. */
  std::vector<std::array<std::uint32_t, face_count>> neighbours;
  FrameDirectory directory; ///< scratch memory of the intensities
  OctantList octants;       ///< scratch memory, decoder only

  // Encoder only: the frame's voxels in each block of the history, and the new blocks,
  // ascending. In a decoder target_cells is 0 and the others are empty.
  std::vector<std::uint64_t> target_cells;
  std::vector<std::uint64_t> target_keys;
  std::vector<std::uint64_t> target_masks;

  NodeBlockLevel node_blocks;          ///< of the level that is coded, above the blocks
  std::vector<std::uint64_t> parents;  ///< nodes whose children are coded, ascending
  std::vector<std::uint64_t> children; ///< those found, ascending
  std::vector<std::uint32_t>
      parent_blocks; ///< index of the node block of each parent's children

  /** \brief Begins a frame to decode.
   * \param[in] history before the frame
   */
  void
  begin(const History& history);

  /** \brief Begins a frame to encode: divides its voxels into tracked and new ones.
   * \param[in] history before the frame
   * \param[in] coded blocks of the frame
   * \return number of tracked voxels
   */
  std::size_t
  match(const History& history, const BlockList& coded);

  /** \brief The blocks that were coded, ascending. */
  void
  collect(const History& history, BlockList& coded) const;
};

/** \brief Copies symbols, with reserveAhead(). */
inline void
copySymbols(const std::vector<std::uint16_t>& from, std::vector<std::uint16_t>& to)
{
  reserveAhead(to, from.size());
  to.assign(from.begin(), from.end());
}

/** \brief The intensities of a frame's voxels, or their numbers of points where it has
 * no intensities, while they are coded. */
struct CodedIntensities {
  /** \brief Coded first: the number of points where it can be derived from the depth
   * model, else the symbol itself. */
  std::vector<std::uint16_t> base_symbols;
  std::vector<std::uint16_t> symbols;
  /** \brief Symbols of the numbers of points, where the frame has these beside
   * intensities. */
  std::vector<std::uint16_t> point_symbols;
  // With a depth model only.
  DepthSplit split;
  std::vector<DepthPrediction> predictions;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io

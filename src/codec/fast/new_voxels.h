// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/fast/frame_blocks.h"
#include "codec/fast/history.h"
#include "codec/fast/models.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Codes the new voxels in tracked blocks (doc/bitstream_fast.md, "New voxels in
 * tracked blocks"): which blocks and octants have new voxels, then which cells they
 * are.
 *
 * A Coder is NibbleEncoder or NibbleDecoder.
 */
class NewVoxels {
public:
  /** \brief Codes a frame whose tracked voxels are coded.
   * \param[in] before the history before the frame
   * \param[in] statistics of the history, only to prefetch them
   * \param[in,out] frame a decoder sets the occupied cells; both directions set
   * octant_symbols and renewed_blocks
   * \return false if the bytes are invalid; never in an encoder
   */
  template <class Coder>
  bool
  code(Coder& coder,
       Models& models,
       const History& before,
       const StatisticsTable& statistics,
       FrameBlocks& frame);

  /** \brief Finds the blocks with new voxels of a frame that is known, as code() does.
   * \param[in,out] frame octant_symbols and renewed_blocks are set
   */
  static void
  findRenewedBlocks(const History& before, FrameBlocks& frame);

private:
  template <class Coder>
  bool
  codeOctants(Coder& coder,
              Models& models,
              const History& before,
              const StatisticsTable& statistics,
              FrameBlocks& frame);

  static void
  collectRenewedBlocks(const History& before, FrameBlocks& frame);

  template <class Coder>
  bool
  codeOctantMasks(Coder& coder,
                  Models& models,
                  const History& before,
                  FrameBlocks& frame);

  template <class Coder>
  bool
  codeCells(Coder& coder,
            Models& models,
            const History& before,
            const StatisticsTable& statistics,
            FrameBlocks& frame);

  template <bool is_decoder>
  bool
  setSingleCells(FrameBlocks& frame, std::size_t& several_count);

  template <class Coder>
  bool
  codeSeveralCells(Coder& coder,
                   Models& models,
                   std::size_t count,
                   const History& before,
                   FrameBlocks& frame);

  /** \brief Cells of an octant before its new voxels are coded. */
  struct Surroundings {
    std::uint8_t near; ///< open cells that share a face with an occupied cell
    std::uint8_t open; ///< cells of the grid that are not tracked
  };

  // Used up to a count, not resized to it.
  std::vector<std::uint8_t> contexts_; // of the row that is coded
  // Blocks with new voxels in several octants, then octants with several new voxels.
  std::vector<std::uint32_t> several_;
  std::size_t octant_count_ = 0;
  std::vector<CellIndex> octants_; // first cells of octants with new voxels
  std::vector<Surroundings> surroundings_;
  std::vector<std::uint8_t> cell_symbols_;
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/depth_split.h"
#include "codec/rans/classed_row.h"
#include "voxels/voxel_block.h"

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief The part of a payload after its base symbols where there is a depth model
 * (doc/bitstream_fast.md, "Residuals"). */
class DepthResiduals {
public:
  /** \brief Begins a frame for an encoder.
   * \param[in] frame with a depth model
   * \return its base symbols; valid until the next frame
   */
  const std::vector<std::uint16_t>&
  baseSymbolsOf(const VoxelFrame& frame);

  /** \brief Appends the residuals of the frame, and adapts the models. */
  void
  encode(const VoxelFrame& frame, bool is_i_frame, std::vector<std::uint8_t>& payload);

  /** \brief Decodes the residuals of a frame; learn() then adapts the models.
   * \param[in] begin first byte
   * \param[in] end one past the last byte
   * \param[in,out] frame its intensities are base symbols before, symbols after
   * \return false if the bytes are invalid
   */
  bool
  decode(const std::uint8_t* begin,
         const std::uint8_t* end,
         bool is_i_frame,
         VoxelFrame& frame);

  /** \brief Adapts the models to the frame that was decoded last. */
  void
  learn() noexcept
  {
    residuals_.learn();
  }

  /** \brief Returns to the initial models, as at an I-frame. */
  void
  reset() noexcept
  {
    residuals_.reset();
  }

  /** \brief Releases the memory of the last frame. */
  void
  releaseMemory();

private:
  void
  beginSplit(const VoxelFrame& frame);

  void
  collectClasses();

  rans::ClassedRow residuals_;

  /** \brief Scratch of the current frame; a member so that its memory is reused. */
  struct Workspace {
    BlockList blocks;
    DepthSplit split;
    std::vector<std::uint16_t> base_symbols;
    std::vector<std::uint16_t> row;
    std::vector<std::uint8_t> row_classes;
  };
  Workspace work_;
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

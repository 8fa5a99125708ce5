// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/supplement/colour_history.h"
#include "codec/supplement/colours.h"
#include "codec/supplement/content.h"
#include "codec/supplement/fields.h"
#include "codec/supplement/refinement.h"
#include "codec/supplement/residuals.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Bytes of a supplement by what they code. */
struct Sizes {
  std::size_t voxels = 0;
  std::size_t attributes = 0;
};

/** \brief Parameters of coding a supplement, the same in encoder and decoder. */
struct Parameters {
  const Content& content;                          ///< has a supplement
  const std::vector<std::uint64_t>& coarse_voxels; ///< keys, if the content has levels
  Effort effort;                                   ///< of the refinement
  bool is_i_frame;                                 ///< forgets what was before
  std::size_t voxel_count;                         ///< 1 or more
  std::uint64_t point_count;                       ///< of the header; 0 without them
  const std::array<std::int32_t, 3>& viewpoint;    ///< of the last I-frame
};

/** \brief Codes what follows the payload of a PayloadCoder, or decodes it: the voxels
 * within coarse voxels, with their intensities and numbers of points,
 * colours and fields
 * (doc/bitstream_supplement.md). An instance is for one stream and one direction. After
 * an exception it can only be destroyed. */
class SupplementCoder {
public:
  /** \brief Appends the supplement of the next frame of the stream, and learns the
   * frame.
   * \param[in] parameters of the frame
   * \param[in] frame consistent
   * \param[in,out] bytes where to append
   */
  Sizes
  encode(const Parameters& parameters,
         const VoxelFrame& frame,
         std::vector<std::uint8_t>& bytes);

  /** \brief Decodes what encode() appended. learn() has to follow if the frame is
   * valid, nothing if it is not.
   * \param[in] parameters as for encode
   * \param[in] begin first byte
   * \param[in] end after the last byte; all must be used
   * \param[in,out] frame grid and scale are given; where the content has no voxels
   * all but colours and the numbers of fields; the rest is set
   * \param[out] sizes as encode returns
   * \return false if the bytes are no such supplement
   */
  bool
  decode(const Parameters& parameters,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         VoxelFrame& frame,
         Sizes& sizes);

  /** \brief Learns the frame that was decoded last. */
  void
  learn() noexcept;

  /** \brief Forgets all frames, as an I-frame without voxels does. */
  void
  reset() noexcept;

  /** \brief Releases the memory that models and history do not need. */
  void
  releaseMemory();

private:
  /** \brief Models as at an I-frame. */
  struct Models {
    rans::NibbleModel lengths; ///< of large numbers
    RefinementModels refinement;
    ResidualModels intensities;
    /** \brief By the number of bits of the last one. */
    std::array<rans::NibbleModel, 8> point_counts;
    ColourModels colours;
  };

  void
  reserveSymbols(const Parameters& parameters);

  template <class Coder, class FrameT>
  bool
  codeVoxels(Coder& coder, const Parameters& parameters, FrameT& frame);

  template <class Coder, class FrameT>
  bool
  codeAttributes(Coder& coder, const Parameters& parameters, FrameT& frame);

  template <class CodingT, class FrameT>
  bool
  codeIntensities(CodingT& coding, FrameT& frame);

  template <class CodingT, class CountsT>
  bool
  codePointCounts(CodingT& coding, CountsT& counts);

  template <class CodingT, class FrameT>
  bool
  codeColours(CodingT& coding, const Parameters& parameters, FrameT& frame);

  std::unique_ptr<Models> models_ = std::make_unique<Models>();
  std::unique_ptr<Models> next_models_ = std::make_unique<Models>();
  ColourHistory history_;
  FieldCoder fields_;
  bool changes_history_ = false;
  bool changes_fields_ = false;
  // Of the current frame; members so that their memory is reused.
  BlockList blocks_;
  BlockDirectory directory_;
  std::vector<std::uint32_t> ranges_;
  std::vector<std::uint16_t> words_;
  std::vector<std::uint8_t> bytes_;
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/rans/nibble_model.h"
#include "codec/supplement/direction_table.h"
#include "codec/supplement/numbers.h"
#include "voxels/block_directory.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Models of the sizes and the bits of large numbers. */
struct WideNumberModels {
  rans::NibbleModel further_lengths;
  std::array<rans::NibbleModel, 65> tails; ///< highest bits, by length
};

/** \brief What encoder and decoder learn of one field. */
struct FieldState {
  static constexpr std::size_t activity_classes = 16;
  static constexpr std::size_t spread_classes = 8;

  std::array<rans::NibbleModel, activity_classes * spread_classes> lengths;
  rans::NibbleModel dictionary_lengths;
  WideNumberModels wide;
  bool has_dictionary = false;
  std::vector<std::uint64_t> dictionary; ///< ascending; of the last frame
  DirectionTable<Direction::azimuth_bins> by_azimuth;
  DirectionTable<Direction::elevation_bins> by_elevation;
  /** \brief The first number of each voxel of the last frame, of single values. */
  std::vector<std::uint64_t> last;
};

/** \brief Where the values of a frame's points are. In a scan each point is taken for a
 * voxel of its own, and they are in the order of their pixels. */
struct FieldPlaces {
  BlockList blocks;
  BlockDirectory directory;
  std::vector<std::array<std::uint32_t, 3>>
      lower; ///< voxels at -x, -y, -z (pixels: left, above), or itself
  std::vector<Direction> directions;       ///< of the voxels
  std::vector<std::uint32_t> before;       ///< index + 1 in the last frame; 0: none
  std::vector<std::uint32_t> first_points; ///< of each voxel, and the end
};

/** \brief The pixels of the points of a scan. */
struct PixelOrder {
  std::uint32_t width;
  std::uint32_t height;
  const std::vector<std::uint32_t>& pixels; ///< row * width + column, ascending
};

/** \brief Codes the fields of the frames of one stream, for either direction
 * (doc/bitstream_supplement.md, "Fields"). */
class FieldCoder {
public:
  /** \brief Codes the fields of a frame of voxels.
   * \param[in,out] coding a NumberCoding
   * \param[in] is_i_frame forgets what was before
   * \param[in] viewpoint position in the grid, voxels
   * \param[in,out] frame all but numbers of fields are given; the decoder sets these
   * \return false if what was decoded are no fields
   */
  template <class CodingT, class FrameT>
  bool
  code(CodingT& coding,
       bool is_i_frame,
       const std::array<std::int32_t, 3>& viewpoint,
       FrameT& frame)
  {
    findPlaces(viewpoint, frame);
    return codeFields(coding, is_i_frame, frame.fields);
  }

  /** \brief Codes the fields of a scan.
   * \param[in] order of its points, and of the numbers of the fields
   * \param[in,out] fields descriptions are given; the decoder sets the numbers
   */
  template <class CodingT, class FieldsT>
  bool
  codeScan(CodingT& coding, bool is_i_frame, const PixelOrder& order, FieldsT& fields)
  {
    findPixels(order);
    return codeFields(coding, is_i_frame, fields);
  }

  /** \brief Learns the frame that was coded last. */
  void
  learn() noexcept;

  /** \brief Forgets all frames. */
  void
  reset() noexcept;

  void
  releaseMemory();

private:
  void
  findPlaces(const std::array<std::int32_t, 3>& viewpoint, const VoxelFrame& frame);

  void
  findPixels(const PixelOrder& order);

  template <class CodingT, class FieldsT>
  bool
  codeFields(CodingT& coding, bool is_i_frame, FieldsT& fields);

  void
  preparePlaces(std::size_t count);

  std::vector<FieldState> states_;
  std::vector<FieldState> next_states_;
  std::vector<std::uint64_t> last_keys_;
  std::vector<std::uint64_t> next_keys_;
  // Of the current frame; members so that their memory is reused.
  FieldPlaces places_;
  std::vector<std::uint64_t> indices_;
  std::vector<std::uint32_t> by_pixel_; // points of a scan
};

extern template bool
FieldCoder::codeFields(NumberCoding<rans::NibbleEncoder>&,
                       bool,
                       const std::vector<FrameField>&);
extern template bool
FieldCoder::codeFields(NumberCoding<rans::NibbleDecoder>&,
                       bool,
                       std::vector<FrameField>&);

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/scan/scan_fields.h"
#include "codec/scan/scan_frame.h"
#include "codec/scan/symbol_coding.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Codes the points of scans, plane by plane (doc/bitstream_scan.md). An
 * instance is for one stream and one direction. After an exception it can only be
 * destroyed. */
class ScanCoder {
public:
  /** \brief Appends the points of the next frame of the stream, and learns them.
   * \param[in] is_i_frame it is coded without the frame before
   * \param[in] frame of a consistent layout
   * \param[in,out] bytes where to append
   * \param[in] threads where there are several, fields are coded beside the rest
   * \return of these what says where points are
   */
  std::size_t
  encode(bool is_i_frame,
         const ScanFrame& frame,
         std::vector<std::uint8_t>& bytes,
         unsigned int threads = 1);

  /** \brief Decodes what encode() appended. learn() has to follow if the frame is valid,
   * nothing if it is not.
   * \param[in] begin first byte
   * \param[in] end after the last byte; all must be used
   * \param[in] point_count points of the frame
   * \param[in,out] frame layout, grid, scale, colour_bits and the descriptions of
   * fields are given; the rest is set
   * \return false if the bytes are no such frame
   */
  bool
  decode(bool is_i_frame,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         std::uint64_t point_count,
         ScanFrame& frame);

  /** \brief Learns the frame that was decoded last. */
  void
  learn() noexcept;

  /** \brief Releases the memory that the next frame does not need. */
  void
  releaseMemory();

private:
  std::size_t
  encodePlanes(bool is_i_frame,
               const ScanFrame& frame,
               std::vector<std::uint8_t>& bytes);

  template <class PlanesT, class FrameT>
  bool
  codePlaces(PlanesT& planes,
             bool is_i_frame,
             std::uint64_t point_count,
             FrameT& frame);

  template <class PlanesT, class FrameT>
  bool
  codeFreePlaces(PlanesT& planes, std::uint64_t point_count, FrameT& frame);

  template <class PlanesT, class FrameT>
  bool
  codeFreePixels(PlanesT& planes, std::uint64_t point_count, FrameT& frame);

  template <class PlanesT, class FrameT>
  bool
  codeAttributes(PlanesT& planes, FrameT& frame);

  bool
  takePoints(ScanFrame& frame) const;

  template <class PlanesT, class FrameT>
  bool
  codeColumns(PlanesT& planes, FrameT& frame);

  template <class PlanesT, class FrameT>
  bool
  codeTurns(PlanesT& planes, FrameT& frame);

  void
  setSteps(const std::vector<std::uint32_t>& pixels,
           const std::vector<PointBesideRay>& beside);

  template <class PlanesT, class FrameT>
  bool
  codeSteps(PlanesT& planes, FrameT& frame);

  template <class PlanesT, class FrameT>
  bool
  codeColours(PlanesT& planes, FrameT& frame);

  template <class PlanesT, class ValueT>
  bool
  codeValues(PlanesT& planes,
             const ScanFrame& frame,
             std::uint32_t first,
             const ValueT& value);

  const std::uint32_t*
  alignPast(const ScanLayout& layout);

  // Of the frame before: depths of all pixels, and its columns' angles.
  std::vector<std::uint32_t> past_;
  std::uint32_t past_width_ = 0;
  std::vector<std::int32_t> past_columns_;
  ScanFields fields_;
  bool changes_fields_ = false;
  bool forgets_fields_ = false;
  // Of the current frame; members so that their memory is reused.
  std::vector<std::uint32_t> depths_;
  std::uint32_t width_ = 0;
  std::vector<std::int32_t> columns_;
  std::vector<std::uint32_t> aligned_past_; // in the columns of the frame
  std::vector<std::uint32_t> values_;
  std::vector<std::array<std::int32_t, 3>> steps_; // of points, from their depths
  SymbolWorkspace work_;
  std::vector<std::uint8_t> plane_bytes_;
  std::vector<std::uint8_t> field_bytes_;
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

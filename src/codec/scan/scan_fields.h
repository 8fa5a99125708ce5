// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/scan/scan_frame.h"
#include "codec/supplement/fields.h"

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Codes the further fields of the points of scans
 * (doc/bitstream_supplement.md, "Fields"). */
class ScanFields {
public:
  /** \brief Appends the fields of a frame with points, and learns them. */
  void
  encode(bool is_i_frame, const ScanFrame& frame, std::vector<std::uint8_t>& bytes);

  /** \brief Decodes what encode() appended; learn() has to follow if the frame is valid.
   * \param[in] end after the last byte; all must be used
   * \param[in,out] frame its points and the descriptions of fields are given
   * \return false if the bytes are no such fields
   */
  bool
  decode(bool is_i_frame,
         const std::uint8_t* begin,
         const std::uint8_t* end,
         ScanFrame& frame);

  void
  learn() noexcept
  {
    fields_.learn();
  }

  /** \brief Forgets all frames. */
  void
  reset() noexcept
  {
    fields_.reset();
  }

  void
  releaseMemory();

private:
  supplement::FieldCoder fields_;
  // Members so that their memory is reused.
  std::vector<std::uint32_t> ranges_;
  std::vector<std::uint16_t> words_;
  std::vector<std::uint8_t> bytes_;
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

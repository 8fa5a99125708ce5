// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_fields.h"

#include "codec/rans/entropy_coder.h"
#include "codec/supplement/numbers.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

void
ScanFields::encode(bool is_i_frame,
                   const ScanFrame& frame,
                   std::vector<std::uint8_t>& bytes)
{
  rans::NibbleEncoder coder(ranges_);
  rans::NibbleModel unused;
  supplement::NumberCoding<rans::NibbleEncoder> coding(coder, unused);
  fields_.codeScan(
      coding, is_i_frame, {frame.width, frame.height, frame.pixels}, frame.fields);
  coder = coding.coder();
  coder.finish(rans::interleavingOf(frame.pixels.size()), words_, bytes);
  fields_.learn();
}

bool
ScanFields::decode(bool is_i_frame,
                   const std::uint8_t* begin,
                   const std::uint8_t* end,
                   ScanFrame& frame)
{
  rans::NibbleDecoder coder(
      begin, end, rans::interleavingOf(frame.pixels.size()), bytes_);
  if (coder.isOverrun())
    return false;
  rans::NibbleModel unused;
  supplement::NumberCoding<rans::NibbleDecoder> coding(coder, unused);
  return fields_.codeScan(coding,
                          is_i_frame,
                          {frame.width, frame.height, frame.pixels},
                          frame.fields) &&
         coding.coder().isAtEnd();
}

void
ScanFields::releaseMemory()
{
  fields_.releaseMemory();
  ranges_ = std::vector<std::uint32_t>();
  words_ = std::vector<std::uint16_t>();
  bytes_ = std::vector<std::uint8_t>();
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_chain.h"

#include "bytes/checksum.h"
#include "stream/version1_header.h"

namespace pcl_ext::PCL_EXT_ABI::io {

std::uint32_t
checksumOf(const FrameDescription& frame, const std::uint8_t* bytes, std::size_t size)
{
  return frame.format == StreamFormat::Version1 ? version1ChecksumOf(bytes)
                                                : chainedChecksum(0, bytes, size);
}

FrameChain::Place
FrameChain::placeOf(const FrameDescription& frame,
                    const std::uint8_t* bytes,
                    std::size_t size) const
{
  if (!frame.is_i_frame && (!last_ || last_->format != frame.format ||
                            last_->number + 1 != frame.frame_number))
    return Place::Gap;
  const std::uint32_t reference = frame.is_i_frame ? 0 : last_->checksum;
  return frame.format != StreamFormat::Version1 ||
                 holdsVersion1Checksum(bytes, size, reference)
             ? Place::Next
             : Place::Damaged;
}

void
FrameChain::follow(const FrameDescription& frame,
                   const std::uint8_t* bytes,
                   std::size_t size)
{
  last_ = {frame.format, frame.frame_number, checksumOf(frame, bytes, size)};
}

FrameChain::Place
FrameChain::take(const FrameDescription& frame,
                 const std::uint8_t* bytes,
                 std::size_t size)
{
  const Place place = placeOf(frame, bytes, size);
  if (place == Place::Next)
    follow(frame, bytes, size);
  else
    breakOff();
  return place;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

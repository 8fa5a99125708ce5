// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/whole_frame.h"

#include <pcl_ext/compression/frame_decoder.h>

namespace pcl_ext::PCL_EXT_ABI::link {

std::optional<WholeFrame>
wholeFrameOf(const std::uint8_t* bytes, std::size_t size)
{
  // The limits are those of whoever decodes the frame.
  const io::DecoderLimits limits = io::DecoderLimits::none();
  const io::FrameSize known = io::frameSize(bytes, size, limits);
  if (!known.status.ok() || known.known != size)
    return std::nullopt;
  WholeFrame frame{io::describeFrame(bytes, size, limits), bytes, size};
  if (!frame.description.status.ok())
    return std::nullopt;
  return frame;
}

} // namespace pcl_ext::PCL_EXT_ABI::link

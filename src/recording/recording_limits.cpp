// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/recording_limits.h"

namespace pcl_ext::PCL_EXT_ABI::recording {

io::DecoderLimits
limitsOfReading()
{
  io::DecoderLimits limits = io::DecoderLimits::none();
  limits.max_frame_bytes = max_recorded_frame_bytes;
  return limits;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording

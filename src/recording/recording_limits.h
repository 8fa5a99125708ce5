// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/decoder_limits.h>

#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Largest frame that a reader takes, bytes. A decoder has limits of its own. */
constexpr std::size_t max_recorded_frame_bytes = std::size_t{1} << 28;

/** \brief Limits for looking at frames without decoding them. */
inline io::DecoderLimits
limitsOfReading()
{
  io::DecoderLimits limits = io::DecoderLimits::none();
  limits.max_frame_bytes = max_recorded_frame_bytes;
  return limits;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording

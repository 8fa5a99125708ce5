// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_reader.h>

#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Largest frame that a reader takes, bytes. A decoder has limits of its own. */
constexpr std::size_t max_recorded_frame_bytes = std::size_t{1} << 28;

/** \brief Limits for looking at frames without decoding them. */
io::DecoderLimits
limitsOfReading();

} // namespace pcl_ext::PCL_EXT_ABI::recording

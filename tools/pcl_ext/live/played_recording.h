// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_reader.h>

#include "console/console.h"
#include "live/live_output.h"

#include <functional>

namespace pcl_ext::tools {

/** \brief Passes on the frames of a recording at the pace of their times, but those that
 * cannot be decoded after those before them.
 * \param[in] rate frames a second, where the recording has no times
 * \param[in] meanwhile called about 20 times a second
 * \return false if some were left out
 * \throws std::runtime_error
 */
bool
playRecording(recording::RecordingReader& reader,
              double rate,
              LiveOutput& output,
              Console& console,
              const std::function<void()>& meanwhile);

} // namespace pcl_ext::tools

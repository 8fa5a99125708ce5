// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "bytes/exceptions.h"

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Calls a function that returns a status; if it throws, the status says why. */
template <typename FunctionT>
RecordingStatus
guarded(FunctionT function)
{
  return callOrElse(
      function,
      [] { return outOfMemoryStatus<RecordingStatus>(); },
      [](const char* what) {
        return RecordingStatus{RecordingCode::InputFailed, what};
      });
}

} // namespace pcl_ext::PCL_EXT_ABI::recording

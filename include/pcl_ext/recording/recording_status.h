// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/status.h>

#include <chrono>
#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \addtogroup recording
 * @{ */

/** \brief A time, since the epoch of the clock that stamps the clouds. */
using Time = std::chrono::nanoseconds;

/** \brief Outcomes of reading or writing a recording. */
enum class RecordingCode {
  Ok,
  EndOfRecording,  ///< there are no more frames or messages
  InputFailed,     ///< the file is missing, cannot be opened or cannot be read
  NotARecording,   ///< the file is of another kind; the message names it if it is known
  Damaged,         ///< bytes are missing or contradict themselves; others can be read
  InvalidArgument, ///< an unknown stream, a name that is taken or of no kind of output,
                   ///< a frame that is none
  OutputFailed,    ///< the output cannot be opened, or takes no more bytes
  OutOfMemory
};

/** \brief Outcome of reading or writing a recording. Messages name the file. */
using RecordingStatus = Status<RecordingCode>;

/** \brief What becomes of a file that has the name of an output when that is
 * complete. */
enum class ExistingFile {
  Replace,
  Keep ///< the output keeps its unfinished name, and the status is OutputFailed
};

/** \brief A place of a recording that could not be read. */
struct RecordingDamage {
  std::uint64_t offset = 0; ///< byte of the file at which it begins; 0 in a database
  std::string message;      ///< what is wrong there and what is lost
  std::string file;         ///< path of the file
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::recording

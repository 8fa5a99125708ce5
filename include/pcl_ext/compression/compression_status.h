#pragma once

#include <pcl_ext/status.h>

namespace pcl_ext {
namespace io {

/** \brief What came of encoding or decoding a frame. */
enum class CompressionCode {
  Ok,                 ///< the frame was encoded or decoded
  InvalidSettings,    ///< a setting is outside its range, or two contradict each other
  InvalidInput,       ///< no cloud, or a frame that breaks its own rules
  OutputFailed,       ///< the output stream took no more bytes
  EndOfStream,        ///< there are no bytes to decode
  NoFrame,            ///< there are bytes, but no frame begins among them
  UnsupportedVersion, ///< a frame of a stream version that this library does not know
  Truncated,          ///< the stream ends within a frame
  Corrupt,            ///< a frame contradicts its checksum or itself
  LimitExceeded,      ///< decoding would exceed a limit of DecoderLimits
  MissingReference,   ///< the frame depends on a frame that was not decoded
  InputFailed,        ///< the input stream failed while decoding
  OldFrame,           ///< a late or repeated frame; it was dropped, the stream goes on
  OutOfMemory         ///< memory ran out; the stream goes on with the next I-frame
};

/** \brief Outcome of encoding or decoding a frame, returned where PCL returns void. */
using CompressionStatus = Status<CompressionCode>;

} // namespace io
} // namespace pcl_ext

#pragma once

#include <ostream>
#include <string>
#include <utility>

namespace pcl_ext {

/** \brief Outcome of an operation that can fail on bad input: a code for programs and a
 * message for people.
 *
 * Clouds, frames, streams and settings that are bad are reported through this type and
 * never through exceptions. A success may have a message, too: a warning that not all of
 * the input is in the output.
 * \tparam CodeT an enumeration whose value `CodeT::Ok` means success
 */
template <typename CodeT>
class Status {
public:
  using Code = CodeT;

  /** \brief Success. */
  Status() = default;

  /** \brief A failure, or a success with a message.
   * \param[in] code the kind of outcome
   * \param[in] message what is wrong, with the value concerned
   */
  Status(CodeT code, std::string message) : code_(code), message_(std::move(message)) {}

  /** \brief True if the operation succeeded. */
  bool
  ok() const
  {
    return code_ == CodeT::Ok;
  }

  /** \brief The same as ok(). */
  explicit operator bool() const { return ok(); }

  /** \brief True if the operation succeeded, but message() says what was left out. */
  bool
  hasWarning() const
  {
    return ok() && !message_.empty();
  }

  /** \brief The kind of outcome. */
  CodeT
  code() const
  {
    return code_;
  }

  /** \brief What is wrong; empty on success without a warning. */
  const std::string&
  message() const
  {
    return message_;
  }

private:
  CodeT code_ = CodeT::Ok;
  std::string message_;
};

/** \brief Prints the message; "ok" if there is none. */
template <typename CodeT>
std::ostream&
operator<<(std::ostream& output, const Status<CodeT>& status)
{
  if (!status.message().empty())
    return output << status.message();
  return output << (status ? "ok" : "failed");
}

/** \brief The status when memory runs out. Its message fits into the string's internal
 * buffer, so that no memory is allocated for it.
 * \tparam StatusT a Status whose codes have an OutOfMemory
 */
template <typename StatusT>
StatusT
outOfMemoryStatus()
{
  return {StatusT::Code::OutOfMemory, "out of memory"};
}

namespace io {

/** \brief Outcomes of encoding or decoding a frame. */
enum class CompressionCode {
  Ok,                 ///< the frame was encoded or decoded; see Status::hasWarning
  InvalidSettings,    ///< a setting is outside its range, or two contradict each other
  InvalidInput,       ///< no cloud, or an inconsistent frame
  OutputFailed,       ///< the output stream accepted no more bytes
  EndOfStream,        ///< there are no bytes to decode
  NoFrame,            ///< there are bytes, but no frame begins in them
  UnsupportedVersion, ///< a frame of an unknown stream version
  Truncated,          ///< the stream ends within a frame
  Corrupt,            ///< a frame contradicts its checksum or itself
  LimitExceeded,      ///< decoding would exceed a limit of DecoderLimits
  MissingReference,   ///< the frame depends on a frame that was not decoded
  InputFailed,        ///< the input stream failed while decoding
  OldFrame,           ///< a late or repeated frame, which was dropped
  OutOfMemory         ///< memory ran out; the stream continues with the next I-frame
};

/** \brief Outcome of encoding or decoding a frame, returned where PCL returns void. */
using CompressionStatus = Status<CompressionCode>;

} // namespace io
} // namespace pcl_ext

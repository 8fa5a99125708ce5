// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <functional>
#include <ostream>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup common
 * @{ */

/** \brief A message that names settings: each is its id in braces, as in "{resolution} is
 * 0", so that a program can show its own names. Other opening braces are doubled. */
struct SettingText {
  std::string marked;

  /** \brief A message that names no setting. */
  PCL_EXT_CODEC_EXPORT static SettingText
  of(const std::string& message);

  /** \brief The message with names of the settings.
   * \param[in] name_of the name for an id
   */
  PCL_EXT_CODEC_EXPORT std::string
  with(const std::function<std::string(const std::string& id)>& name_of) const;

  /** \brief The message with the ids, which are the names of the fields of settings. */
  PCL_EXT_CODEC_EXPORT std::string
  withIds() const;
};

/** \brief Outcome of an operation that can fail on bad input: a code for programs and a
 * message for people.
 *
 * Clouds, frames, streams and settings that are bad are reported through this type and
 * never through exceptions. A success may have a message, too: a warning that not all
 * of the input is in the output.
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

  /** \brief The same with a message that names settings. */
  Status(CodeT code, SettingText text)
  : code_(code), message_(text.withIds()), marked_(std::move(text.marked))
  {}

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

  /** \brief The message, for a program that has its own names of settings, or for
   * another status. */
  SettingText
  text() const
  {
    return marked_.empty() ? SettingText::of(message_) : SettingText{marked_};
  }

  /** \brief Id of the setting that the message names first, which is the name of its
   * field, as "resolution"; empty if it names none. */
  std::string
  setting() const
  {
    std::string first;
    (void)text().with([&first](const std::string& id) {
      first = first.empty() ? id : first;
      return id;
    });
    return first;
  }

private:
  CodeT code_ = CodeT::Ok;
  std::string message_;
  std::string marked_; // of SettingText; empty if the message names no setting
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
  /** The frame was encoded or decoded. If hasWarning(), the message says how much of
   * the cloud is not in the frame and which setting helps: points outside of the grid
   * or the box or behind the sensor, intensities beyond the scale, colours; or that
   * voxels became coarser. Of a decoded scan: how many of its points have no voxel. PCL's
   * console shows each kind once. */
  Ok,
  /** A setting is outside its range, or two contradict each other: correct the one that
   * the message names. */
  InvalidSettings,
  /** The cloud is a null pointer, or a frame is inconsistent. An empty cloud is a valid
   * frame. */
  InvalidInput,
  /** The output stream is not open, had failed before, or accepted no more bytes: check
   * path, disk, connection. The next frame is an I-frame. */
  OutputFailed,
  /** There are no bytes to decode: the normal end of a file. */
  EndOfStream,
  /** There are bytes, but no frame begins in them. The message names bytes of PCL's
   * class, PCD and PLY files, bags, text. */
  NoFrame,
  /** A frame of a newer stream version: update the receiver. */
  UnsupportedVersion,
  /** The bytes end within a frame; frameSize() tells how many are missing. With
   * `settings.incomplete_frame = Keep` call again with more. */
  Truncated,
  /** A frame contradicts its checksum or itself: the transport changed bytes, or the
   * frame follows that of another stream: one decoder for each. Decoding goes on with the
   * next I-frame. */
  Corrupt,
  /** Decoding would exceed a limit of DecoderLimits: raise the one that the message
   * names, if you trust the sender. */
  LimitExceeded,
  /** A P-frame whose predecessor was lost: requestIFrame() at the sender, or wait for
   * the next I-frame. */
  MissingReference,
  /** The input stream is not open, had failed before, or failed while it was read:
   * check the path; clear() for a stream that had ended. */
  InputFailed,
  /** A late or repeated frame, or one of another stream, which was dropped; one decoder
   * for each stream. */
  OldFrame,
  /** Memory ran out; the stream continues with the next I-frame. */
  OutOfMemory,
  /** The cloud was left out, as RateSettings::max_rate has no room for it now; the next
   * one may have. */
  LeftOut
};

/** \brief Outcome of encoding or decoding a frame, returned where PCL returns void. */
using CompressionStatus = Status<CompressionCode>;

} // namespace io

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

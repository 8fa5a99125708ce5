// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_writer.h>

#include "console/console.h"
#include "outputs/output_path.h"
#include "site/frame_taker.h"
#include "streams/frame_failures.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief When a recording goes on in another file. */
struct Rotation {
  std::optional<double> seconds; ///< none: whatever its age
  std::optional<double> bytes;   ///< none: whatever its size

  bool
  isOn() const
  {
    return seconds || bytes;
  }
};

/** \brief Records the frames of a site, in one file or in one after the other. Each file
 * can be decoded without the others: a stream stays in the file before until it has an
 * I-frame, which is requested. A file has one set of metadata of a stream: with others
 * the next file begins, if there is a rotation; else that is told. */
class RotatedRecording : public FrameTaker {
public:
  using RequestIFrame = std::function<void(const std::string& stream)>;

  /** \param[in] output path of the file; with a rotation each has the time of its
   * beginning in its name
   * \param[in] is_replay an earlier file stays as it is if the program is interrupted
   * \param[in] request_i_frame of a stream that goes to another file, or has a frame
   * that cannot be recorded
   * \param[in] console prints which files are complete; must outlive this
   */
  RotatedRecording(const Output& output,
                   const Rotation& rotation,
                   bool is_replay,
                   RequestIFrame request_i_frame,
                   Console& console);

  void
  take(const link::LinkFrame& frame) override;

  void
  work() override;

  void
  finish() override;

  bool
  hasLeftOut() const override
  {
    return has_left_out_;
  }

  /** \brief Frames that files have for certain. */
  std::uint64_t
  framesWritten() const
  {
    return written_;
  }

private:
  using Clock = std::chrono::steady_clock;

  struct File {
    std::string path;
    recording::RecordingWriter writer;
    std::map<std::string, std::size_t>
        streams; ///< numbers by name; of those that go on
    Clock::time_point opened;
    std::uint64_t frames = 0;
  };

  std::string
  nextPath() const;

  bool
  isRotationDue() const;

  /** \brief Begins another file. */
  void
  rotate();

  void
  append(File& file, const link::LinkFrame& frame);

  /** \brief Adds a stream to a file, or tells that it does not take it.
   * \return its number in the file
   */
  std::optional<std::size_t>
  addStream(File& file, const link::LinkFrame& frame);

  /** \brief Tells that a stream goes on with other metadata than those of the file. */
  void
  tellOfMetadata(const std::string& stream);

  /** \brief Tells of a frame that is not recorded. */
  void
  leaveOut(const std::string& stream, const std::string& reason);

  void
  complete(std::optional<File>& file);

  /** \brief \throws std::runtime_error after a failure; what was written until then
   * stays. */
  void
  check(const File& file, const recording::RecordingStatus& status);

  const Output output_;
  const Rotation rotation_;
  const bool is_replay_;
  const RequestIFrame request_i_frame_;
  Console& console_;
  FrameFailures failures_;
  MetadataChanges metadata_changes_;
  std::uint64_t appended_ = 0;                 // frames, to all files
  std::uint64_t written_ = 0;                  // of these, when they were flushed last
  bool has_left_out_ = false;                  // frames, or metadata
  std::map<std::string, std::size_t> arrived_; // frames by stream, recorded or not
  std::map<std::string, std::string>
      refused_; // streams that files do not take, and why
  std::optional<File> current_;
  std::optional<File> before_; // until its streams have an I-frame
  Clock::time_point last_flush_{};
};

} // namespace pcl_ext::tools

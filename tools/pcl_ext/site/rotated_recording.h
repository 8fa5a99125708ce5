// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_writer.h>

#include "console/console.h"
#include "console/exit_status.h"
#include "console/throw_unless_ok.h"
#include "measuring/markdown_table.h"
#include "options/text_values.h"
#include "outputs/frame_output.h"
#include "outputs/output_path.h"
#include "site/frame_taker.h"
#include "streams/frame_failures.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

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
                   Console& console)
  : output_(output)
  , rotation_(rotation)
  , is_replay_(is_replay)
  , request_i_frame_(std::move(request_i_frame))
  , console_(console)
  , failures_([&console](const std::string& line) { console.error(line); })
  {
    if (kindOfOutput(output.path) == OutputKind::Folder || output.path == "-")
      throw UsageError("-o is '" + output.path +
                       "'; frames of a site are recorded in x.mcap or, of one stream, "
                       "x.pcxi");
    checkOutput(output.path);
    if (!rotation.isOn())
      refuseTakenFile({}, output.path, output.may_replace);
    rotate(); // so that a path that cannot be written to is told at once
  }

  void
  take(const link::LinkFrame& frame) override
  {
    ++arrived_[frame.stream];
    if (const auto refused = refused_.find(frame.stream); refused != refused_.end()) {
      leaveOut(frame.stream, refused->second);
      return;
    }
    const bool has_other_metadata = metadata_changes_.take(frame) &&
                                    current_->streams.count(frame.stream) > 0 &&
                                    kindOfOutput(current_->path) == OutputKind::Mcap;
    if (isRotationDue() || (has_other_metadata && rotation_.isOn() && !before_))
      rotate();
    else if (has_other_metadata)
      tellOfMetadata(frame.stream);
    if (before_ && !frame.is_i_frame && before_->streams.count(frame.stream) > 0) {
      append(*before_, frame);
      return;
    }
    if (!frame.is_i_frame && current_->streams.count(frame.stream) == 0) {
      leaveOut(frame.stream, "no I-frame has come for this file");
      request_i_frame_(frame.stream);
      return;
    }
    append(*current_, frame);
    if (before_) {
      before_->streams.erase(frame.stream);
      if (before_->streams.empty())
        complete(before_);
    }
  }

  void
  work() override
  {
    const Clock::time_point now = Clock::now();
    if (before_ && now - current_->opened > longest_handover)
      complete(before_);
    if (now - last_flush_ < flush_interval)
      return;
    last_flush_ = now;
    for (std::optional<File>* const file : {&before_, &current_})
      if (*file)
        check(**file, (*file)->writer.flush());
    written_ = appended_;
  }

  void
  finish() override
  {
    failures_.finish();
    complete(before_);
    complete(current_);
  }

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

  static constexpr std::chrono::seconds flush_interval{1};
  static constexpr std::chrono::seconds longest_handover{10};

  static std::string
  timeForNames()
  {
    constexpr std::size_t longest = 32;
    std::array<char, longest> text{};
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    ::gmtime_r(&now, &utc);
    const std::size_t size =
        std::strftime(text.data(), text.size(), "_%Y%m%dT%H%M%SZ", &utc);
    return {text.data(), size};
  }

  struct File {
    std::string path;
    recording::RecordingWriter writer;
    std::map<std::string, std::size_t>
        streams; ///< numbers by name; of those that go on
    Clock::time_point opened;
    std::uint64_t frames = 0;
  };

  std::string
  nextPath() const
  {
    if (!rotation_.isOn())
      return output_.path;
    const std::filesystem::path given(output_.path);
    const std::string stem =
        (given.parent_path() / given.stem()).string() + timeForNames();
    const std::string extension = given.extension().string();
    std::string path = stem + extension;
    for (unsigned int number = 2; std::filesystem::exists(path) ||
                                  std::filesystem::exists(path + unfinished_suffix) ||
                                  (before_ && before_->path == path);
         ++number)
      path = stem + "_" + std::to_string(number) + extension;
    return path;
  }

  bool
  isRotationDue() const
  {
    if (current_->frames == 0 || before_)
      return false;
    const std::chrono::duration<double> age = Clock::now() - current_->opened;
    return (rotation_.seconds && age.count() >= *rotation_.seconds) ||
           (rotation_.bytes &&
            static_cast<double>(current_->writer.bytes()) >= *rotation_.bytes);
  }

  /** \brief Begins another file. */
  void
  rotate()
  {
    before_ = std::move(current_);
    current_.reset();
    const std::string path = nextPath();
    current_ = File();
    current_->path = path;
    current_->opened = Clock::now();
    if (const auto opened = current_->writer.open(path); !opened.ok()) {
      current_.reset(); // what there is of that name is somebody else's
      throwUnlessOk(opened);
    }
    if (before_)
      for (const auto& [stream, number] : before_->streams)
        request_i_frame_(stream);
  }

  void
  append(File& file, const link::LinkFrame& frame)
  {
    const auto found = file.streams.find(frame.stream);
    const std::optional<std::size_t> number =
        found != file.streams.end() ? found->second : addStream(file, frame);
    if (!number)
      return;
    const auto appended =
        file.writer.append(*number, frame.time, frame.bytes.data(), frame.bytes.size());
    // A full disk ends the recording; a frame that cannot be recorded does not.
    if (appended.code() == recording::RecordingCode::InvalidArgument) {
      leaveOut(frame.stream, appended.message());
      request_i_frame_(frame.stream);
      return;
    }
    check(file, appended);
    ++file.frames;
    ++appended_;
  }

  /** \brief Adds a stream to a file, or tells that it does not take it.
   * \return its number in the file
   */
  std::optional<std::size_t>
  addStream(File& file, const link::LinkFrame& frame)
  {
    std::size_t number = 0;
    const auto added =
        file.writer.addStream({frame.stream, "", frame.metadata}, number);
    if (added.code() == recording::RecordingCode::InvalidArgument) {
      refused_.emplace(frame.stream, added.message());
      leaveOut(frame.stream, added.message());
      return std::nullopt;
    }
    check(file, added);
    file.streams.emplace(frame.stream, number);
    return number;
  }

  /** \brief Tells that a stream goes on with other metadata than those of the file. */
  void
  tellOfMetadata(const std::string& stream)
  {
    console_.error(
        stream +
        ": its sender began anew with other metadata, as where its sensor was "
        "moved: " +
        current_->path + " keeps the first ones" +
        (rotation_.isOn() ? ""
                          : "; --rotate-every or --rotate-size begin a new file then"));
    has_left_out_ = true;
  }

  /** \brief Tells of a frame that is not recorded. */
  void
  leaveOut(const std::string& stream, const std::string& reason)
  {
    failures_.add(stream, arrived_[stream] - 1, "", "it is not recorded: " + reason);
    has_left_out_ = true;
  }

  void
  complete(std::optional<File>& file)
  {
    if (!file)
      return;
    if (file->frames > 0) {
      const bool keeps_earlier =
          is_replay_ && !rotation_.isOn() && keepsEarlierOutput(file->path);
      if (keeps_earlier)
        file->writer = recording::RecordingWriter(); // writes what it has
      else
        check(*file,
              file->writer.finish(rotation_.isOn() ? recording::ExistingFile::Keep
                                                   : output_.existing()));
      constexpr double megabyte = 1e6;
      std::error_code ignored;
      const auto bytes = std::filesystem::file_size(
          file->path + (keeps_earlier ? unfinished_suffix : ""), ignored);
      console_.summary(
          file->path + ": " + counted(file->frames, "frame") + ", " +
          measuring::formatted(static_cast<double>(bytes) / megabyte, 2) + " MB" +
          (is_replay_ ? describeInterruption(file->path, keeps_earlier) : ""));
    }
    file.reset();
  }

  /** \brief \throws std::runtime_error after a failure; what was written until then
   * stays. */
  void
  check(const File& file, const recording::RecordingStatus& status)
  {
    if (status.ok())
      return;
    const std::string path = file.path;
    // They remove their files if these hold nothing.
    before_.reset();
    current_.reset();
    throw std::runtime_error(status.message() + describeUnfinished(path));
  }

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

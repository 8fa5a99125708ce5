// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_description.h>

#include "console/console.h"
#include "live/live_output.h"
#include "stream/frame_chain.h"
#include "streams/frame_failures.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Passes on the frames of the standard input as they arrive: those of one
 * stream, one after the other. */
class PipedFrames {
public:
  /** \param[in] name of the stream */
  PipedFrames(LiveOutput& output, const std::string& name, Console& console)
  : output_(output)
  , name_(name)
  , console_(console)
  , failures_([&console](const std::string& line) { console.error(line); })
  {}

  /** \brief Publishes frames until the input ends or the program is interrupted, and
   * then the end. Frames that cannot be decoded after those before them are left out.
   * \param[in] meanwhile called at least ten times a second; may be empty
   * \return false if something was left out, but for bytes before the first frame and
   * frames before the first I-frame
   * \throws std::runtime_error if the input has no frame that can be decoded
   */
  bool
  run(const std::function<void()>& meanwhile = {});

private:
  /** \brief Waits for bytes and appends them; false at the end. */
  bool
  receive(const std::function<void()>& meanwhile);

  void
  publishFrames();

  /** \brief Publishes a frame, or tells that it is left out. */
  void
  publish(const std::uint8_t* frame, std::size_t size);

  /** \brief Why no frame was published. */
  std::string
  emptiness() const;

  /** \brief Tells what was left out; false if that is damage. */
  bool
  report();

  std::chrono::nanoseconds
  timeOf(const io::FrameDescription& frame);

  LiveOutput& output_;
  const std::string name_;
  Console& console_;
  std::size_t stream_ = 0;
  std::vector<std::uint8_t> bytes_; // that arrived and are not published yet
  std::size_t needed_ = 1;          // bytes, for the next step
  std::size_t frames_ = 0;          // published or left out
  std::size_t frames_early_ = 0;    // before the first I-frame
  std::size_t frames_published_ = 0;
  io::FrameChain chain_; // of these
  FrameFailures failures_;
  bool is_whole_ = true;
  std::size_t skipped_bytes_ = 0;
  std::string first_problem_;
  std::optional<std::uint64_t> stamp_; // of the last frame, microseconds
};

} // namespace pcl_ext::tools

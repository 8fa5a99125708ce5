// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Counts the frames of a stream by what became of them, finds those that were
 * lost, and tells when to ask the sender for an I-frame. */
class FrameSequence {
public:
  /** \brief Frames were refused before the next one, which then miss between two
   * decoded ones without being lost. */
  void
  refuse(std::size_t count)
  {
    unnumbered_ += count;
  }

  /** \brief Counts a decoded frame, and those lost before it. */
  void
  addDecoded(std::uint32_t frame_number, StreamHealth& health)
  {
    follow(frame_number, health);
    ++health.frames_decoded;
  }

  /** \brief Counts a late or repeated frame.
   * \return whether to request an I-frame
   */
  bool
  addDropped(StreamHealth& health)
  {
    ++health.frames_dropped;
    // A restarted sender has old numbers. If its first frame was lost, all others are
    // dropped until it sends an I-frame.
    const bool wants_i_frame = ++dropped_in_a_row_ % 3 == 0;
    health.i_frame_requests += wants_i_frame ? 1 : 0;
    return wants_i_frame;
  }

  /** \brief Counts a frame that failed.
   * \param[in] status why
   * \param[in] frame_number of a frame that failed after decoding, so that the stream
   * continues; none: it was not decoded
   * \return whether to request an I-frame
   */
  bool
  addFailed(io::CompressionStatus status,
            std::optional<std::uint32_t> frame_number,
            StreamHealth& health)
  {
    ++health.frames_failed;
    const io::CompressionCode code = status.code();
    health.last_failure = std::move(status);
    if (frame_number) {
      follow(*frame_number, health);
      return false;
    }
    const bool was_no_frame = code == io::CompressionCode::NoFrame ||
                              code == io::CompressionCode::EndOfStream;
    if (!was_no_frame) {
      ++unnumbered_;
      health.in_sync = false;
    }
    const bool wants_i_frame = wantsIFrame(code);
    health.i_frame_requests += wants_i_frame ? 1 : 0;
    return wants_i_frame;
  }

private:
  void
  follow(std::uint32_t frame_number, StreamHealth& health)
  {
    // A number that is not above the last one means that the sender was restarted.
    if (last_number_ && frame_number > *last_number_) {
      const std::size_t missing = frame_number - *last_number_ - 1;
      if (missing > unnumbered_)
        health.frames_lost += missing - unnumbered_;
    }
    last_number_ = frame_number;
    unnumbered_ = 0;
    failures_in_a_row_ = 0;
    dropped_in_a_row_ = 0;
    health.in_sync = true;
  }

  bool
  wantsIFrame(io::CompressionCode code)
  {
    switch (code) {
    case io::CompressionCode::MissingReference:
    case io::CompressionCode::Corrupt:
    case io::CompressionCode::Truncated:
    case io::CompressionCode::InputFailed:
    case io::CompressionCode::OutOfMemory:
      // Repeated, as a request may be lost; not every time, as the I-frame takes a while.
      return failures_in_a_row_++ % 3 == 0;
    default:
      return false;
    }
  }

  std::optional<std::uint32_t> last_number_; // of the last decoded frame
  std::size_t unnumbered_ = 0; // frames that failed or were refused since then
  // Since the last frame that was decoded:
  std::size_t failures_in_a_row_ = 0; // frames that need an I-frame to recover
  std::size_t dropped_in_a_row_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes

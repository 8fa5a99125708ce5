// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief The bytes of a frame, which viewers share. */
using FrameBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

/** \brief A frame on its way to a viewer. */
struct QueuedFrame {
  std::size_t stream = 0;
  std::uint32_t flags = 0;
  std::chrono::nanoseconds time{0};
  bool is_i_frame = false;
  FrameBytes bytes;
};

/** \brief What waits for one viewer, within limits. */
class ViewerQueue {
public:
  explicit ViewerQueue(const ViewServerLimits& limits) : limits_(limits) {}

  /** \brief Queues a frame, or skips it if the viewer lacks the one before or is too
   * slow; then it gets the stream from an I-frame on. */
  void
  offer(const QueuedFrame& frame);

  /** \brief Skips the stream's frames that wait, and all up to its next I-frame. */
  void
  skip(std::size_t stream) noexcept;

  /** \brief Queues the frames of a stream from an I-frame on, however many these are.
   * What waited of the stream is dropped. */
  void
  begin(std::size_t stream, const std::deque<QueuedFrame>& frames);

  /** \brief Takes the next frame; false if none waits. */
  bool
  take(QueuedFrame& frame);

  /** \brief True if frames of a stream wait. */
  bool
  isWaiting(std::size_t stream) const
  {
    return stream < streams_.size() && streams_[stream].queued > 0;
  }

  /** \brief Streams of which frames were skipped, and that have not begun again. */
  std::vector<std::size_t>
  skippedStreams() const;

  /** \brief Bytes of the frames that wait, with their heads. */
  std::size_t
  bytes() const
  {
    return bytes_;
  }

  std::size_t
  frames() const
  {
    return frames_.size();
  }

  std::uint64_t
  skipped() const
  {
    return skipped_;
  }

  bool needs_streams = true; ///< the message that lists them is to be sent
  bool needs_state = true;   ///< likewise that on how fresh they are
  bool needs_end = false;    ///< likewise, after the last frame

private:
  struct Stream {
    bool is_in_step = false;
    bool has_skipped = false; ///< since the last frame that was queued
    std::size_t queued = 0;   ///< frames that wait
    std::size_t first = 0;    ///< of these, from begin()
  };

  bool
  fits(const Stream& stream, const QueuedFrame& frame) const;

  /** \param[in] flags besides skipped_before */
  void
  push(Stream& stream, QueuedFrame frame, std::uint32_t flags);

  void
  drop(std::size_t stream) noexcept;

  const ViewServerLimits limits_;
  std::deque<QueuedFrame> frames_;
  std::vector<Stream> streams_;
  std::size_t bytes_ = 0;
  std::uint64_t skipped_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::view

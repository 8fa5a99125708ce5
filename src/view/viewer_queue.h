// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include "view/live_messages.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
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

inline std::size_t
bytesOf(const QueuedFrame& frame)
{
  return sizeof(FrameHead) + frame.bytes->size();
}

/** \brief What waits for one viewer, within limits. */
class ViewerQueue {
public:
  explicit ViewerQueue(const ViewServerLimits& limits) : limits_(limits) {}

  /** \brief Queues a frame, or skips it if the viewer lacks the one before or is too
   * slow; then it gets the stream from an I-frame on. */
  void
  offer(const QueuedFrame& frame)
  {
    if (frame.stream >= streams_.size())
      streams_.resize(frame.stream + 1);
    Stream& stream = streams_[frame.stream];
    if (stream.is_in_step && !fits(stream, frame))
      skip(frame.stream);
    const bool is_taken =
        stream.is_in_step || (frame.is_i_frame && fits(stream, frame));
    if (is_taken)
      push(stream, frame, 0);
    else
      skipped_ += stream.has_skipped ? 1 : 0;
  }

  /** \brief Skips the stream's frames that wait, and all up to its next I-frame. */
  void
  skip(std::size_t stream) noexcept
  {
    if (stream >= streams_.size())
      return; // it has not begun
    drop(stream);
    streams_[stream].has_skipped = true;
  }

  /** \brief Queues the frames of a stream from an I-frame on, however many these are.
   * What waited of the stream is dropped. */
  void
  begin(std::size_t stream, const std::deque<QueuedFrame>& frames)
  {
    if (stream >= streams_.size())
      streams_.resize(stream + 1);
    drop(stream);
    for (const QueuedFrame& frame : frames)
      push(streams_[stream], frame, published_before);
    streams_[stream].first = frames.size();
  }

  /** \brief Takes the next frame; false if none waits. */
  bool
  take(QueuedFrame& frame)
  {
    if (frames_.empty())
      return false;
    frame = std::move(frames_.front());
    frames_.pop_front();
    bytes_ -= bytesOf(frame);
    Stream& stream = streams_[frame.stream];
    if (--stream.queued == 0)
      stream.first = 0;
    return true;
  }

  /** \brief True if frames of a stream wait. */
  bool
  isWaiting(std::size_t stream) const
  {
    return stream < streams_.size() && streams_[stream].queued > 0;
  }

  /** \brief Streams of which frames were skipped, and that have not begun again. */
  std::vector<std::size_t>
  skippedStreams() const
  {
    std::vector<std::size_t> skipped;
    for (std::size_t i = 0; i < streams_.size(); ++i)
      if (streams_[i].has_skipped && !streams_[i].is_in_step)
        skipped.push_back(i);
    return skipped;
  }

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
  fits(const Stream& stream, const QueuedFrame& frame) const
  {
    return stream.queued < limits_.max_queued_frames + stream.first &&
           (frames_.empty() || bytes_ + bytesOf(frame) <= limits_.max_queued_bytes);
  }

  /** \param[in] flags besides skipped_before */
  void
  push(Stream& stream, QueuedFrame frame, std::uint32_t flags)
  {
    frame.flags = flags | (stream.has_skipped ? skipped_before : 0);
    bytes_ += bytesOf(frame);
    ++stream.queued;
    stream.has_skipped = false;
    stream.is_in_step = true;
    frames_.push_back(std::move(frame));
  }

  /** \brief Drops what waits of a stream, up to its next I-frame. */
  void
  drop(std::size_t stream) noexcept
  {
    const auto end =
        std::remove_if(frames_.begin(), frames_.end(), [&](const QueuedFrame& frame) {
          if (frame.stream == stream)
            bytes_ -= bytesOf(frame);
          return frame.stream == stream;
        });
    frames_.erase(end, frames_.end());
    Stream& dropped = streams_[stream];
    skipped_ += dropped.queued;
    dropped.has_skipped |= dropped.queued > 0;
    dropped.queued = dropped.first = 0;
    dropped.is_in_step = false;
  }

  const ViewServerLimits limits_;
  std::deque<QueuedFrame> frames_;
  std::vector<Stream> streams_;
  std::size_t bytes_ = 0;
  std::uint64_t skipped_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::view

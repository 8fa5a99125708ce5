// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/viewer_queue.h"

#include "view/live_messages.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace {

std::size_t
bytesOf(const QueuedFrame& frame)
{
  return sizeof(FrameHead) + frame.bytes->size();
}

} // namespace

bool
ViewerQueue::fits(const Stream& stream, const QueuedFrame& frame) const
{
  return stream.queued < limits_.max_queued_frames + stream.first &&
         (frames_.empty() || bytes_ + bytesOf(frame) <= limits_.max_queued_bytes);
}

void
ViewerQueue::push(Stream& stream, QueuedFrame frame, std::uint32_t flags)
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
ViewerQueue::drop(std::size_t stream) noexcept
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

void
ViewerQueue::offer(const QueuedFrame& frame)
{
  if (frame.stream >= streams_.size())
    streams_.resize(frame.stream + 1);
  Stream& stream = streams_[frame.stream];
  if (stream.is_in_step && !fits(stream, frame))
    skip(frame.stream);
  const bool is_taken = stream.is_in_step || (frame.is_i_frame && fits(stream, frame));
  if (is_taken)
    push(stream, frame, 0);
  else
    skipped_ += stream.has_skipped ? 1 : 0;
}

void
ViewerQueue::skip(std::size_t stream) noexcept
{
  if (stream >= streams_.size())
    return; // it has not begun
  drop(stream);
  streams_[stream].has_skipped = true;
}

void
ViewerQueue::begin(std::size_t stream, const std::deque<QueuedFrame>& frames)
{
  if (stream >= streams_.size())
    streams_.resize(stream + 1);
  drop(stream);
  for (const QueuedFrame& frame : frames)
    push(streams_[stream], frame, published_before);
  streams_[stream].first = frames.size();
}

bool
ViewerQueue::take(QueuedFrame& frame)
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

std::vector<std::size_t>
ViewerQueue::skippedStreams() const
{
  std::vector<std::size_t> skipped;
  for (std::size_t i = 0; i < streams_.size(); ++i)
    if (streams_[i].has_skipped && !streams_[i].is_in_step)
      skipped.push_back(i);
  return skipped;
}

} // namespace pcl_ext::PCL_EXT_ABI::view

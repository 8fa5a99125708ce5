// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/live_streams.h"

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>

#include <algorithm>
#include <new>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace {

constexpr int most_doublings = 16; // of the interval of requests, as a factor

/** \brief Intervals between two requests for viewers that have lost step: one that is
 * too slow for the stream, and says so again and again, must not make it larger for
 * all. */
constexpr int intervals_between_answers = 10;

/** \brief A status that says why bytes are not one frame. */
ViewServerStatus
checkFrame(const std::vector<std::uint8_t>& bytes,
           const io::FrameDescription& description)
{
  if (!description.status.ok())
    return {ViewServerCode::InvalidArgument, description.status.message()};
  // The published layout tells its size only to a decoder.
  if (description.format != io::StreamFormat::Version1)
    return {};
  const io::FrameSize size =
      io::frameSize(bytes.data(), bytes.size(), io::DecoderLimits::none());
  if (size.status.ok() && size.known != bytes.size())
    return {ViewServerCode::InvalidArgument,
            "the frame has " + std::to_string(size.known) + " bytes, not " +
                std::to_string(bytes.size())};
  return {};
}

} // namespace

void
LiveStreams::Stream::forget()
{
  kept.clear();
  kept_bytes = 0;
  is_kept = false;
}

LiveStreams::LiveStreams(const ViewServerLimits& limits, bool can_request)
: limits_(limits)
, can_request_(can_request)
, end_message_(std::make_shared<const std::string>(endMessage()))
{
  updateMessage();
}

void
LiveStreams::updateMessage()
{
  streams_message_ = std::make_shared<const std::string>(streamsMessage(descriptions_));
  for (const auto& viewer : viewers_)
    viewer->needs_streams = true;
}

std::size_t
LiveStreams::addStream(const LiveStream& stream)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  streams_.reserve(streams_.size() + 1);
  descriptions_.push_back(stream);
  streams_.emplace_back();
  updateMessage();
  return streams_.size() - 1;
}

bool
LiveStreams::setMetadata(std::size_t stream,
                         const std::map<std::string, std::string>& metadata)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stream >= streams_.size())
    return false;
  descriptions_[stream].metadata = metadata;
  updateMessage();
  return true;
}

void
LiveStreams::keep(Stream& stream, const QueuedFrame& frame, std::uint32_t number)
{
  const bool follows = number == stream.last_number + 1;
  stream.last_number = number;
  if (frame.is_i_frame) {
    stream.forget();
    stream.is_kept = true;
    stream.wants_i_frame = stream.is_asked = false;
    stream.request_interval = std::chrono::milliseconds(0);
  }
  else if (!follows) {
    // A frame was lost on its way to here: nobody can decode what follows.
    stream.forget();
    stream.wants_i_frame = !viewers_.empty();
  }
  if (!stream.is_kept)
    return;
  if (stream.kept.size() >= limits_.max_kept_frames ||
      stream.kept_bytes + frame.bytes->size() > limits_.max_kept_bytes) {
    stream.forget();
    return;
  }
  try {
    stream.kept.push_back(frame);
    stream.kept_bytes += frame.bytes->size();
  }
  catch (const std::bad_alloc&) {
    stream.forget();
  }
}

ViewServerStatus
LiveStreams::publish(std::size_t stream,
                     std::chrono::nanoseconds time,
                     std::vector<std::uint8_t>&& frame)
{
  const io::FrameDescription description =
      io::describeFrame(frame.data(), frame.size(), io::DecoderLimits::none());
  if (ViewServerStatus status = checkFrame(frame, description); !status.ok())
    return status;
  QueuedFrame queued;
  queued.stream = stream;
  queued.time = time;
  queued.is_i_frame = description.is_i_frame;
  queued.bytes = std::make_shared<const std::vector<std::uint8_t>>(std::move(frame));

  const std::lock_guard<std::mutex> lock(mutex_);
  if (stream >= streams_.size())
    return {ViewServerCode::InvalidArgument,
            "there is no stream " + std::to_string(stream)};
  if (has_ended_)
    return {ViewServerCode::InvalidArgument, "a frame after the end"};
  ++statistics_.frames;
  streams_[stream].last_frame = Clock::now();
  keep(streams_[stream], queued, description.frame_number);
  for (const auto& viewer : viewers_) {
    try {
      viewer->offer(queued);
    }
    catch (const std::bad_alloc&) {
      viewer->skip(stream);
    }
    statistics_.largest_queue_bytes =
        std::max(statistics_.largest_queue_bytes, viewer->bytes());
    statistics_.largest_queue_frames =
        std::max(statistics_.largest_queue_frames, viewer->frames());
  }
  return {};
}

void
LiveStreams::setProblem(const std::string& problem)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    problem_ = problem;
  }
  queueState();
}

void
LiveStreams::queueState()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& viewer : viewers_)
    viewer->needs_state = true;
}

std::string
LiveStreams::describeState(Clock::time_point now) const
{
  std::vector<std::optional<std::chrono::milliseconds>> ages;
  for (const Stream& stream : streams_) {
    auto& age = ages.emplace_back();
    if (stream.last_frame)
      age = std::chrono::duration_cast<std::chrono::milliseconds>(now -
                                                                  *stream.last_frame);
  }
  return stateMessage(problem_, ages);
}

void
LiveStreams::end()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  has_ended_ = true;
  for (const auto& viewer : viewers_)
    viewer->needs_end = true;
}

std::shared_ptr<ViewerQueue>
LiveStreams::addViewer()
{
  auto viewer = std::make_shared<ViewerQueue>(limits_);
  const std::lock_guard<std::mutex> lock(mutex_);
  viewer->needs_end = has_ended_;
  for (std::size_t i = 0; i < streams_.size(); ++i)
    if (streams_[i].is_kept)
      viewer->begin(i, streams_[i].kept);
    else
      streams_[i].wants_i_frame = true;
  viewers_.push_back(viewer);
  statistics_.largest_queue_bytes =
      std::max(statistics_.largest_queue_bytes, viewer->bytes());
  statistics_.largest_queue_frames =
      std::max(statistics_.largest_queue_frames, viewer->frames());
  return viewer;
}

void
LiveStreams::removeViewer(const std::shared_ptr<ViewerQueue>& viewer)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = std::find(viewers_.begin(), viewers_.end(), viewer);
  if (found == viewers_.end())
    return;
  statistics_.frames_skipped += viewer->skipped();
  viewers_.erase(found);
  if (viewers_.empty())
    for (Stream& stream : streams_)
      stream.wants_i_frame = stream.is_asked = false;
}

void
LiveStreams::restart(ViewerQueue& viewer, std::size_t stream)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stream >= streams_.size())
    return;
  if (can_request_)
    streams_[stream].is_asked = true;
  else if (streams_[stream].is_kept && !viewer.isWaiting(stream))
    viewer.begin(stream, streams_[stream].kept);
}

bool
LiveStreams::next(ViewerQueue& viewer, OutgoingMessage& message)
{
  message = OutgoingMessage();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (std::exchange(viewer.needs_streams, false)) {
    message.text = streams_message_;
    return true;
  }
  if (viewer.needs_state) {
    message.text = std::make_shared<const std::string>(describeState(Clock::now()));
    viewer.needs_state = false;
    return true;
  }
  QueuedFrame frame;
  if (viewer.take(frame)) {
    message.head = frameHead(frame.stream, frame.flags, frame.time);
    message.frame = frame.bytes;
    ++statistics_.frames_sent;
    return true;
  }
  // It has room again, and need not wait for an I-frame that is far away.
  for (const std::size_t stream : viewer.skippedStreams())
    streams_[stream].wants_i_frame = true;
  if (std::exchange(viewer.needs_end, false)) {
    message.text = end_message_;
    return true;
  }
  return false;
}

bool
LiveStreams::wantsIFrames() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return can_request_ &&
         std::any_of(streams_.begin(), streams_.end(), [](const Stream& stream) {
           return stream.needsIFrame();
         });
}

std::vector<std::size_t>
LiveStreams::dueIFrameRequests(Clock::time_point now)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::size_t> due;
  for (std::size_t i = 0; can_request_ && i < streams_.size(); ++i) {
    Stream& stream = streams_[i];
    const bool is_due = (stream.wants_i_frame && now >= stream.next_request) ||
                        (stream.is_asked && now >= stream.next_answer);
    if (!is_due)
      continue;
    due.push_back(i);
    stream.request_interval =
        std::clamp(2 * stream.request_interval,
                   limits_.i_frame_request_interval,
                   most_doublings * limits_.i_frame_request_interval);
    stream.next_request = now + stream.request_interval;
    stream.next_answer =
        now + std::max(stream.request_interval,
                       intervals_between_answers * limits_.i_frame_request_interval);
    ++statistics_.i_frame_requests;
  }
  return due;
}

void
LiveStreams::addTo(ViewServerStatistics& statistics) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  const ViewServerStatistics others = statistics;
  statistics = statistics_;
  statistics.connections = others.connections;
  statistics.refused = others.refused;
  statistics.viewers = viewers_.size();
  for (const auto& viewer : viewers_) {
    statistics.queued_bytes += viewer->bytes();
    statistics.frames_skipped += viewer->skipped();
  }
  for (const Stream& stream : streams_)
    statistics.kept_bytes += stream.kept_bytes;
}

} // namespace pcl_ext::PCL_EXT_ABI::view

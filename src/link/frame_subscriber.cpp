// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/link/frame_subscriber.h>

#include "link/connection.h"
#include "link/followed_stream.h"
#include "link/frame_headers.h"
#include "link/replay.h"
#include "link/subjects.h"
#include "link/whole_frame.h"

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

LinkStatus
checkSubscriber(const SubscriberSettings& settings)
{
  if (settings.max_waiting_bytes == 0)
    return {LinkCode::InvalidSettings, "max_waiting_bytes is 0; it must be at least 1"};
  if (settings.max_streams == 0)
    return {LinkCode::InvalidSettings, "max_streams is 0; it must be at least 1"};
  if (settings.i_frame_request_interval < std::chrono::milliseconds(1))
    return {LinkCode::InvalidSettings,
            "i_frame_request_interval is " +
                std::to_string(settings.i_frame_request_interval.count()) +
                " ms; it must be at least 1 ms"};
  if (settings.replay_from && *settings.replay_from < Time(0))
    return {LinkCode::InvalidSettings,
            "replay_from is negative; it must be at least 0"};
  for (const std::string& stream : settings.streams)
    if (stream.empty() || stream.size() > longest_stream_name)
      return {LinkCode::InvalidSettings,
              "streams has a name of " + std::to_string(stream.size()) +
                  " bytes; it must have 1 to " + std::to_string(longest_stream_name)};
  return {};
}

StreamMetadata
metadataOf(natsMsg* message)
{
  StreamMetadata metadata;
  const char** values = nullptr;
  int count = 0;
  if (natsMsgHeader_Values(message, metadata_header, &values, &count) != NATS_OK)
    return metadata;
  for (int i = 0; i < count; ++i)
    if (auto pair = parseMetadata(values[i]))
      metadata.insert(std::move(*pair));
  std::free(values);
  return metadata;
}

} // namespace

class FrameSubscriber::Implementation {
public:
  explicit Implementation(const SubscriberSettings& settings)
  : settings_(settings)
  , connection_(settings.link,
                nullptr,
                settings.replay_from ? Connection::Patience::Long
                                     : Connection::Patience::Short)
  {
    if (settings.replay_from)
      replay_.emplace();
  }

  LinkStatus
  connect()
  {
    if (LinkStatus status = checkSubscriber(settings_); !status.ok())
      return status;
    if (LinkStatus status = connection_.open(); !status.ok())
      return status;
    if (replay_)
      return replay_->open(connection_, *settings_.replay_from);
    std::vector<std::string> all;
    if (settings_.streams.empty())
      all.push_back(settings_.link.site + ".*.frames");
    for (const std::string& stream : settings_.streams)
      all.push_back(framesSubject(settings_.link.site, stream));
    for (const std::string& subject : all) {
      if (settings_.partition) {
        const std::string part = subject + "." + std::to_string(*settings_.partition);
        if (LinkStatus status = subscribe(part); !status.ok())
          return status;
        continue;
      }
      // A server that divides streams appends the part.
      for (const std::string& either : {subject, subject + ".*"})
        if (LinkStatus status = subscribe(either); !status.ok())
          return status;
    }
    // The server knows the subscriptions when it has answered.
    const natsStatus status = natsConnection_FlushTimeout(
        connection_.get(), settings_.link.connect_timeout.count());
    return status == NATS_OK ? LinkStatus() : connection_.statusOf(status);
  }

  LinkStatus
  next(LinkFrame& frame, std::chrono::milliseconds timeout)
  {
    if (connection_.get() == nullptr)
      return {LinkCode::NotConnected, "frames arrive after connect()"};
    const auto end = std::chrono::steady_clock::now() + timeout;
    bool is_asked = false; // the server, for what it keeps
    std::unique_lock<std::mutex> lock(mutex_);
    while (!takeWaiting(frame)) {
      if (connection_.isClosed())
        return connection_.statusOf(NATS_CONNECTION_CLOSED);
      if (is_stopped_)
        return {LinkCode::NoFrame, "no frame comes after stop()"};
      const auto now = std::chrono::steady_clock::now();
      if (replay_ && (now < end || !is_asked)) {
        is_asked = true;
        lock.unlock();
        MessageHandle message;
        const LinkStatus status = replay_->next(end - now, message);
        if (status.ok())
          receive(message.get());
        else if (status.code() != LinkCode::NoFrame)
          return status;
        lock.lock();
        continue;
      }
      if (now >= end)
        return {LinkCode::NoFrame, "no frame came in time"};
      // Not longer, as a connection that is closed for good does not wake it.
      constexpr std::chrono::milliseconds longest_wait{100};
      arrived_.wait_until(lock, std::min(end, now + longest_wait));
    }
    return {};
  }

  void
  requestIFrame(const std::string& stream)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = streams_.find(stream);
    if (found != streams_.end())
      requestIFrame(stream, found->second);
  }

  void
  stop()
  {
    subscriptions_.clear(); // which waits for their handlers
    is_stopped_ = true;
  }

  SubscriberStatistics
  statistics() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    SubscriberStatistics statistics = statistics_;
    const auto now = FollowedStream::Clock::now();
    for (const auto& [name, stream] : streams_) {
      statistics.streams.push_back(stream.statistics);
      if (stream.last_arrival)
        statistics.streams.back().age = now - *stream.last_arrival;
    }
    statistics.is_connected = connection_.isConnected();
    statistics.reconnections = connection_.reconnections();
    statistics.violations = connection_.violations();
    statistics.is_refused = subscription_count_ > 0 &&
                            connection_.refusedSubscriptions() >= subscription_count_;
    statistics.replay_pending = replay_ ? replay_->pending() : 0;
    return statistics;
  }

  bool
  isConnected() const
  {
    return connection_.isConnected();
  }

private:
  LinkStatus
  subscribe(const std::string& subject)
  {
    ++subscription_count_;
    const natsStatus status = subscriptions_.emplace_back().open(
        connection_, subject, [this](natsMsg* message) {
          guarded([&] {
            receive(message);
            return LinkStatus();
          });
        });
    return status == NATS_OK ? LinkStatus() : connection_.statusOf(status);
  }

  /** \brief Takes a message that arrived. */
  void
  receive(natsMsg* message)
  {
    const auto subject =
        parseFramesSubject(settings_.link.site, natsMsg_GetSubject(message));
    const auto* const bytes =
        reinterpret_cast<const std::uint8_t*>(natsMsg_GetData(message));
    const auto size = static_cast<std::size_t>(natsMsg_GetDataLength(message));
    const char* text = nullptr;
    natsMsgHeader_Get(message, frame_header, &text);
    const auto header = text != nullptr ? parseFrameHeader(text) : std::nullopt;
    const auto frame = header ? wholeFrameOf(bytes, size) : std::nullopt;

    const std::lock_guard<std::mutex> lock(mutex_);
    if (!subject) {
      ++statistics_.messages_of_no_stream;
      return;
    }
    if (!isWanted(*subject))
      return;
    FollowedStream* const stream = streamOf(subject->stream);
    if (stream == nullptr)
      ++statistics_.messages_of_too_many;
    else if (!frame)
      ++stream->statistics.messages_invalid;
    else if (stream->accept(*header, *frame))
      append(*stream, subject->stream, *header, frame->description.is_i_frame, message);
    else if (stream->needsIFrame())
      requestIFrame(subject->stream, *stream);
  }

  bool
  isWanted(const FramesSubject& subject) const
  {
    // Only a replay has others.
    if (settings_.partition && subject.partition != settings_.partition)
      return false;
    return settings_.streams.empty() ||
           std::find(settings_.streams.begin(),
                     settings_.streams.end(),
                     subject.stream) != settings_.streams.end();
  }

  /** \brief The state of a stream; null: there are too many. */
  FollowedStream*
  streamOf(const std::string& name)
  {
    const auto found = streams_.find(name);
    if (found != streams_.end())
      return &found->second;
    if (streams_.size() >= settings_.max_streams)
      return nullptr;
    FollowedStream& stream = streams_[name];
    stream.statistics.name = name;
    return &stream;
  }

  /** \brief Appends an accepted frame to those that wait, or drops it. */
  void
  append(FollowedStream& stream,
         const std::string& name,
         const FrameHeader& header,
         bool is_i_frame,
         natsMsg* message)
  {
    const auto size = static_cast<std::size_t>(natsMsg_GetDataLength(message));
    // One frame is taken in any case. A replay comes only as it is taken.
    if (waiting_bytes_ > 0 && waiting_bytes_ + size > settings_.max_waiting_bytes) {
      stream.drop();
      return;
    }
    const auto* const bytes =
        reinterpret_cast<const std::uint8_t*>(natsMsg_GetData(message));
    LinkFrame frame;
    frame.stream = name;
    frame.time = header.time;
    if (replay_)
      frame.kept = replay_->lastTime();
    frame.bytes.assign(bytes, bytes + size);
    frame.is_i_frame = is_i_frame;
    if (is_i_frame)
      frame.metadata = metadataOf(message);
    waiting_.push_back(std::move(frame));
    waiting_bytes_ += size;
    ++stream.statistics.frames;
    stream.statistics.bytes += size;
    stream.last_arrival = FollowedStream::Clock::now();
    arrived_.notify_one();
  }

  /** \brief Requests an I-frame unless that was done a moment ago. */
  void
  requestIFrame(const std::string& name, FollowedStream& stream)
  {
    if (settings_.replay_from || !connection_.isConnected() ||
        !stream.shouldRequest(FollowedStream::Clock::now(),
                              settings_.i_frame_request_interval))
      return;
    const std::string subject = requestsSubject(settings_.link.site, name);
    natsConnection_Publish(connection_.get(), subject.c_str(), nullptr, 0);
  }

  bool
  takeWaiting(LinkFrame& frame)
  {
    if (waiting_.empty())
      return false;
    frame = std::move(waiting_.front());
    waiting_.pop_front();
    waiting_bytes_ -= frame.bytes.size();
    return true;
  }

  const SubscriberSettings settings_;
  Connection connection_;
  std::optional<Replay> replay_; // in place of subscriptions
  std::atomic<bool> is_stopped_{false};
  std::atomic<std::size_t> subscription_count_{0};

  mutable std::mutex mutex_; // guards what follows
  std::condition_variable arrived_;
  std::map<std::string, FollowedStream> streams_;
  std::deque<LinkFrame> waiting_;
  std::size_t waiting_bytes_ = 0;
  SubscriberStatistics statistics_;

  // Last, so that their handlers end before the members that these use.
  std::deque<Subscription> subscriptions_;
};

FrameSubscriber::FrameSubscriber(const SubscriberSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

FrameSubscriber::~FrameSubscriber() = default;

LinkStatus
FrameSubscriber::connect() noexcept
{
  return guarded([this] { return implementation_->connect(); });
}

LinkStatus
FrameSubscriber::next(LinkFrame& frame, std::chrono::milliseconds timeout) noexcept
{
  return guarded([&] { return implementation_->next(frame, timeout); });
}

void
FrameSubscriber::requestIFrame(const std::string& stream) noexcept
{
  guarded([&] {
    implementation_->requestIFrame(stream);
    return LinkStatus();
  });
}

void
FrameSubscriber::stop() noexcept
{
  implementation_->stop();
}

SubscriberStatistics
FrameSubscriber::statistics() const
{
  return implementation_->statistics();
}

bool
FrameSubscriber::isConnected() const noexcept
{
  return implementation_->isConnected();
}

} // namespace pcl_ext::PCL_EXT_ABI::link

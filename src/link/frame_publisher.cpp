// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/link/frame_publisher.h>

#include "link/connection.h"
#include "link/frame_headers.h"
#include "link/sent_frames.h"
#include "link/subjects.h"
#include "link/whole_frame.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::link {

class FramePublisher::Implementation {
public:
  Implementation(const LinkSettings& settings, RequestIFrame request_i_frame)
  : request_i_frame_(std::move(request_i_frame))
  , publisher_(randomNumber())
  , connection_(settings, [this] { requestAll(); })
  , sent_(connection_, [this] { requestAll(); })
  {}

  ~Implementation()
  {
    if (sent_.isAnswering())
      flush(connection_.settings().connect_timeout);
  }
  Implementation(const Implementation&) = delete;
  Implementation&
  operator=(const Implementation&) = delete;

  LinkStatus
  connect()
  {
    const std::lock_guard<std::mutex> lock(connect_mutex_);
    if (connection_.get() == nullptr || sent_.isOpen())
      if (LinkStatus status = connection_.open(); !status.ok())
        return status;
    return sent_.open(publisher_);
  }

  LinkStatus
  addStream(const std::string& name,
            const StreamMetadata& metadata,
            std::size_t& stream)
  {
    if (name.empty() || name.size() > longest_stream_name)
      return {LinkCode::InvalidArgument,
              "the name of a stream has " + std::to_string(name.size()) +
                  " bytes; it must have 1 to " + std::to_string(longest_stream_name)};
    if (!sent_.isOpen())
      return {LinkCode::NotConnected, "streams are added after connect()"};
    const std::lock_guard<std::mutex> lock(mutex_);
    if (std::any_of(streams_.begin(), streams_.end(), [&](const Stream& other) {
          return other.name == name;
        }))
      return {LinkCode::InvalidArgument, "the stream '" + name + "' exists already"};
    const std::string& site = connection_.settings().site;
    const std::size_t number = streams_.size();
    Stream& added = streams_.emplace_back();
    added.name = name;
    added.subject = framesSubject(site, name);
    for (const auto& [key, value] : metadata)
      added.metadata.push_back(writeMetadata(key, value));
    const natsStatus status = added.requests.open(
        connection_,
        requestsSubject(site, name),
        [this, number](natsMsg* /* message */) { request(number); });
    if (status != NATS_OK) {
      streams_.pop_back();
      return connection_.statusOf(status);
    }
    stream = number;
    stream_count_ = streams_.size();
    return {};
  }

  LinkStatus
  publish(std::size_t stream, Time time, const std::uint8_t* frame, std::size_t size)
  {
    const auto whole = wholeFrameOf(frame, size);
    if (!whole)
      return {LinkCode::InvalidArgument, "the bytes are not exactly one frame"};
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stream >= streams_.size())
      return {LinkCode::InvalidArgument,
              "there is no stream of number " + std::to_string(stream)};
    Stream& published = streams_[stream];
    // Also of a frame that cannot be sent, so that receivers see the gap.
    const FrameHeader header{publisher_, ++published.frames, time};
    LinkStatus status;
    if (!sent_.isAnswering())
      status = connection_.statusOf(NATS_CONNECTION_DISCONNECTED);
    else {
      MessageHandle message;
      const natsStatus made = makeMessage(
          published, header, whole->description.is_i_frame, frame, size, message);
      status =
          made == NATS_OK ? send(published, message, size) : connection_.statusOf(made);
    }
    if (!status.ok())
      sent_.addLost();
    return status;
  }

  bool
  flush(std::chrono::milliseconds timeout) noexcept
  {
    return sent_.flush(timeout);
  }

  PublisherStatistics
  statistics()
  {
    PublisherStatistics statistics;
    sent_.describe(statistics);
    countRefused(statistics);
    statistics.i_frame_requests = i_frame_requests_;
    statistics.reconnections = connection_.reconnections();
    statistics.violations = connection_.violations();
    return statistics;
  }

private:
  /** \brief Frames that the server has, but does not permit, are not sent. */
  void
  countRefused(PublisherStatistics& statistics) const
  {
    const std::uint64_t refused =
        std::min(statistics.frames, connection_.refusedMessages());
    if (refused == 0)
      return;
    const std::uint64_t mean_bytes = statistics.bytes / statistics.frames;
    statistics.frames -= refused;
    statistics.bytes = statistics.frames * mean_bytes; // which are refused is not known
    statistics.frames_not_sent += refused;
  }

  struct Stream {
    std::string name;
    std::string subject;
    std::vector<std::string> metadata; ///< as headers
    std::uint64_t frames = 0;          ///< published, sent or not
    Subscription requests;
  };

  /** \brief Makes a message; its bytes are copied. */
  natsStatus
  makeMessage(const Stream& stream,
              const FrameHeader& header,
              bool is_i_frame,
              const std::uint8_t* frame,
              std::size_t size,
              MessageHandle& message) const
  {
    natsMsg* created = nullptr;
    natsStatus status = natsMsg_Create(&created,
                                       stream.subject.c_str(),
                                       nullptr,
                                       reinterpret_cast<const char*>(frame),
                                       static_cast<int>(size));
    message.reset(created);
    if (status == NATS_OK)
      status =
          natsMsgHeader_Set(created, frame_header, writeFrameHeader(header).c_str());
    if (is_i_frame)
      for (const std::string& pair : stream.metadata)
        if (status == NATS_OK)
          status = natsMsgHeader_Add(created, metadata_header, pair.c_str());
    return status;
  }

  LinkStatus
  send(const Stream& stream, const MessageHandle& message, std::size_t size)
  {
    const std::uint64_t connection = connection_.number();
    const natsStatus status =
        natsConnection_PublishMsg(connection_.get(), message.get());
    if (status == NATS_OK) {
      sent_.add(size, connection);
      return {};
    }
    if (status != NATS_MAX_PAYLOAD)
      return connection_.statusOf(status);
    return {
        LinkCode::FrameTooLarge,
        "a frame of '" + stream.name + "' has " + std::to_string(size) +
            " bytes, and with its headers that is above max_payload, " +
            std::to_string(natsConnection_GetMaxPayload(connection_.get())) +
            " bytes, in the server's configuration: raise it, or take a larger voxel "
            "edge"};
  }

  void
  request(std::size_t stream)
  {
    ++i_frame_requests_;
    if (request_i_frame_)
      request_i_frame_(stream);
  }

  void
  requestAll()
  {
    if (!request_i_frame_)
      return;
    const std::size_t streams = stream_count_;
    for (std::size_t stream = 0; stream < streams; ++stream)
      request_i_frame_(stream);
  }

  const RequestIFrame request_i_frame_;
  const std::uint64_t publisher_;
  std::atomic<std::uint64_t> i_frame_requests_{0};
  std::atomic<std::size_t> stream_count_{0};
  // Before the streams, whose subscriptions end first.
  Connection connection_;
  SentFrames sent_;
  std::mutex connect_mutex_;
  std::mutex mutex_; // guards what follows, and the order of frames
  std::deque<Stream> streams_;
};

FramePublisher::FramePublisher(const LinkSettings& settings,
                               RequestIFrame request_i_frame)
: implementation_(
      std::make_unique<Implementation>(settings, std::move(request_i_frame)))
{}

FramePublisher::~FramePublisher() = default;

LinkStatus
FramePublisher::connect() noexcept
{
  return guarded([this] { return implementation_->connect(); });
}

LinkStatus
FramePublisher::addStream(const std::string& name,
                          const StreamMetadata& metadata,
                          std::size_t& stream) noexcept
{
  return guarded([&] { return implementation_->addStream(name, metadata, stream); });
}

LinkStatus
FramePublisher::publish(std::size_t stream,
                        Time time,
                        const std::uint8_t* frame,
                        std::size_t size) noexcept
{
  return guarded([&] { return implementation_->publish(stream, time, frame, size); });
}

bool
FramePublisher::flush(std::chrono::milliseconds timeout) noexcept
{
  return implementation_->flush(timeout);
}

PublisherStatistics
FramePublisher::statistics() const noexcept
{
  return implementation_->statistics();
}

} // namespace pcl_ext::PCL_EXT_ABI::link

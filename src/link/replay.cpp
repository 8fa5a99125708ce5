// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/replay.h"

#include <pcl_ext/link/frame_subscriber.h>

#include "link/subjects.h"

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

using StreamInfoHandle =
    std::unique_ptr<jsStreamInfo, NatsDeleter<jsStreamInfo, jsStreamInfo_Destroy>>;

LinkStatus
jetStreamFailure(const Connection& connection, natsStatus status, jsErrCode error)
{
  const std::string& site = connection.settings().site;
  if (error == JSNotEnabledErr || error == JSNotEnabledForAccountErr ||
      status == NATS_NO_RESPONDERS)
    return {LinkCode::CannotConnect,
            "the server keeps no frames: JetStream is off in its configuration"};
  if (error == JSStreamNotFoundErr || status == NATS_NOT_FOUND)
    return {LinkCode::CannotConnect,
            "the server keeps no frames of the site '" + site +
                "': pcl_ext keep makes it do so"};
  if (!connection.isConnected())
    return connection.statusOf(status);
  if (status == NATS_TIMEOUT)
    return {
        LinkCode::CannotConnect,
        "JetStream of the server does not answer: this user may need the permission to "
        "publish on $JS.API.>"};
  const char* const details = nats_GetLastError(nullptr);
  return {
      LinkCode::CannotConnect,
      "JetStream of the server fails for the site '" + site +
          "': " + natsStatus_GetText(status) +
          (details != nullptr && *details != '\0' ? std::string(", ") + details : "")};
}

/** \brief Makes what asks the server for kept frames, by an open connection. */
LinkStatus
makeJetStream(const Connection& connection, JetStreamHandle& stream)
{
  jsCtx* created = nullptr;
  const natsStatus status =
      natsConnection_JetStream(&created, connection.get(), nullptr);
  stream.reset(created);
  return status == NATS_OK ? LinkStatus()
                           : jetStreamFailure(connection, status, jsErrCode(0));
}

/** \brief Opens a connection, and makeJetStream(). */
LinkStatus
openJetStream(Connection& connection, JetStreamHandle& stream)
{
  if (LinkStatus status = connection.open(); !status.ok())
    return status;
  return makeJetStream(connection, stream);
}

} // namespace

LinkStatus
Replay::open(const Connection& connection, Time from)
{
  connection_ = &connection;
  if (LinkStatus status = makeJetStream(connection, stream_); !status.ok())
    return status;
  jsErrCode error = jsErrCode(0);
  jsStreamInfo* kept = nullptr;
  const natsStatus status = js_GetStreamInfo(
      &kept, stream_.get(), connection.settings().site.c_str(), nullptr, &error);
  if (status != NATS_OK)
    return jetStreamFailure(connection, status, error);
  last_ = kept->State.LastSeq;
  pending_ = last_; // at most
  jsStreamInfo_Destroy(kept);
  jsConsumerConfig config;
  jsConsumerConfig_Init(&config);
  config.DeliverPolicy = from > Time(0) ? js_DeliverByStartTime : js_DeliverAll;
  config.OptStartTime = from.count();
  return begin(config);
}

LinkStatus
Replay::begin(jsConsumerConfig config)
{
  const std::string& site = connection_->settings().site;
  // The server sends no more before some are acknowledged.
  constexpr std::int64_t most_bytes = 32 << 20;
  const std::int64_t largest =
      std::max<std::int64_t>(1, natsConnection_GetMaxPayload(connection_->get()));
  most_waiting_ =
      static_cast<std::uint64_t>(std::clamp<std::int64_t>(most_bytes / largest, 2, 64));
  config.AckPolicy = js_AckAll;
  config.MaxAckPending = static_cast<std::int64_t>(most_waiting_);
  config.AckWait = std::chrono::nanoseconds(std::chrono::hours(24)).count();
  config.MemoryStorage = true;
  jsSubOptions options;
  jsSubOptions_Init(&options);
  options.Stream = site.c_str();
  options.ManualAck = true;
  options.Config = config;
  jsErrCode error = jsErrCode(0);
  const std::string subject = site + ".>";
  natsStatus status = js_SubscribeSync(
      &subscription_, stream_.get(), subject.c_str(), nullptr, &options, &error);
  if (status == NATS_OK)
    status = natsSubscription_SetPendingLimits(subscription_, -1, -1);
  if (status != NATS_OK)
    return jetStreamFailure(*connection_, status, error);
  delivered_ = 0;
  last_arrival_ = Clock::now();
  updatePending();
  return {};
}

LinkStatus
Replay::beginAnew()
{
  end();
  // One that cannot be received is left out at last.
  constexpr unsigned int tries = 2;
  ++failures_;
  jsConsumerConfig config;
  jsConsumerConfig_Init(&config);
  config.DeliverPolicy = js_DeliverByStartSequence;
  config.OptStartSeq = number_ + 1 + (failures_ > tries ? failures_ - tries : 0);
  return begin(config);
}

void
Replay::end()
{
  if (subscription_ == nullptr)
    return;
  // Which deletes the consumer; the server does it later, too.
  if (connection_->isConnected())
    natsSubscription_Unsubscribe(subscription_);
  natsSubscription_Destroy(subscription_);
  subscription_ = nullptr;
}

bool
Replay::updatePending()
{
  jsConsumerInfo* consumer = nullptr;
  if (natsSubscription_GetConsumerInfo(&consumer, subscription_, nullptr, nullptr) !=
      NATS_OK)
    return false;
  const std::uint64_t sent = consumer->Delivered.Consumer;
  const std::uint64_t under_way = sent > delivered_ ? sent - delivered_ : 0;
  setPending(consumer->NumPending + under_way);
  jsConsumerInfo_Destroy(consumer);
  return under_way == 0;
}

void
Replay::setPending(std::uint64_t pending)
{
  pending_ = last_ > number_ ? std::min(pending, last_ - number_) : 0;
}

LinkStatus
Replay::receive(std::chrono::milliseconds timeout, MessageHandle& message)
{
  constexpr std::chrono::milliseconds patience{1000};
  const LinkStatus nothing{LinkCode::NoFrame, "no frame came in time"};
  if (!connection_->isConnected()) {
    constexpr std::chrono::milliseconds longest_wait{100}; // it may be there again
    nats_Sleep(std::min(timeout, longest_wait).count());
    return nothing;
  }
  if (subscription_ == nullptr)
    if (LinkStatus status = beginAnew(); !status.ok())
      return connection_->isConnected() ? status : nothing;
  natsMsg* received = nullptr;
  const natsStatus status = natsSubscription_NextMsg(
      &received, subscription_, std::min(timeout, patience).count());
  if (status == NATS_OK) {
    message.reset(received);
    last_arrival_ = Clock::now();
    return {};
  }
  if (status != NATS_TIMEOUT)
    end();
  else if (Clock::now() - last_arrival_ >= patience) {
    // What was sent, or was to be, or the consumer may be gone.
    last_arrival_ = Clock::now();
    if (!updatePending())
      end();
  }
  return nothing;
}

bool
Replay::follow(natsMsg* message)
{
  jsMsgMetaData* position = nullptr;
  if (natsMsg_GetMetaData(&position, message) != NATS_OK)
    return false;
  const jsSequencePair number = position->Sequence;
  const std::uint64_t pending = position->NumPending;
  const Time time(position->Timestamp);
  jsMsgMetaData_Destroy(position);
  if (number.Consumer != delivered_ + 1)
    return false;
  delivered_ = number.Consumer;
  number_ = number.Stream;
  time_ = time;
  failures_ = 0;
  setPending(pending);
  if (delivered_ % (most_waiting_ / 2) == 0)
    natsMsg_Ack(message, nullptr);
  return true;
}

LinkStatus
Replay::next(std::chrono::nanoseconds timeout, MessageHandle& message)
{
  if (pending_ == 0)
    return {LinkCode::EndOfReplay, "all frames that the server keeps were received"};
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(timeout);
  if (LinkStatus status =
          receive(std::max(milliseconds, std::chrono::milliseconds(1)), message);
      !status.ok())
    return status;
  if (follow(message.get()))
    return {};
  // Some were lost with a connection.
  message.reset();
  end();
  return {LinkCode::NoFrame, "no frame came in time"};
}

namespace {

LinkStatus
keep(const LinkSettings& link, const KeepSettings& settings, KeptFrames& kept)
{
  if (settings.max_age && *settings.max_age < std::chrono::seconds(0))
    return {LinkCode::InvalidSettings, "max_age is negative; it must be at least 0"};
  Connection connection(link, nullptr);
  JetStreamHandle stream;
  if (LinkStatus status = openJetStream(connection, stream); !status.ok())
    return status;
  jsErrCode error = jsErrCode(0);
  jsStreamInfo* found = nullptr;
  natsStatus status =
      js_GetStreamInfo(&found, stream.get(), link.site.c_str(), nullptr, &error);
  const StreamInfoHandle before(found);
  if (status != NATS_OK && status != NATS_NOT_FOUND && error != JSStreamNotFoundErr)
    return jetStreamFailure(connection, status, error);
  // With and without the part that a server appends which divides streams.
  const std::string whole = link.site + ".*.frames";
  const std::string divided = whole + ".*";
  std::array<const char*, 2> subjects{whole.c_str(), divided.c_str()};
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.MaxAge = std::chrono::nanoseconds(std::chrono::hours(24)).count();
  if (before != nullptr)
    config = *before->Config; // what nobody names stays
  config.Name = link.site.c_str();
  config.Subjects = subjects.data();
  config.SubjectsLen = static_cast<int>(subjects.size());
  if (settings.max_age)
    config.MaxAge = std::chrono::nanoseconds(*settings.max_age).count();
  // A server does not look for repeated messages among those that are deleted, and
  // refuses to. Where nothing is set it chooses the time itself.
  if (config.MaxAge > 0)
    config.Duplicates = std::min(config.Duplicates, config.MaxAge);
  if (settings.max_bytes)
    config.MaxBytes =
        *settings.max_bytes == 0 ? -1 : static_cast<std::int64_t>(*settings.max_bytes);
  found = nullptr;
  error = jsErrCode(0); // not that of the question before
  const auto set = before == nullptr ? js_AddStream : js_UpdateStream;
  status = set(&found, stream.get(), &config, nullptr, &error);
  const StreamInfoHandle after(found);
  if (status != NATS_OK)
    return jetStreamFailure(connection, status, error);
  kept.messages = after->State.Msgs;
  kept.bytes = after->State.Bytes;
  kept.first_time = Time(after->State.FirstTime);
  kept.messages_deleted = before != nullptr && before->State.Msgs > kept.messages
                              ? before->State.Msgs - kept.messages
                              : 0;
  kept.max_age = std::chrono::nanoseconds(after->Config->MaxAge);
  kept.max_bytes =
      static_cast<std::uint64_t>(std::max<std::int64_t>(0, after->Config->MaxBytes));
  return {};
}

LinkStatus
findKept(const LinkSettings& link, std::vector<SiteStream>& streams)
{
  streams.clear();
  Connection connection(link, nullptr);
  JetStreamHandle stream;
  if (LinkStatus status = openJetStream(connection, stream); !status.ok())
    return status;
  jsOptions options;
  jsOptions_Init(&options);
  options.Stream.Info.SubjectsFilter = ">";
  jsErrCode error = jsErrCode(0);
  jsStreamInfo* found = nullptr;
  const natsStatus status =
      js_GetStreamInfo(&found, stream.get(), link.site.c_str(), &options, &error);
  if (status != NATS_OK)
    return jetStreamFailure(connection, status, error);
  const StreamInfoHandle owner(found);
  std::set<SiteStream> all;
  const jsStreamStateSubjects* const subjects = found->State.Subjects;
  for (int i = 0; subjects != nullptr && i < subjects->Count; ++i)
    if (auto one = siteStreamOf(subjects->List[i].Subject))
      all.insert(std::move(*one));
  streams.assign(all.begin(), all.end());
  return {};
}

} // namespace

LinkStatus
keptStreams(const LinkSettings& link, std::vector<SiteStream>& streams) noexcept
{
  return guarded([&] { return findKept(link, streams); });
}

LinkStatus
keepFrames(const LinkSettings& link,
           const KeepSettings& settings,
           KeptFrames& kept) noexcept
{
  return guarded([&] { return keep(link, settings, kept); });
}

} // namespace pcl_ext::PCL_EXT_ABI::link

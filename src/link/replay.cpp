#include "link/replay.h"

#include <pcl_ext/link/frame_subscriber.h>

#include "link/guarded.h"
#include "link/site_streams.h"

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <string>
#include <utility>

namespace pcl_ext {
namespace link {

namespace {

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
                "': keepFrames() or pcl_ext keep makes it do so"};
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

natsStatus
openJetStream(const Connection& connection, JetStreamHandle& stream)
{
  jsCtx* created = nullptr;
  const natsStatus status =
      natsConnection_JetStream(&created, connection.get(), nullptr);
  stream.reset(created);
  return status;
}

} // namespace

LinkStatus
Replay::open(const Connection& connection, Time from)
{
  connection_ = &connection;
  if (const natsStatus status = openJetStream(connection, stream_); status != NATS_OK)
    return jetStreamFailure(connection, status, jsErrCode(0));
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
  // While it is not asked for messages; one that is gone is made anew.
  constexpr std::chrono::nanoseconds longest_silence = std::chrono::minutes(5);
  const std::string& site = connection_->settings().site;
  config.AckPolicy = js_AckNone;
  config.MemoryStorage = true;
  config.InactiveThreshold = longest_silence.count();
  jsSubOptions options;
  jsSubOptions_Init(&options);
  options.Stream = site.c_str();
  options.Config = config;
  jsErrCode error = jsErrCode(0);
  const std::string subject = site + ".>";
  natsStatus status = js_PullSubscribe(&subscription_,
                                       stream_.get(),
                                       subject.c_str(),
                                       nullptr,
                                       nullptr,
                                       &options,
                                       &error);
  // What is asked for at once is bounded.
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
  batch_.clear();
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
  pending_ = last_ > number_
                 ? std::min<std::uint64_t>(consumer->NumPending, last_ - number_)
                 : 0;
  jsConsumerInfo_Destroy(consumer);
  return true;
}

LinkStatus
Replay::fetch(std::chrono::milliseconds timeout)
{
  constexpr int most_messages = 64;
  constexpr std::int64_t most_bytes = 4 << 20;
  constexpr std::chrono::seconds patience{1};
  const LinkStatus nothing{LinkCode::NoFrame, "no frame came in time"};
  if (!connection_->isConnected()) {
    constexpr std::chrono::milliseconds longest_wait{100}; // it may be there again
    nats_Sleep(std::min(timeout, longest_wait).count());
    return nothing;
  }
  if (subscription_ == nullptr)
    if (LinkStatus status = beginAnew(); !status.ok())
      return connection_->isConnected() ? status : nothing;
  jsFetchRequest request;
  jsFetchRequest_Init(&request);
  request.Batch = is_next_alone_ ? 1 : most_messages;
  request.MaxBytes = is_next_alone_ ? 0 : most_bytes;
  request.Expires = std::min<std::chrono::nanoseconds>(timeout, patience).count();
  request.NoWait = true; // less than these, if there are not as many
  natsMsgList list{};
  const natsStatus status =
      natsSubscription_FetchRequest(&list, subscription_, &request);
  for (int i = 0; i < list.Count; ++i)
    batch_.emplace_back(std::exchange(list.Msgs[i], nullptr));
  natsMsgList_Destroy(&list);
  if (status == NATS_OK) {
    is_next_alone_ = false;
    last_arrival_ = Clock::now();
    return {};
  }
  if (status == NATS_ERR && !is_next_alone_)
    is_next_alone_ = true;
  else if (status != NATS_TIMEOUT && status != NATS_NOT_FOUND)
    end();
  else if (Clock::now() - last_arrival_ >= patience) {
    // What was to come, or the consumer, may be gone.
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
  jsMsgMetaData_Destroy(position);
  if (number.Consumer != delivered_ + 1)
    return false;
  delivered_ = number.Consumer;
  number_ = number.Stream;
  failures_ = 0;
  pending_ = last_ > number_ ? std::min(pending, last_ - number_) : 0;
  return true;
}

LinkStatus
Replay::next(std::chrono::nanoseconds timeout, MessageHandle& message)
{
  if (pending_ == 0)
    return {LinkCode::EndOfReplay, "all frames that the server keeps were received"};
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(timeout);
  if (batch_.empty())
    if (LinkStatus status = fetch(std::max(milliseconds, std::chrono::milliseconds(1)));
        !status.ok())
      return status;
  message = std::move(batch_.front());
  batch_.pop_front();
  if (follow(message.get()))
    return {};
  // Some were lost with a connection.
  end();
  return {LinkCode::NoFrame, "no frame came in time"};
}

namespace {

LinkStatus
keep(const LinkSettings& link, const KeepSettings& settings, KeptFrames& kept)
{
  if (settings.max_age < std::chrono::seconds(0))
    return {LinkCode::InvalidSettings, "max_age is negative; it must be at least 0"};
  Connection connection(link, nullptr);
  if (LinkStatus status = connection.open(); !status.ok())
    return status;
  JetStreamHandle stream;
  if (const natsStatus status = openJetStream(connection, stream); status != NATS_OK)
    return jetStreamFailure(connection, status, jsErrCode(0));
  // With and without the part that a server appends which divides streams.
  const std::string whole = link.site + ".*.frames";
  const std::string divided = whole + ".*";
  std::array<const char*, 2> subjects{whole.c_str(), divided.c_str()};
  jsStreamConfig config;
  jsStreamConfig_Init(&config);
  config.Name = link.site.c_str();
  config.Subjects = subjects.data();
  config.SubjectsLen = static_cast<int>(subjects.size());
  config.MaxAge =
      std::chrono::duration_cast<std::chrono::nanoseconds>(settings.max_age).count();
  config.MaxBytes =
      settings.max_bytes == 0 ? -1 : static_cast<std::int64_t>(settings.max_bytes);
  jsErrCode error = jsErrCode(0);
  jsStreamInfo* found = nullptr;
  natsStatus status = js_AddStream(&found, stream.get(), &config, nullptr, &error);
  if (error == JSStreamNameExistErr)
    status = js_UpdateStream(&found, stream.get(), &config, nullptr, &error);
  if (status != NATS_OK)
    return jetStreamFailure(connection, status, error);
  kept.messages = found->State.Msgs;
  kept.bytes = found->State.Bytes;
  kept.first_time = Time(found->State.FirstTime);
  jsStreamInfo_Destroy(found);
  return {};
}

LinkStatus
findKept(const LinkSettings& link, std::vector<SiteStream>& streams)
{
  streams.clear();
  Connection connection(link, nullptr);
  if (LinkStatus status = connection.open(); !status.ok())
    return status;
  JetStreamHandle stream;
  if (const natsStatus status = openJetStream(connection, stream); status != NATS_OK)
    return jetStreamFailure(connection, status, jsErrCode(0));
  jsOptions options;
  jsOptions_Init(&options);
  options.Stream.Info.SubjectsFilter = ">";
  jsErrCode error = jsErrCode(0);
  jsStreamInfo* found = nullptr;
  const natsStatus status =
      js_GetStreamInfo(&found, stream.get(), link.site.c_str(), &options, &error);
  if (status != NATS_OK)
    return jetStreamFailure(connection, status, error);
  const std::unique_ptr<jsStreamInfo, NatsDeleter<jsStreamInfo, jsStreamInfo_Destroy>>
      owner(found);
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

} // namespace link
} // namespace pcl_ext

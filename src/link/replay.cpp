#include "link/replay.h"

#include <pcl_ext/link/frame_subscriber.h>

#include "link/guarded.h"

#include <algorithm>
#include <array>
#include <string>

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

Replay::~Replay() { natsSubscription_Destroy(subscription_); }

LinkStatus
Replay::open(const Connection& connection, Time from)
{
  const std::string& site = connection.settings().site;
  if (const natsStatus status = openJetStream(connection, stream_); status != NATS_OK)
    return jetStreamFailure(connection, status, jsErrCode(0));
  jsSubOptions options;
  jsSubOptions_Init(&options);
  options.Stream = site.c_str();
  options.Ordered = true;
  options.Config.DeliverPolicy = from > Time(0) ? js_DeliverByStartTime : js_DeliverAll;
  options.Config.OptStartTime = from.count();
  jsErrCode error = jsErrCode(0);
  const std::string subject = site + ".>";
  const natsStatus status = js_SubscribeSync(
      &subscription_, stream_.get(), subject.c_str(), nullptr, &options, &error);
  if (status != NATS_OK)
    return jetStreamFailure(connection, status, error);
  jsConsumerInfo* consumer = nullptr;
  if (natsSubscription_GetConsumerInfo(&consumer, subscription_, nullptr, &error) ==
      NATS_OK) {
    // What was delivered meanwhile is not pending.
    is_at_end_ = consumer->NumPending == 0 && consumer->Delivered.Stream == 0;
    jsConsumerInfo_Destroy(consumer);
  }
  return {};
}

LinkStatus
Replay::next(std::chrono::nanoseconds timeout, MessageHandle& message)
{
  if (is_at_end_)
    return {LinkCode::EndOfReplay, "all frames that the server keeps were received"};
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(timeout).count();
  natsMsg* received = nullptr;
  const natsStatus status = natsSubscription_NextMsg(
      &received, subscription_, std::max<std::int64_t>(1, milliseconds));
  if (status == NATS_TIMEOUT || status == NATS_MISSED_HEARTBEAT)
    return {LinkCode::NoFrame, "no frame came in time"};
  if (status != NATS_OK)
    return {LinkCode::Closed,
            std::string("the replay has ended early: ") + natsStatus_GetText(status)};
  message.reset(received);
  jsMsgMetaData* position = nullptr;
  if (natsMsg_GetMetaData(&position, received) == NATS_OK) {
    is_at_end_ = position->NumPending == 0;
    jsMsgMetaData_Destroy(position);
  }
  return {};
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

} // namespace

LinkStatus
keepFrames(const LinkSettings& link,
           const KeepSettings& settings,
           KeptFrames& kept) noexcept
{
  return guarded([&] { return keep(link, settings, kept); });
}

} // namespace link
} // namespace pcl_ext

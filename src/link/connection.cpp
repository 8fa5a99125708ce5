// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/connection.h"

#include "link/subjects.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

constexpr std::int64_t reconnect_wait_ms = 200;
constexpr std::int64_t short_ping_interval_ms = 1500;
constexpr std::int64_t long_ping_interval_ms = 5000;
constexpr std::int64_t write_deadline_ms = 2000;
constexpr std::size_t longest_site = 64;

/** \brief The addresses. A comma separates them if a scheme follows; else it is part of
 * a user or password. */
std::vector<std::string>
serversOf(const LinkSettings& settings)
{
  std::vector<std::string> servers;
  std::istringstream list(settings.servers);
  for (std::string part; std::getline(list, part, ',');)
    if (servers.empty() || part.find("://") != std::string::npos)
      servers.push_back(part);
    else
      servers.back() += ',' + part;
  return servers;
}

bool
hasScheme(const std::string& server, const std::string& scheme)
{
  return server.compare(0, scheme.size(), scheme) == 0;
}

bool
isSecure(const LinkSettings& settings)
{
  const std::vector<std::string> servers = serversOf(settings);
  return !settings.ca_file.empty() || !settings.certificate_file.empty() ||
         std::any_of(servers.begin(), servers.end(), [](const std::string& server) {
           return hasScheme(server, "tls://");
         });
}

/** \brief The scheme of an address, empty if it has none that is known. */
std::string
schemeOf(const std::string& server)
{
  for (const char* const scheme : {"nats://", "tls://"})
    if (hasScheme(server, scheme))
      return scheme;
  return {};
}

bool
isPort(const std::string& text)
{
  constexpr std::size_t most_digits = 5;
  return !text.empty() && text.size() <= most_digits &&
         text.find_first_not_of("0123456789") == std::string::npos;
}

/** \brief HOST or HOST:PORT of an address; empty if it has none, as where what follows
 * the host is no port but may be a password. */
std::string
hostOf(const std::string& server)
{
  const std::size_t at = server.rfind('@');
  std::string host =
      server.substr(at == std::string::npos ? schemeOf(server).size() : at + 1);
  if (!host.empty() && host.back() == '/')
    host.pop_back();
  const bool is_ipv6 = !host.empty() && host.front() == '[';
  const std::size_t name_end = is_ipv6 ? host.find(']') + 1 : host.find(':');
  const std::string name = host.substr(0, name_end);
  const std::string others = is_ipv6 ? "[]:.%-_" : ".-_";
  const auto is_of_name = [&others](char character) {
    return std::isalnum(static_cast<unsigned char>(character)) != 0 ||
           others.find(character) != std::string::npos;
  };
  const bool has_port = name.size() < host.size();
  if (name.empty() || !std::all_of(name.begin(), name.end(), is_of_name) ||
      (has_port && (host[name.size()] != ':' || !isPort(host.substr(name.size() + 1)))))
    return {};
  return host;
}

/** \brief Addresses without anything that may be of a user or password. */
std::string
shownServers(const LinkSettings& settings)
{
  std::string shown;
  for (const std::string& server : serversOf(settings)) {
    const std::string host = hostOf(server);
    shown += (shown.empty() ? "" : ",") + schemeOf(server) +
             (host.empty() && !server.empty() ? "..." : host);
  }
  return shown;
}

/** \brief True if TLS fails as the server's certificate is of another name or address,
 * in the words of OpenSSL. */
bool
isOfOtherHost(const char* details)
{
  return details != nullptr &&
         std::string(details).find(" mismatch") != std::string::npos;
}

LinkStatus
invalid(const std::string& setting, const std::string& value, const std::string& rule)
{
  return {LinkCode::InvalidSettings,
          SettingText{'{' + setting + "} is '" + SettingText::of(value).marked +
                      "'; it must be " + rule}};
}

} // namespace

LinkStatus
checkSettings(const LinkSettings& settings)
{
  const std::vector<std::string> servers = serversOf(settings);
  const auto is_address = [](const std::string& server) {
    return !schemeOf(server).empty() && !hostOf(server).empty();
  };
  if (servers.empty() || !std::all_of(servers.begin(), servers.end(), is_address))
    return invalid(
        "servers", shownServers(settings), "nats://HOST:PORT or tls://HOST:PORT");
  const std::string& site = settings.site;
  if (site.empty() || site.size() > longest_site || escaped(site) != site ||
      site.find('/') != std::string::npos)
    return invalid("site", site, "up to 64 letters, digits, - and _");
  if (settings.certificate_file.empty() != settings.key_file.empty())
    return {LinkCode::InvalidSettings,
            SettingText{
                "{certificate_file} and {key_file} go together, and only one is set"}};
  if (settings.connect_timeout < std::chrono::milliseconds(1) ||
      settings.connect_timeout > std::chrono::hours(1))
    return invalid("connect_timeout",
                   std::to_string(settings.connect_timeout.count()) + " ms",
                   "from 1 ms to 1 hour");
  return {};
}

Connection::Connection(const LinkSettings& settings,
                       std::function<void()> on_reconnect,
                       Patience patience)
: settings_(settings), on_reconnect_(std::move(on_reconnect)), patience_(patience)
{}

Connection::~Connection()
{
  if (connection_ == nullptr)
    return;
  is_closing_ = true;
  natsConnection_Close(connection_);
  {
    // The last call of the library with `this`.
    std::unique_lock<std::mutex> lock(mutex_);
    closed_.wait(lock, [this] { return is_closed_; });
  }
  natsConnection_Destroy(connection_);
}

natsStatus
Connection::setSecurity(natsOptions* options, std::string& file)
{
  natsStatus status = NATS_OK;
  if (!settings_.user.empty())
    status = natsOptions_SetUserInfo(
        options, settings_.user.c_str(), settings_.password.c_str());
  if (status == NATS_OK && !settings_.token.empty())
    status = natsOptions_SetToken(options, settings_.token.c_str());
  if (status == NATS_OK && !settings_.credentials_file.empty()) {
    file = settings_.credentials_file;
    status = natsOptions_SetUserCredentialsFromFiles(options, file.c_str(), nullptr);
  }
  if (status != NATS_OK || !isSecure(settings_))
    return status;
  status = natsOptions_SetSecure(options, true);
  if (status == NATS_OK && !settings_.ca_file.empty()) {
    file = settings_.ca_file;
    status = natsOptions_LoadCATrustedCertificates(options, file.c_str());
  }
  if (status == NATS_OK && !settings_.certificate_file.empty()) {
    file = settings_.certificate_file + "' or '" + settings_.key_file;
    status = natsOptions_LoadCertificatesChain(
        options, settings_.certificate_file.c_str(), settings_.key_file.c_str());
  }
  return status;
}

LinkStatus
Connection::setOptions(natsOptions* options)
{
  const std::vector<std::string> servers = serversOf(settings_);
  std::vector<const char*> addresses;
  for (const std::string& server : servers)
    addresses.push_back(server.c_str());
  std::string file;
  if (const natsStatus status = setSecurity(options, file); status != NATS_OK) {
    if (file.empty())
      return {LinkCode::InvalidSettings, natsStatus_GetText(status)};
    return {LinkCode::InvalidSettings,
            "the file '" + file + "' cannot be read, or is not of its kind"};
  }
  const auto timeout = static_cast<std::int64_t>(settings_.connect_timeout.count());
  constexpr int for_ever = -1;
  constexpr int pings_without_answer = 2;
  // While there is no connection nothing is kept: a frame that arrives late is of no use.
  constexpr int no_buffer = 1;
  for (const natsStatus status :
       {natsOptions_SetServers(
            options, addresses.data(), static_cast<int>(addresses.size())),
        natsOptions_SetName(options, settings_.client_name.c_str()),
        natsOptions_SetTimeout(options, timeout),
        natsOptions_SetMaxReconnect(options, for_ever),
        natsOptions_SetReconnectWait(options, reconnect_wait_ms),
        natsOptions_SetReconnectBufSize(options, no_buffer),
        natsOptions_SetPingInterval(options,
                                    patience_ == Patience::Short
                                        ? short_ping_interval_ms
                                        : long_ping_interval_ms),
        natsOptions_SetMaxPingsOut(options, pings_without_answer),
        natsOptions_SetWriteDeadline(options, write_deadline_ms),
        natsOptions_SetDisconnectedCB(options, onDisconnected, this),
        natsOptions_SetReconnectedCB(options, onReconnected, this),
        natsOptions_SetClosedCB(options, onClosed, this),
        natsOptions_SetErrorHandler(options, onError, this)})
    if (status != NATS_OK)
      return {LinkCode::InvalidSettings, natsStatus_GetText(status)};
  return {};
}

LinkStatus
Connection::open()
{
  if (connection_ != nullptr)
    return {LinkCode::InvalidArgument, "it is connected already"};
  if (LinkStatus status = checkSettings(settings_); !status.ok())
    return status;
  natsOptions* created = nullptr;
  if (natsOptions_Create(&created) != NATS_OK)
    return outOfMemoryStatus<LinkStatus>();
  const std::unique_ptr<natsOptions, NatsDeleter<natsOptions, natsOptions_Destroy>>
      options(created);
  if (LinkStatus status = setOptions(options.get()); !status.ok())
    return status;
  const natsStatus status = natsConnection_Connect(&connection_, options.get());
  return status == NATS_OK ? LinkStatus() : connectionFailure(status);
}

LinkStatus
Connection::connectionFailure(natsStatus failure) const
{
  const std::string at = "the server at " + shownServers(settings_);
  switch (failure) {
  case NATS_NO_MEMORY:
    return outOfMemoryStatus<LinkStatus>();
  case NATS_CONNECTION_AUTH_FAILED:
    return {
        LinkCode::Refused,
        at + " refuses " +
            (settings_.user.empty()
                 ? "a client without the right user, token or "
                   "certificate"
                 : "user '" + settings_.user + "': wrong user or password" +
                       (settings_.password.empty() ? " (no password is set)" : ""))};
  case NATS_SECURE_CONNECTION_REQUIRED:
    return {LinkCode::CannotConnect,
            at + " takes encrypted connections alone: name it tls://HOST:PORT"};
  case NATS_SECURE_CONNECTION_WANTED:
    return {LinkCode::CannotConnect,
            at + " has no TLS, which tls:// and a certificate ask for"};
  case NATS_SSL_ERROR: {
    const char* const details = nats_GetLastError(nullptr);
    return {
        LinkCode::CannotConnect,
        SettingText{
            SettingText::of(at + " takes encrypted connections, and TLS fails: " +
                            (details != nullptr ? details : ""))
                .marked +
            (isOfOtherHost(details) ? "; the server's certificate must have the "
                                      "name or address by which {servers} has it"
                                    : "; {ca_file} has the certificates to trust")}};
  }
  case NATS_NO_SERVER: // nats.c does not tell which
    return {LinkCode::CannotConnect,
            at + " cannot be reached: no program listens there, or no host has that "
                 "name"};
  case NATS_TIMEOUT:
    return {LinkCode::CannotConnect,
            at + " does not answer within " +
                std::to_string(settings_.connect_timeout.count()) + " ms"};
  default: {
    const char* const details = nats_GetLastError(nullptr);
    return {LinkCode::CannotConnect,
            at + " cannot be used: " + natsStatus_GetText(failure) +
                (details != nullptr ? std::string(", ") + details : "")};
  }
  }
}

LinkStatus
Connection::statusOf(natsStatus failure) const
{
  if (failure == NATS_NO_MEMORY)
    return outOfMemoryStatus<LinkStatus>();
  if (isClosed())
    return {LinkCode::Closed,
            "the connection to the server at " + shownServers(settings_) +
                " is closed for good"};
  return {LinkCode::NotConnected,
          "the connection to the server at " + shownServers(settings_) +
              " is lost for the moment (" + natsStatus_GetText(failure) + ")"};
}

void
Connection::countViolation(const std::string& what)
{
  ++violations_;
  if (what.find(".echo\"") != std::string::npos)
    ++refused_echoes_;
  else if (what.find("Publish to") != std::string::npos)
    ++refused_messages_;
  else
    ++refused_subscriptions_;
}

std::uint64_t
Connection::number() const
{
  natsStatistics* created = nullptr;
  std::uint64_t number = 0;
  if (natsStatistics_Create(&created) == NATS_OK) {
    natsConnection_GetStats(connection_, created);
    natsStatistics_GetCounts(created, nullptr, nullptr, nullptr, nullptr, &number);
    natsStatistics_Destroy(created);
  }
  return number;
}

void
Connection::tellOfServer(const std::string& state) const
{
  tell("the server at " + shownServers(settings_) + " " + state);
}

void
Connection::tell(const std::string& event) const
{
  if (settings_.on_event && !is_closing_)
    settings_.on_event(event);
}

void
Connection::tellOfError(const std::string& error)
{
  constexpr std::chrono::seconds interval{10};
  constexpr std::size_t most_errors = 10'000;
  const auto now = std::chrono::steady_clock::now();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (told_errors_.size() > most_errors)
      told_errors_.clear();
    const auto [told, is_new] = told_errors_.emplace(error, now);
    if (!is_new && now - told->second < interval)
      return;
    told->second = now;
  }
  tellOfServer("reports: " + error);
}

void
Connection::onDisconnected(natsConnection* /* connection */, void* self)
{
  const auto& it = *static_cast<Connection*>(self);
  it.tell("the connection to the server at " + shownServers(it.settings_) + " is lost");
}

void
Connection::onReconnected(natsConnection* /* connection */, void* self)
{
  auto& it = *static_cast<Connection*>(self);
  ++it.reconnections_;
  it.refused_subscriptions_ = 0;
  it.tell("the connection to the server at " + shownServers(it.settings_) +
          " is there again");
  if (it.on_reconnect_)
    it.on_reconnect_();
}

void
Connection::onClosed(natsConnection* /* connection */, void* self)
{
  auto& it = *static_cast<Connection*>(self);
  it.tell("the connection to the server at " + shownServers(it.settings_) +
          " is closed for good: it may not accept this client any more");
  const std::lock_guard<std::mutex> lock(it.mutex_);
  it.is_closed_ = true;
  it.closed_.notify_all();
}

void
Connection::onError(natsConnection* connection,
                    natsSubscription* /* subscription */,
                    natsStatus error,
                    void* self)
{
  const char* details = nullptr;
  natsConnection_GetLastError(connection, &details);
  if (error == NATS_NOT_PERMITTED)
    static_cast<Connection*>(self)->countViolation(details != nullptr ? details : "");
  static_cast<Connection*>(self)->tellOfError(
      details != nullptr && *details != '\0' ? details : natsStatus_GetText(error));
}

Subscription::~Subscription()
{
  if (subscription_ == nullptr)
    return;
  natsSubscription_Unsubscribe(subscription_);
  {
    std::unique_lock<std::mutex> lock(mutex_);
    completed_.wait(lock, [this] { return is_complete_; });
  }
  natsSubscription_Destroy(subscription_);
}

natsStatus
Subscription::open(const Connection& connection,
                   const std::string& subject,
                   Handler handler)
{
  handler_ = std::move(handler);
  const natsStatus status = natsConnection_Subscribe(
      &subscription_, connection.get(), subject.c_str(), onMessage, this);
  if (status != NATS_OK)
    return status;
  return natsSubscription_SetOnCompleteCB(subscription_, onComplete, this);
}

void
Subscription::onMessage(natsConnection* /* connection */,
                        natsSubscription* /* subscription */,
                        natsMsg* message,
                        void* self)
{
  const MessageHandle owned(message);
  static_cast<Subscription*>(self)->handler_(message);
}

void
Subscription::onComplete(void* self)
{
  auto& it = *static_cast<Subscription*>(self);
  const std::lock_guard<std::mutex> lock(it.mutex_);
  it.is_complete_ = true;
  it.completed_.notify_all();
}

} // namespace pcl_ext::PCL_EXT_ABI::link

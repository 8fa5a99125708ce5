// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/link_settings.h>

#include <nats/nats.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Owns an object of the NATS library. */
template <typename ObjectT, void (*destroy)(ObjectT*)>
struct NatsDeleter {
  void
  operator()(ObjectT* object) const
  {
    destroy(object);
  }
};
using MessageHandle = std::unique_ptr<natsMsg, NatsDeleter<natsMsg, natsMsg_Destroy>>;
using JetStreamHandle = std::unique_ptr<jsCtx, NatsDeleter<jsCtx, jsCtx_Destroy>>;

/** \brief Calls a function; exceptions become a status. */
template <typename FunctionT>
LinkStatus
guarded(const FunctionT& function) noexcept
{
  try {
    return function();
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<LinkStatus>();
  }
  catch (const std::exception&) {
    return {LinkCode::Closed, "thread failed"};
  }
}

/** \brief A connection to a server, which is restored for ever once it was there. */
class Connection {
public:
  /** \brief How soon a connection without answers counts as lost. */
  enum class Patience {
    Short, ///< 4.5 s: of what is live
    Long   ///< 15 s: answers come behind many megabytes
  };

  /** \param[in] settings checked by open()
   * \param[in] on_reconnect called by another thread; may be empty
   */
  Connection(const LinkSettings& settings,
             std::function<void()> on_reconnect,
             Patience patience = Patience::Short);

  /** \brief Closes it. Subscriptions must have ended, as their handlers may use what the
   * caller destroys. */
  ~Connection();
  Connection(const Connection&) = delete;
  Connection&
  operator=(const Connection&) = delete;

  /** \brief Connects to the first server that answers. */
  LinkStatus
  open();

  /** \brief Null before open(). */
  natsConnection*
  get() const
  {
    return connection_;
  }

  const LinkSettings&
  settings() const
  {
    return settings_;
  }

  /** \brief True if messages can be sent at the moment. */
  bool
  isConnected() const
  {
    return connection_ != nullptr &&
           natsConnection_Status(connection_) == NATS_CONN_STATUS_CONNECTED;
  }

  /** \brief True if it is lost for good. */
  bool
  isClosed() const
  {
    return connection_ != nullptr && natsConnection_IsClosed(connection_);
  }

  std::uint64_t
  reconnections() const
  {
    return reconnections_;
  }

  /** \brief A number that each new connection to a server changes. */
  std::uint64_t
  number() const;

  /** \brief Tells that the server is in a state, such as "answers again". */
  void
  tellOfServer(const std::string& state) const;

  /** \brief How often the server did not permit what was asked of it. */
  std::uint64_t
  violations() const
  {
    return violations_;
  }

  /** \brief How often it did not permit to publish or to subscribe to an echo; the rest
   * is counted by the next two. */
  std::uint64_t
  refusedEchoes() const
  {
    return refused_echoes_;
  }

  /** \brief How many messages it did not permit to publish. */
  std::uint64_t
  refusedMessages() const
  {
    return refused_messages_;
  }

  /** \brief How many subscriptions it did not permit, since it was connected. */
  std::size_t
  refusedSubscriptions() const
  {
    return refused_subscriptions_;
  }

  /** \brief The status of a failure to connect. */
  LinkStatus
  connectionFailure(natsStatus failure) const;

  /** \brief The status of a call that failed on an open connection. */
  LinkStatus
  statusOf(natsStatus failure) const;

private:
  LinkStatus
  setOptions(natsOptions* options);

  natsStatus
  setSecurity(natsOptions* options, std::string& file);

  void
  tell(const std::string& event) const;

  /** \brief Tells what the server reports, but not again within some seconds, as for each
   * frame. */
  void
  tellOfError(const std::string& error);

  /** \brief Counts what the server did not permit.
   * \param[in] what in its words
   */
  void
  countViolation(const std::string& what);

  static void
  onDisconnected(natsConnection* connection, void* self);
  static void
  onReconnected(natsConnection* connection, void* self);
  static void
  onClosed(natsConnection* connection, void* self);
  static void
  onError(natsConnection* connection,
          natsSubscription* subscription,
          natsStatus error,
          void* self);

  const LinkSettings settings_;
  const std::function<void()> on_reconnect_;
  const Patience patience_;
  natsConnection* connection_ = nullptr;
  std::atomic<std::uint64_t> reconnections_{0};
  std::atomic<std::uint64_t> violations_{0};
  std::atomic<std::uint64_t> refused_echoes_{0};
  std::atomic<std::uint64_t> refused_messages_{0};
  std::atomic<std::size_t> refused_subscriptions_{0};
  std::atomic<bool> is_closing_{false};
  std::mutex mutex_; // guards what follows
  std::condition_variable closed_;
  bool is_closed_ = false;
  std::map<std::string, std::chrono::steady_clock::time_point> told_errors_; // and when
};

/** \brief A subscription whose handler is not called any more once this is destroyed. */
class Subscription {
public:
  using Handler = std::function<void(natsMsg*)>;

  Subscription() = default;
  ~Subscription();
  Subscription(const Subscription&) = delete;
  Subscription&
  operator=(const Subscription&) = delete;

  /** \brief Subscribes.
   * \param[in] handler called by other threads, for one message at a time
   */
  natsStatus
  open(const Connection& connection, const std::string& subject, Handler handler);

private:
  static void
  onMessage(natsConnection* connection,
            natsSubscription* subscription,
            natsMsg* message,
            void* self);
  static void
  onComplete(void* self);

  Handler handler_;
  natsSubscription* subscription_ = nullptr;
  std::mutex mutex_;
  std::condition_variable completed_;
  bool is_complete_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::link

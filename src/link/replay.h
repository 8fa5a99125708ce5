// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "link/connection.h"

#include <atomic>
#include <chrono>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Reads the frames of a site that a server keeps, in the order of their arrival.
 * The server sends them as they are taken: 32 MiB or two messages wait at most. For one
 * thread at a time. */
class Replay {
public:
  Replay() = default;
  ~Replay() { end(); }
  Replay(const Replay&) = delete;
  Replay&
  operator=(const Replay&) = delete;

  /** \brief Begins.
   * \param[in] connection an open one, which outlives this
   * \param[in] from time of arrival of the first frame; 0: the oldest one
   */
  LinkStatus
  open(const Connection& connection, Time from);

  /** \brief The next message.
   * \return EndOfReplay after the last one of those that were kept when it began; NoFrame
   * if none came in time
   */
  LinkStatus
  next(std::chrono::nanoseconds timeout, MessageHandle& message);

  /** \brief When the last message arrived at the server. */
  Time
  lastTime() const
  {
    return time_;
  }

  /** \brief How many messages are still to come. Called by any thread. */
  std::uint64_t
  pending() const
  {
    return pending_;
  }

private:
  using Clock = std::chrono::steady_clock;

  /** \brief Makes the server's consumer.
   * \param[in] config where it begins
   */
  LinkStatus
  begin(jsConsumerConfig config);

  /** \brief Begins after the last message that came. */
  LinkStatus
  beginAnew();

  /** \brief Drops the server's consumer, and what has come of it and was not taken. */
  void
  end();

  /** \brief Waits for the next message of the consumer. */
  LinkStatus
  receive(std::chrono::milliseconds timeout, MessageHandle& message);

  /** \brief Asks how many messages are to come.
   * \return false if the server does not tell, or some that it has sent have not come
   */
  bool
  updatePending();

  /** \param[in] pending messages that the server has for the consumer, also later ones */
  void
  setPending(std::uint64_t pending);

  /** \brief Takes the place of a message into account; false if others are missing before
   * it. */
  bool
  follow(natsMsg* message);

  const Connection* connection_ = nullptr;
  JetStreamHandle stream_;
  natsSubscription* subscription_ = nullptr;
  std::uint64_t most_waiting_ = 2; // messages that are not acknowledged
  std::uint64_t last_ = 0;         // number in the server's stream, of the last one
  std::uint64_t number_ = 0;       // of the one that came last
  Time time_{0};                   // of its arrival at the server
  std::uint64_t delivered_ = 0;    // by the consumer
  std::atomic<std::uint64_t> pending_{0};
  unsigned int failures_ = 0; // since a message came
  Clock::time_point last_arrival_{};
};

} // namespace pcl_ext::PCL_EXT_ABI::link

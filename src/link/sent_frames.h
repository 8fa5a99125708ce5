// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_publisher.h>

#include "link/connection.h"

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Which frames the server has: those before a ping that it has answered. What it
 * has not answered when the connection is lost counts as lost. Members are
 * thread-safe. */
class SentFrames {
public:
  /** \param[in] connection must outlive this
   * \param[in] on_answer called by another thread when the server answers again after it
   * did not in time
   */
  SentFrames(Connection& connection, std::function<void()> on_answer);
  ~SentFrames();
  SentFrames(const SentFrames&) = delete;
  SentFrames&
  operator=(const SentFrames&) = delete;

  /** \brief A frame was handed to the connection.
   * \param[in] connection its number before that
   */
  void
  add(std::size_t bytes, std::uint64_t connection);

  /** \brief A frame could not be handed to the connection. */
  void
  addLost();

  /** \brief Waits for the answer to a ping.
   * \return true if the server has all frames that were added before
   */
  bool
  flush(std::chrono::milliseconds timeout);

  /** \brief True if there is a connection, and pings are answered in time. */
  bool
  isAnswering() const;

  /** \brief Sets what it knows: frames, bytes, age, and whether it is connected. */
  void
  describe(PublisherStatistics& statistics);

private:
  using Clock = std::chrono::steady_clock;

  struct Frame {
    std::size_t bytes;
    std::uint64_t connection; // its number before
    Clock::time_point time;
  };

  void
  run();

  /** \brief Counts frames that are lost with a connection, or known to be sent by time
   * alone. The mutex is locked. */
  void
  settle();

  /** \brief Counts the first frame under way as sent. The mutex is locked. */
  void
  countSent();

  bool
  isOutOfStep() const;

  /** \brief As flush(), where pings are not answered. */
  bool
  waitUntilKnown(std::chrono::milliseconds timeout);

  /** \brief Counts frames that the server has.
   * \param[in] count of the frames that were ever added
   */
  void
  acknowledge(std::uint64_t count);

  /** \brief Takes into account whether a ping was answered, and tells changes. */
  void
  setAnswering(bool is_answering);

  Connection& connection_;
  const std::function<void()> on_answer_;
  mutable std::mutex mutex_; // guards what follows
  std::condition_variable changed_;
  std::deque<Frame> under_way_;
  std::uint64_t added_ = 0;
  std::uint64_t frames_ = 0; // that the server has
  std::uint64_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t unanswered_frames_ = 0; // of these, when their connection was lost
  std::optional<Clock::time_point> last_sent_;
  std::optional<std::uint64_t> unanswered_; // connection whose ping was not answered
  Clock::time_point unanswered_since_;
  std::optional<std::uint64_t> out_of_step_; // one whose flushes are never answered
  bool has_ended_ = false;
  std::thread thread_; // last, as it uses the others
};

} // namespace pcl_ext::PCL_EXT_ABI::link

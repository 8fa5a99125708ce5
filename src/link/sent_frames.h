// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_publisher.h>

#include "link/connection.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

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
  SentFrames(Connection& connection, std::function<void()> on_answer)
  : connection_(connection)
  , on_answer_(std::move(on_answer))
  , thread_([this] { run(); })
  {}

  ~SentFrames()
  {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      has_ended_ = true;
      changed_.notify_all();
    }
    thread_.join();
  }

  SentFrames(const SentFrames&) = delete;
  SentFrames&
  operator=(const SentFrames&) = delete;

  /** \brief A frame was handed to the connection.
   * \param[in] connection its number before that
   */
  void
  add(std::size_t bytes, std::uint64_t connection)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    under_way_.push_back({bytes, connection, Clock::now()});
    ++added_;
    changed_.notify_all();
  }

  /** \brief A frame could not be handed to the connection. */
  void
  addLost()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++lost_;
  }

  /** \brief Waits for the answer to a ping.
   * \return true if the server has all frames that were added before
   */
  bool
  flush(std::chrono::milliseconds timeout)
  {
    std::uint64_t count = 0;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      settle();
      count = added_;
    }
    if (!connection_.isConnected())
      return false;
    if (isOutOfStep())
      return waitUntilKnown(timeout);
    const natsStatus status = natsConnection_FlushTimeout(
        connection_.get(), std::max<std::int64_t>(1, timeout.count()));
    if (status == NATS_OK) {
      acknowledge(count);
      setAnswering(true);
    }
    else if (status == NATS_TIMEOUT && timeout >= longest_answer)
      setAnswering(false);
    return status == NATS_OK;
  }

  /** \brief True if there is a connection, and pings are answered in time. */
  bool
  isAnswering() const
  {
    if (!connection_.isConnected())
      return false;
    const std::lock_guard<std::mutex> lock(mutex_);
    return !unanswered_ || *unanswered_ != connection_.number();
  }

  /** \brief Sets what it knows: frames, bytes, age, and whether it is connected. */
  void
  describe(PublisherStatistics& statistics)
  {
    statistics.is_connected = isAnswering();
    const std::lock_guard<std::mutex> lock(mutex_);
    settle();
    statistics.frames = frames_;
    statistics.bytes = bytes_;
    statistics.frames_not_sent = lost_;
    statistics.frames_unanswered = unanswered_frames_;
    statistics.frames_under_way = under_way_.size();
    if (last_sent_)
      statistics.age = Clock::now() - *last_sent_;
  }

private:
  /** \brief Frames within this time share a ping. */
  static constexpr std::chrono::milliseconds ping_interval{200};

  /** \brief A server that takes longer is not answering. */
  static constexpr std::chrono::milliseconds longest_answer{1500};

  /** \brief The wait for one that is not. The connection is lost by then, see
   * Connection::Patience, if the server does not answer the library's own pings. */
  static constexpr std::chrono::milliseconds second_wait{4000};

  /** \brief What was handed to a connection before is at the server if that connection is
   * there, likewise. */
  static constexpr std::chrono::milliseconds known_after{5000};

  using Clock = std::chrono::steady_clock;

  struct Frame {
    std::size_t bytes;
    std::uint64_t connection; // its number before
    Clock::time_point time;
  };

  void
  run()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!has_ended_) {
      changed_.wait(lock, [this] {
        // One that does not answer is sent no frames, but asked until it does.
        return has_ended_ || !under_way_.empty() || unanswered_ == connection_.number();
      });
      if (changed_.wait_for(lock, ping_interval, [this] { return has_ended_; }))
        return;
      lock.unlock();
      flush(isAnswering() ? longest_answer : second_wait);
      lock.lock();
    }
  }

  /** \brief Counts frames that are lost with a connection, or known to be sent by time
   * alone. The mutex is locked. */
  void
  settle()
  {
    const bool is_connected = connection_.isConnected();
    const std::uint64_t connection = connection_.number();
    while (!under_way_.empty() &&
           (!is_connected || under_way_.front().connection != connection)) {
      ++lost_;
      ++unanswered_frames_;
      under_way_.pop_front();
    }
    while (out_of_step_ == connection && !under_way_.empty() &&
           Clock::now() - under_way_.front().time > known_after)
      countSent();
  }

  /** \brief Counts the first frame under way as sent. The mutex is locked. */
  void
  countSent()
  {
    const Frame& frame = under_way_.front();
    ++frames_;
    bytes_ += frame.bytes;
    last_sent_ = frame.time;
    under_way_.pop_front();
  }

  bool
  isOutOfStep() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return out_of_step_ == connection_.number();
  }

  /** \brief As flush(), where pings are not answered. */
  bool
  waitUntilKnown(std::chrono::milliseconds timeout)
  {
    const Clock::time_point end = Clock::now() + timeout;
    std::unique_lock<std::mutex> lock(mutex_);
    const std::uint64_t lost = lost_;
    while (!under_way_.empty() && Clock::now() < end) {
      changed_.wait_for(lock, ping_interval);
      settle();
    }
    return under_way_.empty() && lost_ == lost;
  }

  /** \brief Counts frames that the server has.
   * \param[in] count of the frames that were ever added
   */
  void
  acknowledge(std::uint64_t count)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    settle();
    while (!under_way_.empty() && added_ - under_way_.size() < count)
      countSent();
  }

  /** \brief Takes into account whether a ping was answered, and tells changes. */
  void
  setAnswering(bool is_answering)
  {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const std::uint64_t connection = connection_.number();
      const bool did_answer = unanswered_ != connection;
      // Nothing is known of its pings, also if this one was sent before that was known.
      if (!is_answering && out_of_step_ == connection)
        return;
      // The library answers no flush any more if one was made in the moment in which a
      // connection was lost: its numbers of pings are out of step.
      if (!is_answering && !did_answer) {
        if (Clock::now() - unanswered_since_ < second_wait)
          return;
        out_of_step_ = connection;
        is_answering = true;
      }
      if (did_answer == is_answering)
        return;
      unanswered_.reset();
      if (!is_answering) {
        unanswered_ = connection;
        unanswered_since_ = Clock::now();
        changed_.notify_all();
      }
    }
    connection_.tellOfServer(is_answering
                                 ? "answers again"
                                 : "does not answer: frames are lost until it does");
    if (is_answering && on_answer_)
      on_answer_();
  }

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

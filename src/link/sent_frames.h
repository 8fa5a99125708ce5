// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_publisher.h>

#include "link/connection.h"
#include "link/subjects.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief A number that nobody else has. */
inline std::uint64_t
randomNumber()
{
  std::random_device device;
  constexpr unsigned int half = 32;
  return (std::uint64_t{device()} << half) | device();
}

/** \brief Which frames the server has: those before a message of one's own that it has
 * brought back, an echo. What has no echo when the connection is lost counts as lost.
 *
 * The library's flush does not do: it succeeds also if its ping could not be written.
 * Members are thread-safe. */
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

  /** \brief Subscribes to the echoes of an open connection, and waits for a first one.
   * May be called again after it has failed.
   * \param[in] publisher its number, unlike those of others
   */
  LinkStatus
  open(std::uint64_t publisher)
  {
    const LinkSettings& settings = connection_.settings();
    const Clock::time_point end = Clock::now() + settings.connect_timeout;
    const std::uint64_t refused = connection_.refusedEchoes();
    subject_ = echoSubject(settings.site, publisher);
    if (const natsStatus status = subscribe(); status != NATS_OK)
      return connection_.statusOf(status);
    for (std::uint64_t echo = ask(); !waitFor(echo, Clock::now() + poll_interval);) {
      if (connection_.refusedEchoes() > refused)
        return {LinkCode::Refused,
                "the server does not permit this user to publish and to subscribe to " +
                    settings.site + ".*.echo, by which it knows what has arrived"};
      if (connection_.isClosed())
        return connection_.statusOf(NATS_CONNECTION_CLOSED);
      if (Clock::now() > end)
        return connection_.connectionFailure(NATS_TIMEOUT);
      if (!isUnderWay(echo)) {
        std::this_thread::sleep_for(poll_interval);
        echo = ask();
      }
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    is_open_ = true;
    return {};
  }

  /** \brief True if open() has succeeded. */
  bool
  isOpen() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return is_open_;
  }

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

  /** \brief Waits for an echo.
   * \return true if the server has all frames that were added before
   */
  bool
  flush(std::chrono::milliseconds timeout) noexcept
  {
    const Clock::time_point end = Clock::now() + timeout;
    bool has_come = false;
    guarded([&] {
      has_come = waitFor(ask(), end);
      return LinkStatus();
    });
    return has_come;
  }

  /** \brief True if it is open, there is a connection, and echoes come in time. */
  bool
  isAnswering() const
  {
    if (!connection_.isConnected())
      return false;
    const std::lock_guard<std::mutex> lock(mutex_);
    return is_open_ && unanswered_ != connection_.number();
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
  /** \brief Frames within this time share an echo. */
  static constexpr std::chrono::milliseconds echo_interval{200};

  /** \brief How often who waits for an echo looks whether it can still come. */
  static constexpr std::chrono::milliseconds poll_interval{50};

  /** \brief A server that takes longer is not answering. It is asked again after as long,
   * as echoes may be lost that are not permitted for a time, or are too many. */
  static constexpr std::chrono::milliseconds longest_answer{1500};

  /** \brief Further ones take the place of the first. */
  static constexpr std::size_t most_asked = 1024;

  using Clock = std::chrono::steady_clock;

  struct Frame {
    std::size_t bytes;
    std::uint64_t connection; // its number before
    Clock::time_point time;
  };

  struct Echo {
    std::uint64_t number = 0;     // from 1
    std::uint64_t content = 0;    // random, so that nobody else can send it before
    std::uint64_t connection = 0; // its number before
    std::uint64_t frames = 0;     // that were added before, ever
    Clock::time_point time;
  };

  void
  run()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!has_ended_) {
      changed_.wait(lock, [this] {
        // Also one that does not answer and is sent no frames is asked until it does.
        return has_ended_ ||
               (is_open_ && (!under_way_.empty() || !asked_.empty() || unanswered_));
      });
      if (changed_.wait_for(lock, echo_interval, [this] { return has_ended_; }))
        return;
      settle();
      const bool becomes_late = !asked_.empty() && isLate(asked_.front()) &&
                                unanswered_ != asked_.front().connection;
      if (becomes_late)
        unanswered_ = asked_.front().connection;
      const bool asks = asked_.empty() || isLate(asked_.back());
      lock.unlock();
      guarded([&] {
        if (becomes_late)
          connection_.tellOfServer("does not answer: frames are lost until it does");
        // The server has ended a subscription that it did not permit any more.
        if (asks && refused_echoes_ != connection_.refusedEchoes())
          subscribe();
        if (asks)
          ask();
        return LinkStatus();
      });
      lock.lock();
    }
  }

  static bool
  isLate(const Echo& echo)
  {
    return Clock::now() - echo.time > longest_answer;
  }

  /** \brief Subscribes to the echoes, anew if it has before. Called by one thread: that
   * of open(), then that of run(). */
  natsStatus
  subscribe()
  {
    refused_echoes_ = connection_.refusedEchoes();
    echoes_.reset();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      asked_.clear();
      lost_echo_ = echo_count_;
    }
    echoes_.emplace();
    return echoes_->open(
        connection_, subject_, [this](natsMsg* message) { takeEcho(message); });
  }

  /** \brief Asks for an echo, unless one is under way that tells the same.
   * \return its number; 0 if it cannot be sent
   */
  std::uint64_t
  ask()
  {
    if (!connection_.isConnected())
      return 0;
    Echo echo;
    echo.content = randomNumber();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      settle();
      if (!asked_.empty() && asked_.back().frames == added_ && !isLate(asked_.back()))
        return asked_.back().number;
      if (asked_.size() >= most_asked)
        asked_.pop_front();
      echo.number = ++echo_count_;
      echo.connection = connection_.number();
      echo.frames = added_;
      echo.time = Clock::now();
      asked_.push_back(echo);
      changed_.notify_all();
    }
    const natsStatus status = natsConnection_PublishString(
        connection_.get(), subject_.c_str(), std::to_string(echo.content).c_str());
    if (status == NATS_OK)
      return echo.number;
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto failed = positionOf(&Echo::number, echo.number);
    if (failed != asked_.end())
      asked_.erase(failed);
    lost_echo_ = std::max(lost_echo_, echo.number);
    return 0;
  }

  /** \brief An echo that is under way, by its number or content. The mutex is locked. */
  std::deque<Echo>::iterator
  positionOf(std::uint64_t Echo::*member, std::uint64_t value)
  {
    return std::find_if(asked_.begin(), asked_.end(), [&](const Echo& echo) {
      return echo.*member == value;
    });
  }

  bool
  isUnderWay(std::uint64_t number)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return positionOf(&Echo::number, number) != asked_.end();
  }

  /** \brief Waits for an echo, or until it cannot come any more.
   * \return true if it has come
   */
  bool
  waitFor(std::uint64_t number, Clock::time_point end)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (answered_ < number && lost_echo_ < number && Clock::now() < end) {
      changed_.wait_until(lock, std::min(end, Clock::now() + poll_interval));
      settle();
    }
    return answered_ >= number && lost_echo_ < number;
  }

  /** \brief Counts what the server had before it brought an echo. */
  void
  takeEcho(const natsMsg* message)
  {
    const char* const text = natsMsg_GetData(message);
    std::uint64_t content = 0;
    const auto parsed =
        std::from_chars(text, text + natsMsg_GetDataLength(message), content);
    bool was_late = false;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      settle();
      const auto come = positionOf(&Echo::content, content);
      if (parsed.ec != std::errc() || come == asked_.end())
        return;
      while (!under_way_.empty() && added_ - under_way_.size() < come->frames)
        countSent();
      answered_ = come->number;
      was_late = unanswered_ == come->connection;
      asked_.erase(asked_.begin(), come + 1);
      if (was_late)
        unanswered_.reset();
      changed_.notify_all();
    }
    if (was_late)
      guarded([this] {
        connection_.tellOfServer("answers again");
        if (on_answer_)
          on_answer_();
        return LinkStatus();
      });
  }

  /** \brief Takes into account that frames and echoes are lost with a connection. The
   * mutex is locked. */
  void
  settle()
  {
    const bool is_connected = connection_.isConnected();
    const std::uint64_t connection = connection_.number();
    const auto is_lost = [&](const auto& sent) {
      return !is_connected || sent.connection != connection;
    };
    for (; !under_way_.empty() && is_lost(under_way_.front()); under_way_.pop_front()) {
      ++lost_;
      ++unanswered_frames_;
    }
    for (; !asked_.empty() && is_lost(asked_.front()); asked_.pop_front())
      lost_echo_ = asked_.front().number;
    if (unanswered_ && (!is_connected || *unanswered_ != connection))
      unanswered_.reset();
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

  Connection& connection_;
  const std::function<void()> on_answer_;
  std::string subject_;
  mutable std::mutex mutex_; // guards what follows
  std::condition_variable changed_;
  std::deque<Frame> under_way_;
  std::uint64_t added_ = 0;
  std::uint64_t frames_ = 0; // that the server has
  std::uint64_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t unanswered_frames_ = 0; // of these, when their connection was lost
  std::optional<Clock::time_point> last_sent_;
  std::deque<Echo> asked_; // and under way, by number
  std::uint64_t echo_count_ = 0;
  std::uint64_t answered_ = 0;              // the last echo that came
  std::uint64_t lost_echo_ = 0;             // the last one that will not come
  std::optional<std::uint64_t> unanswered_; // connection whose echo is late
  bool is_open_ = false;
  bool has_ended_ = false;
  std::thread thread_; // after what it uses
  // Of the thread that subscribes:
  std::uint64_t refused_echoes_ = 0; // of the connection, before
  std::optional<Subscription> echoes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::link

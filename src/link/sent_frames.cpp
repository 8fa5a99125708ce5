// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/sent_frames.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

/** \brief Frames within this time share a ping. */
constexpr std::chrono::milliseconds ping_interval{200};

/** \brief A server that takes longer is not answering. */
constexpr std::chrono::milliseconds longest_answer{1500};

/** \brief The wait for one that is not. The connection is lost by then, see
 * Connection::Patience, if the server does not answer the library's own pings. */
constexpr std::chrono::milliseconds second_wait{4000};

/** \brief What was handed to a connection before is at the server if that connection is
 * there, likewise. */
constexpr std::chrono::milliseconds known_after{5000};

} // namespace

SentFrames::SentFrames(Connection& connection, std::function<void()> on_answer)
: connection_(connection), on_answer_(std::move(on_answer)), thread_([this] { run(); })
{}

SentFrames::~SentFrames()
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    has_ended_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void
SentFrames::add(std::size_t bytes, std::uint64_t connection)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  under_way_.push_back({bytes, connection, Clock::now()});
  ++added_;
  changed_.notify_all();
}

void
SentFrames::addLost()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++lost_;
}

void
SentFrames::settle()
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

void
SentFrames::countSent()
{
  const Frame& frame = under_way_.front();
  ++frames_;
  bytes_ += frame.bytes;
  last_sent_ = frame.time;
  under_way_.pop_front();
}

void
SentFrames::acknowledge(std::uint64_t count)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  settle();
  while (!under_way_.empty() && added_ - under_way_.size() < count)
    countSent();
}

void
SentFrames::setAnswering(bool is_answering)
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::uint64_t connection = connection_.number();
    const bool did_answer = unanswered_ != connection;
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
    }
  }
  connection_.tellOfServer(is_answering ? "answers again"
                                        : "does not answer: frames are lost");
  if (is_answering && on_answer_)
    on_answer_();
}

bool
SentFrames::flush(std::chrono::milliseconds timeout)
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

bool
SentFrames::isOutOfStep() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return out_of_step_ == connection_.number();
}

bool
SentFrames::waitUntilKnown(std::chrono::milliseconds timeout)
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

bool
SentFrames::isAnswering() const
{
  if (!connection_.isConnected())
    return false;
  const std::lock_guard<std::mutex> lock(mutex_);
  return !unanswered_ || *unanswered_ != connection_.number();
}

void
SentFrames::describe(PublisherStatistics& statistics)
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

void
SentFrames::run()
{
  std::unique_lock<std::mutex> lock(mutex_);
  while (!has_ended_) {
    changed_.wait(lock, [this] { return has_ended_ || !under_way_.empty(); });
    if (changed_.wait_for(lock, ping_interval, [this] { return has_ended_; }))
      return;
    lock.unlock();
    flush(isAnswering() ? longest_answer : second_wait);
    lock.lock();
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::link

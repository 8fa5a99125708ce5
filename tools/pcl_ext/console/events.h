// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Sentences of other threads, which the command prints when it has time. One that
 * comes again and again is printed once in ten seconds. Where others come between, as "is
 * there again" after "is lost", all are, up to 20 in that time. */
class Events {
public:
  /** \brief Called by any thread. */
  void
  add(const std::string& event)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (waiting_.size() < most_waiting &&
        (waiting_.empty() || waiting_.back() != event))
      waiting_.push_back(event);
  }

  void
  print(Console& console)
  {
    std::vector<std::string> events;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      events.swap(waiting_);
    }
    const Clock::time_point now = Clock::now();
    if (now - begin_ >= interval) {
      begin_ = now;
      repeated_ = 0;
    }
    for (const std::string& event : events) {
      const auto [printed, is_new] = printed_.emplace(event, now);
      if (!is_new && now - printed->second < interval &&
          (event == last_ || repeated_++ >= most_repeated))
        continue;
      printed->second = now;
      last_ = event;
      console.error(event);
    }
    if (printed_.size() > most_waiting)
      printed_.clear();
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t most_waiting = 100;
  static constexpr std::chrono::seconds interval{10};
  static constexpr std::size_t most_repeated = 20; // in the interval

  std::mutex mutex_;
  std::vector<std::string> waiting_;
  // Used by print() alone:
  std::map<std::string, Clock::time_point> printed_; // when
  std::string last_;                                 // that was printed
  Clock::time_point begin_{};                        // of the interval
  std::size_t repeated_ = 0;                         // in it
};

} // namespace pcl_ext::tools

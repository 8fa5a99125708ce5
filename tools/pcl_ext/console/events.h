#pragma once

#include "console/console.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief Sentences of other threads, which the command prints when it has time; one that
 * comes again and again, once in ten seconds. */
class Events {
public:
  /** \brief Called by any thread. */
  void
  add(const std::string& event)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    // Until they are printed the same ones are one.
    if (waiting_.size() < most_waiting &&
        std::find(waiting_.begin(), waiting_.end(), event) == waiting_.end())
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
    for (const std::string& event : events) {
      const auto [printed, is_new] = printed_.emplace(event, now);
      if (!is_new && now - printed->second < interval)
        continue;
      printed->second = now;
      console.error(event);
    }
    if (printed_.size() > most_waiting)
      printed_.clear();
  }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t most_waiting = 100;
  static constexpr std::chrono::seconds interval{10};

  std::mutex mutex_;
  std::vector<std::string> waiting_;
  std::map<std::string, Clock::time_point> printed_; // when; used by print() alone
};

} // namespace tools
} // namespace pcl_ext

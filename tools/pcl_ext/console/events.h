#pragma once

#include "console/console.h"

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief Sentences of other threads, which the command prints when it has time. */
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
    for (const std::string& event : events)
      console.error(event);
  }

private:
  static constexpr std::size_t most_waiting = 100;

  std::mutex mutex_;
  std::vector<std::string> waiting_;
};

} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/interruption.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

namespace pcl_ext::tools {

/** \brief Waits so that what has a time comes at the pace of its times, of which the
 * first one is now. */
class RealTime {
public:
  using Clock = std::chrono::steady_clock;

  /** \brief Waits until it is time.
   * \param[in] time of what comes next
   * \param[in] meanwhile called about 20 times a second
   * \return how late it is; 0 if it waited
   */
  std::chrono::nanoseconds
  waitFor(std::chrono::nanoseconds time, const std::function<void()>& meanwhile)
  {
    constexpr std::chrono::milliseconds longest_wait{50};
    if (!start_)
      start_ = Clock::now() - time;
    const Clock::time_point due = *start_ + time;
    meanwhile();
    const auto late = std::max(Clock::now() - due, Clock::duration(0));
    while (!isInterrupted() && Clock::now() < due) {
      std::this_thread::sleep_until(std::min(due, Clock::now() + longest_wait));
      meanwhile();
    }
    return late;
  }

private:
  std::optional<Clock::time_point> start_; // time 0
};

} // namespace pcl_ext::tools

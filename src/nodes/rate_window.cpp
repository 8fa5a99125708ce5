// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/rate_window.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::nodes {

Time
systemTime()
{
  return std::chrono::system_clock::now().time_since_epoch();
}

Time
steadyTime()
{
  return std::chrono::steady_clock::now().time_since_epoch();
}

void
RateWindow::add(const CodedFrame& frame)
{
  // If the clock was set back, frames newer than its time would not be removed.
  while (!frames_.empty() && frames_.back().ready > frame.ready)
    frames_.pop_back();
  while (!frames_.empty() &&
         (frames_.front().ready < frame.ready - StreamRates::window ||
          frames_.size() >= most_frames))
    frames_.pop_front();
  frames_.push_back(frame);
}

StreamRates
RateWindow::rates(Time now) const
{
  StreamRates rates;
  std::size_t frames = 0;
  std::size_t bytes_behind_first = 0;
  Time first{0};
  Time last{0};
  for (const CodedFrame& frame : frames_) {
    if (frame.ready < now - StreamRates::window || frame.ready > now)
      continue;
    if (frames++ == 0)
      first = frame.ready;
    else
      bytes_behind_first += frame.bytes;
    last = frame.ready;
    rates.mean_cycle_seconds += frame.cycle_seconds;
    rates.mean_latency_seconds += frame.latency_seconds;
    rates.max_cycle_seconds = std::max(rates.max_cycle_seconds, frame.cycle_seconds);
    rates.max_latency_seconds =
        frames == 1 ? frame.latency_seconds
                    : std::max(rates.max_latency_seconds, frame.latency_seconds);
  }
  if (frames == 0)
    return rates;
  rates.mean_cycle_seconds /= static_cast<double>(frames);
  rates.mean_latency_seconds /= static_cast<double>(frames);
  // From the N - 1 intervals of N frames: divided by the length of the window, the rate
  // of a new stream would be too low.
  if (last > first) {
    const double seconds = std::chrono::duration<double>(last - first).count();
    rates.frames_per_second = static_cast<double>(frames - 1) / seconds;
    rates.bytes_per_second = static_cast<double>(bytes_behind_first) / seconds;
  }
  return rates;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/link_budget.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {

LinkBudget::LinkBudget(double buffer_seconds)
: buffer_(static_cast<std::int64_t>(std::llround(buffer_seconds * 1e9)))
{}

void
LinkBudget::setRate(double bits_per_second)
{
  constexpr double bits_and_nanoseconds = 8e9;
  const double changed = bits_and_nanoseconds / bits_per_second;
  const double waiting =
      static_cast<double>(backlog_.count()) * changed / nanoseconds_per_byte_;
  constexpr double longest = 4e18; // above a second of the highest rate at the lowest
  if (backlog_ > Nanoseconds::zero())
    backlog_ =
        Nanoseconds(static_cast<std::int64_t>(std::ceil(std::min(waiting, longest))));
  nanoseconds_per_byte_ = changed;
}

void
LinkBudget::advance(Nanoseconds elapsed)
{
  time_ += elapsed;
  backlog_ = std::max(backlog_ - elapsed, Nanoseconds::zero());
  while (!frames_.empty() && frames_.front().time <= time_ - window) {
    sum_ -= frames_.front().link_time;
    frames_.pop_front();
  }
}

std::size_t
LinkBudget::bytesIn(Nanoseconds link_time) const
{
  if (link_time <= Nanoseconds::zero())
    return 0;
  const double bytes =
      std::floor(static_cast<double>(link_time.count()) / nanoseconds_per_byte_);
  constexpr double most = 1e15;
  return static_cast<std::size_t>(std::min(bytes, most));
}

std::size_t
LinkBudget::room() const
{
  // The link time of a frame is rounded up, so that it fits if its bytes do.
  return bytesIn(std::min(window - sum_, buffer_ - backlog_));
}

void
LinkBudget::add(std::size_t bytes)
{
  const Nanoseconds link_time(static_cast<std::int64_t>(
      std::ceil(static_cast<double>(bytes) * nanoseconds_per_byte_)));
  sum_ += link_time;
  backlog_ += link_time;
  // Frames without time between them are one, which limits the memory.
  if (!frames_.empty() && frames_.back().time == time_)
    frames_.back().link_time += link_time;
  else
    frames_.push_back({time_, link_time});
}

} // namespace pcl_ext::PCL_EXT_ABI::io

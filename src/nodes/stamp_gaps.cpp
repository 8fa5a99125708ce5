// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/stamp_gaps.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr std::size_t most_intervals = 30;
constexpr std::size_t least_intervals = 10; // of which the period is known
constexpr std::size_t most_gaps = 30;
constexpr std::size_t least_gaps = 12;    // fewer may be whole periods by chance
constexpr double longest_gap = 50.0;      // periods; a longer one is a pause
constexpr double shortest_gap = 1.5;      // periods
constexpr double longest_of_late = 0.5;   // periods, after a cloud that came late
constexpr double most_off_multiple = .15; // periods, by jitter of the stamps

template <typename ValueT>
void
pushBack(std::deque<ValueT>& latest, const ValueT& value, std::size_t most)
{
  latest.push_back(value);
  if (latest.size() > most)
    latest.pop_front();
}

/** \brief The smallest value except for a share of them, 0 to 1. */
Time
quantile(std::vector<Time>& values, double share)
{
  const auto chosen =
      values.begin() +
      static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), chosen, values.end());
  return *chosen;
}

} // namespace

std::size_t
StampGaps::missingBefore(Time stamp)
{
  if (stamp == Time(0))
    return 0;
  const std::optional<Time> previous = std::exchange(last_stamp_, stamp);
  if (!previous)
    return 0;
  const Time interval = stamp - *previous;
  const std::optional<Period> known_period = period();
  const double periods = known_period ? interval / *known_period : 1.0;
  // A clock that was set, a recording that begins anew; a pause, or a much slower
  // sensor.
  if (interval <= Time(0) || periods > longest_gap) {
    intervals_.clear();
    return 0;
  }
  pushBack(intervals_, interval, most_intervals);
  if (periods > shortest_gap)
    return addGap(periods);
  if (periods < longest_of_late && pending_ > 0)
    --pending_;
  return 0;
}

std::size_t
StampGaps::addGap(double periods)
{
  std::size_t missing = 0;
  if (gaps_.size() >= least_gaps) {
    missing = areLosses() ? pending_ : 0;
    pending_ = 0;
  }
  const double whole = std::round(periods);
  const Gap gap{static_cast<std::size_t>(whole) - 1,
                std::abs(periods - whole) <= most_off_multiple};
  pushBack(gaps_, gap, most_gaps);
  pending_ += gap.missing;
  return missing;
}

bool
StampGaps::areLosses() const
{
  const auto multiples = static_cast<std::size_t>(
      std::count_if(gaps_.begin(), gaps_.end(), [](const Gap& gap) {
        return gap.is_multiple_of_period;
      }));
  if (4 * multiples < 3 * gaps_.size())
    return false;
  // If most are alike, the median is one of them.
  std::vector<std::size_t> missing;
  for (const Gap& gap : gaps_)
    missing.push_back(gap.missing);
  const auto middle = missing.begin() + static_cast<std::ptrdiff_t>(missing.size() / 2);
  std::nth_element(missing.begin(), middle, missing.end());
  const std::size_t tolerance = *middle / 8;
  const auto alike = static_cast<std::size_t>(
      std::count_if(missing.begin(), missing.end(), [&](std::size_t clouds) {
        return clouds + tolerance >= *middle && clouds <= *middle + tolerance;
      }));
  return *middle == 1 || 2 * alike <= missing.size();
}

std::optional<StampGaps::Period>
StampGaps::period() const
{
  if (intervals_.size() < least_intervals)
    return std::nullopt;
  // Not the shortest, which jitter may have shortened.
  constexpr double share_without_loss = 1.0 / 7.0;
  std::vector<Time> shortest(intervals_.begin(), intervals_.end());
  const Period longest = shortest_gap * Period(quantile(shortest, share_without_loss));
  shortest.erase(std::remove_if(shortest.begin(),
                                shortest.end(),
                                [&](Time interval) { return interval > longest; }),
                 shortest.end());
  const Period about = quantile(shortest, 0.5);
  // Of all intervals, in which jitter of the stamps cancels out.
  Time time(0);
  double periods = 0.0;
  for (const Time interval : intervals_) {
    time += interval;
    periods += std::round(interval / about);
  }
  return Period(time) / periods;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

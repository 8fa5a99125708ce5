#include "nodes/stamp_gaps.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace nodes {

namespace {

constexpr std::size_t most_intervals = 30;
constexpr std::size_t least_intervals = 10; // of which the period is known
constexpr double most_periods = 50.0;       // of a gap that is no pause

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
  if (interval <= Time(0)) { // a clock that was set, or a recording that begins anew
    intervals_.clear();
    return 0;
  }
  std::size_t missing = 0;
  if (intervals_.size() >= least_intervals) {
    const double periods = std::chrono::duration<double>(interval) / period();
    if (periods > most_periods) { // a pause, or a much slower sensor
      intervals_.clear();
      return 0;
    }
    // Rounded up from .75 on only, as a late cloud is not a lost one.
    missing = static_cast<std::size_t>(std::max(std::floor(periods + 0.25), 1.0)) - 1;
  }
  intervals_.push_back(interval);
  if (intervals_.size() > most_intervals)
    intervals_.pop_front();
  return missing;
}

Time
StampGaps::period() const
{
  std::vector<Time> shortest(intervals_.begin(), intervals_.end());
  const auto chosen =
      shortest.begin() + static_cast<std::ptrdiff_t>((shortest.size() - 1) / 7);
  std::nth_element(shortest.begin(), chosen, shortest.end());
  return *chosen;
}

} // namespace nodes
} // namespace pcl_ext

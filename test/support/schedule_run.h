// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/merge_schedule.h>

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

/** \brief Runs a schedule, and notes what it releases and merges. */
class ScheduleRun {
public:
  explicit ScheduleRun(const MergeScheduleSettings& settings = {}) : schedule_(settings)
  {}

  /** \brief A frame arrives; its bytes are not used. */
  bool
  add(const std::string& stream, Time stamp, Time now)
  {
    return schedule_.add({stream, stamp, {}}, now);
  }

  /** \brief Does all that is to be done at a time.
   * \return the times that were merged
   */
  std::vector<Time>
  work(Time now)
  {
    std::vector<Time> times;
    MergeSchedule::Step step;
    do {
      step = schedule_.next(now);
      for (const ScheduledFrame& frame : step.frames) {
        EXPECT_TRUE(latest_.count(frame.stream) == 0 ||
                    latest_[frame.stream] != frame.stamp);
        latest_[frame.stream] = frame.stamp;
      }
      if (step.merge) {
        times.push_back(*step.merge);
        merged_[*step.merge] = latest_;
        other_clocks_ = step.other_clocks;
      }
    }
    while (step.merge);
    return times;
  }

  /** \brief Of each merged time the stamp of the latest frame of each stream. */
  const std::map<Time, std::map<std::string, Time>>&
  merged() const
  {
    return merged_;
  }

  /** \brief The streams of other clocks that were merged last. */
  const std::set<std::string>&
  otherClocks() const
  {
    return other_clocks_;
  }

  const std::map<std::string, Time>&
  released() const
  {
    return latest_;
  }

  const MergeCounts&
  counts() const
  {
    return schedule_.counts();
  }

  MergeSchedule&
  schedule()
  {
    return schedule_;
  }

private:
  MergeSchedule schedule_;
  std::map<std::string, Time> latest_;
  std::set<std::string> other_clocks_;
  std::map<Time, std::map<std::string, Time>> merged_;
};

/** \brief The first stamp, of the sensors' clock and not of the arrivals'. */
constexpr Time begin = std::chrono::seconds(1'700'000'000);

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/merge_schedule.h>

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

/** \brief The first stamp, of the sensors' clock and not of the arrivals'. */
constexpr Time begin = std::chrono::seconds(1'700'000'000);

/** \brief Runs a schedule, and notes what it releases and merges. */
struct ScheduleRun {
  explicit ScheduleRun(const MergeScheduleSettings& settings = {}) : schedule(settings)
  {}

  /** \brief A frame arrives; its bytes are not used. */
  bool
  add(const std::string& stream, Time stamp, Time now)
  {
    return schedule.add({stream, stamp, {}}, now);
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
      step = schedule.next(now);
      for (const ScheduledFrame& frame : step.frames) {
        EXPECT_TRUE(released.count(frame.stream) == 0 ||
                    released[frame.stream] != frame.stamp);
        released[frame.stream] = frame.stamp;
      }
      if (step.merge) {
        times.push_back(*step.merge);
        merged[*step.merge] = released;
        other_clocks = step.other_clocks;
      }
    }
    while (step.merge);
    return times;
  }

  MergeSchedule schedule;
  std::map<std::string, Time> released;               ///< the last stamps
  std::map<Time, std::map<std::string, Time>> merged; ///< what was released by then
  std::set<std::string> other_clocks; ///< of the streams that were merged last
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/impl/merge_schedule.h>

#include "support/schedule_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace std::chrono_literals;
using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;

TEST(MergeClocks, GoesOnWhenClocksDiffer)
{
  ScheduleRun run;
  for (int i = 0; i < 40; ++i) {
    const Time now = i * 100ms;
    run.add("a", begin + now, now);
    run.add("b", begin + now, now);
    run.add("ahead", begin + now + 1h, now);
    // Not held back, nor waited for.
    const auto times = run.work(now);
    ASSERT_EQ(times, std::vector<Time>{begin + now});
    EXPECT_EQ(run.released.at("ahead"), begin + now + 1h);
  }
  // All clocks are set back, as where a simulation begins anew.
  for (int i = 0; i < 20; ++i) {
    const Time now = 4s + i * 100ms;
    const Time stamp = begin - 1h + now;
    for (const char* const stream : {"a", "b", "ahead"})
      run.add(stream, stamp, now);
    EXPECT_EQ(run.work(now), std::vector<Time>{stamp});
  }
  // They are set forward, but for one, and go at half the speed.
  for (int i = 0; i < 200; ++i) {
    const Time now = 6s + i * 200ms;
    const Time stamp = begin + 1h + i * 100ms;
    for (const char* const stream : {"a", "b", "ahead"})
      run.add(stream, stamp, now);
    run.add("stays", begin + now, now);
    EXPECT_EQ(run.work(now), std::vector<Time>{stamp});
    EXPECT_EQ(run.other_clocks, std::set<std::string>{"stays"});
  }
}

TEST(MergeClocks, GoesOnWithTheStreamsOfAnotherClockWhereTheOthersEnd)
{
  ScheduleRun run;
  Time last(0);
  for (Time now = 0ms; now < 12s; now += 10ms) {
    if (now % 100ms == 0ms) {
      run.add("behind", begin - 1h + now, now);
      for (const char* const stream : {"a", "b", "c"})
        if (now >= 2s && now < 6s)
          run.add(stream, begin + now, now);
    }
    const auto times = run.work(now);
    if (!times.empty())
      last = now;
    // A period; once, until there is no frame of the others, max_wait, too.
    ASSERT_LE(now - last, now > 5900ms && now <= 6200ms ? 300ms : 100ms) << now.count();
    for (const Time time : times)
      if (now >= 2s && now < 7s) {
        EXPECT_LE(std::max(time - begin - now, now - time + begin), 200ms);
      }
  }
  EXPECT_EQ(run.merged.count(begin - 1h + 11s), 1u); // there is no other clock then
}

TEST(MergeClocks, DoesNotGoBackForFramesThatComeLateWhereAnotherClockGoesOn)
{
  ScheduleRun run;
  Time newest(0);
  for (Time now = 0ms; now < 6s; now += 50ms) {
    run.add("behind", begin - 1h + now, now);
    const bool is_pause = now > 2s && now < 3500ms;
    for (const char* const stream : {"a", "b"})
      for (Time sent = now == 3500ms ? 2050ms : now; !is_pause && sent <= now;
           sent += 50ms) {
        run.add(stream, begin + sent, now);
        for (const Time time : run.work(now)) {
          EXPECT_GT(time, newest) << now.count();
          newest = time;
        }
      }
    for (const Time time : run.work(now)) {
      EXPECT_GT(time, newest) << now.count();
      newest = time;
    }
  }
  EXPECT_EQ(newest, begin + 5900ms);
}

TEST(MergeClocks, GoesOnWhenClocksAreSetBackByLittle)
{
  ScheduleRun run;
  const auto send = [&](Time now, Time stamp) {
    for (const char* const stream : {"a", "b"}) {
      run.add(stream, stamp, now);
      run.work(now);
    }
  };
  for (Time now = 0ms; now <= 1950ms; now += 50ms)
    send(now, begin + now);
  EXPECT_EQ(run.merged.size(), 20u);
  run.add("a", begin + 2s, 2s); // held back
  // By less than what makes a clock another one.
  std::vector<Time> times;
  for (Time now = 2050ms; now < 4s; now += 50ms) {
    const Time stamp = begin + now - 1s;
    run.add("a", stamp, now);
    run.add("b", stamp, now);
    const auto merged = run.work(now);
    times.insert(times.end(), merged.begin(), merged.end());
    EXPECT_EQ(run.released.at("a"), stamp);
  }
  ASSERT_EQ(times.size(), 19u);
  for (std::size_t i = 0; i < times.size(); ++i)
    EXPECT_EQ(times[i], begin + 1100ms + 100ms * i);
}

TEST(MergeClocks, TakesFramesOfRepeatedStampsAsTheyArrive)
{
  ScheduleRun none_has_stamps;
  std::vector<Time> times;
  for (Time now = 30s; now <= 31s; now += 50ms) {
    EXPECT_EQ(none_has_stamps.add("a", 0ms, now), now == 30s);
    none_has_stamps.add("b", 0ms, now);
    const auto merged = none_has_stamps.work(now);
    times.insert(times.end(), merged.begin(), merged.end());
  }
  ASSERT_EQ(times.size(), 11u);
  for (std::size_t i = 0; i < times.size(); ++i)
    EXPECT_EQ(times[i], 100ms * i);

  ScheduleRun some_have;
  for (Time now = 0ms; now <= 1s; now += 50ms) {
    for (const char* const stream : {"a", "b"})
      EXPECT_TRUE(some_have.add(stream, begin + now, now));
    some_have.add("always 0", 0ms, now);
    some_have.add("always the first", begin, now);
    const std::vector<Time> expected =
        now % 100ms == 0ms ? std::vector<Time>{begin + now} : std::vector<Time>();
    EXPECT_EQ(some_have.work(now), expected);
    EXPECT_EQ(some_have.released.at("always 0"), now);
    EXPECT_EQ(some_have.other_clocks, std::set<std::string>{"always 0"});
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/impl/merge_schedule.h>

#include "support/schedule_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace {

namespace merge_schedule {

using namespace std::chrono_literals;
using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;

TEST(MergeSchedule, MergesByStampsWhateverTheOrderOfArrival)
{
  struct SentFrame {
    std::string stream;
    Time stamp;
    Time arrival;
  };
  std::mt19937 random(5);
  std::vector<SentFrame> frames;
  const auto delay = [&] { return Time(1ms) * static_cast<int>(random() % 90); };
  // Of other rates and phases, as sensors that are not triggered.
  for (const auto& [stream, period, phase] : {std::tuple("a", 33ms, 3ms),
                                              {"b", 50ms, 0ms},
                                              {"c", 101ms, 40ms},
                                              {"d", 200ms, 199ms}}) {
    Time arrival(0);
    for (Time stamp = begin + phase; stamp < begin + 4s; stamp += period) {
      arrival = std::max(arrival, stamp - begin + delay()); // in the stream's order
      frames.push_back({stream, stamp, arrival});
    }
  }
  std::vector<SentFrame> arrivals = frames;
  std::stable_sort(
      arrivals.begin(), arrivals.end(), [](const SentFrame& a, const SentFrame& b) {
        return a.arrival < b.arrival;
      });
  ScheduleRun run;
  auto next = arrivals.begin();
  for (Time now(0); now < 4s; now += 5ms) {
    for (; next != arrivals.end() && next->arrival <= now; ++next)
      run.add(next->stream, next->stamp, now);
    run.work(now);
  }
  // From the time when all streams are known, until frames end.
  std::size_t compared = 0;
  for (const auto& [time, latest] : run.merged) {
    EXPECT_EQ(time % 100ms, 0ms);
    if (time < begin + 500ms || time > begin + 3500ms)
      continue;
    std::map<std::string, Time> expected;
    for (const SentFrame& frame : frames)
      if (frame.stamp <= time)
        expected[frame.stream] = std::max(expected[frame.stream], frame.stamp);
    EXPECT_EQ(latest, expected) << (time - begin).count();
    ++compared;
  }
  EXPECT_EQ(compared, 31u);
}

TEST(MergeSchedule, WaitsForAStreamThatIsBehindButNotForEver)
{
  ScheduleRun run;
  run.add("a", begin, 0ms);
  run.add("b", begin, 0ms);
  EXPECT_EQ(run.work(0ms), std::vector<Time>{begin});
  run.add("a", begin + 100ms, 100ms);
  EXPECT_TRUE(run.work(100ms).empty());
  run.add("a", begin + 150ms, 150ms);
  EXPECT_TRUE(run.work(299ms).empty());
  EXPECT_EQ(run.released.at("a"), begin + 100ms); // the later one is held back
  EXPECT_EQ(run.work(300ms), std::vector<Time>{begin + 100ms});
  // Too late for its time: it is decoded at once, and part of the next one.
  run.add("b", begin + 100ms, 310ms);
  run.work(310ms);
  EXPECT_EQ(run.released.at("b"), begin + 100ms);
  EXPECT_EQ(run.merged.at(begin + 100ms).at("b"), begin);
  run.add("b", begin + 200ms, 320ms);
  run.add("a", begin + 200ms, 320ms);
  EXPECT_EQ(run.work(320ms), std::vector<Time>{begin + 200ms});
  EXPECT_EQ(run.merged.at(begin + 200ms).at("b"), begin + 200ms);
}

TEST(MergeSchedule, WaitsSinceAFrameArrivedNotSinceTheOneBefore)
{
  ScheduleRun run;
  run.add("dead", begin, 0ms);
  for (Time now = 0ms; now <= 1s; now += 100ms) {
    run.add("a", begin + now, now);
    // 200 ms after each frame, although that dead one is waited for each time.
    const std::vector<Time> expected = now == 0ms ? std::vector<Time>{begin}
                                       : now < 300ms
                                           ? std::vector<Time>()
                                           : std::vector<Time>{begin + now - 200ms};
    EXPECT_EQ(run.work(now), expected) << now.count();
  }
}

TEST(MergeSchedule, MergesEachTimeOnceWhereAPeriodIsLong)
{
  MergeScheduleSettings settings;
  settings.period = 3s;
  ScheduleRun run(settings);
  std::vector<Time> times;
  for (Time now(0); now < 16s; now += 50ms) {
    run.add("a", begin + 2s + now, now);
    if (now >= 600ms)
      run.add("late", begin + 2s + now - 600ms, now);
    for (const Time time : run.work(now)) {
      times.push_back(time - begin);
      EXPECT_EQ(run.merged.at(time).at("a"), time);
      EXPECT_LE(run.merged.at(time).at("late"), time);
    }
  }
  // The first one has the stamp 1 s after that of a multiple of 3 s.
  EXPECT_EQ(times, (std::vector<Time>{4s, 7s, 10s, 13s, 16s}));
}

TEST(MergeSchedule, LosesNoMergedFrameToAPause)
{
  for (const bool is_receiver_paused : {false, true}) {
    ScheduleRun run;
    Time sent = -33ms;
    for (Time now(0); now < 9s; now += 5ms) {
      const bool is_pause = now > 2s && now < 5s;
      for (; !is_pause && sent + 33ms <= now; sent += 33ms)
        for (const char* const stream : {"a", "b", "c"})
          run.add(stream, begin + sent + 33ms, now);
      if (!is_pause || !is_receiver_paused)
        run.work(now);
    }
    for (Time time(0); time < 8900ms; time += 100ms) {
      const Time latest = begin + time / 33ms * 33ms;
      ASSERT_EQ(run.merged.count(begin + time), 1u) << time.count();
      EXPECT_EQ(
          run.merged.at(begin + time),
          (std::map<std::string, Time>{{"a", latest}, {"b", latest}, {"c", latest}}));
    }
    EXPECT_EQ(run.schedule.counts().left_out, 0u);
  }
}

TEST(MergeSchedule, ReleasesNoMoreThanTheCallerTakes)
{
  for (const bool skips_late : {false, true}) {
    MergeScheduleSettings settings{1s};
    settings.skips_late = skips_late;
    settings.max_released = 2;
    MergeSchedule schedule(settings);
    const auto add = [&](Time now) {
      for (Time stamp = now - 900ms; stamp <= now; stamp += 100ms)
        schedule.add({"a", begin + stamp, {}}, now);
    };
    add(1s);
    for (int i = 0; i < 5; ++i) {
      const MergeSchedule::Step step = schedule.next(1s);
      EXPECT_EQ(step.frames.size(), 2u);
      EXPECT_EQ(step.has_more, i < 4);
      EXPECT_EQ(step.merge.has_value(), i == 4);
      if (i < 4) {
        EXPECT_TRUE(schedule.next(1s).frames.empty()); // none is decoded yet
      }
      schedule.countDecoded();
    }
    // A caller that is too slow gets the others to refuse them, unless it has time.
    add(2s);
    EXPECT_EQ(schedule.next(2s).frames.size(), 2u);
    EXPECT_TRUE(schedule.next(5s).frames.empty());
    const MergeSchedule::Step step = schedule.next(5001ms);
    EXPECT_EQ(step.frames.size(), skips_late ? 8u : 0u);
    EXPECT_EQ(step.merge.has_value(), skips_late);
  }
}

TEST(MergeSchedule, DoesNotWaitForAStreamThatHasEnded)
{
  ScheduleRun run;
  run.add("dead", begin, 0ms);
  run.add("a", begin, 0ms);
  run.work(0ms);
  run.add("a", begin + 2000ms, 2000ms);
  EXPECT_TRUE(run.work(2000ms).empty()); // it may be slow
  run.add("a", begin + 2100ms, 2100ms);
  EXPECT_EQ(run.work(2100ms), (std::vector<Time>{begin + 2000ms, begin + 2100ms}));
  // When all have ended, nothing is merged again and again.
  EXPECT_TRUE(run.work(5s).empty());
  EXPECT_TRUE(run.work(50s).empty());
  // What was held back when they ended is not lost.
  run.add("a", begin + 51s, 51s);
  run.add("b", begin + 51s, 51s);
  run.work(51s);
  run.add("a", begin + 51100ms, 51100ms);
  EXPECT_TRUE(run.work(51100ms).empty());
  EXPECT_EQ(run.work(54s), std::vector<Time>{begin + 51100ms});
  // Nor where frames are further apart than streams may be old.
  MergeScheduleSettings settings;
  settings.max_age = 1s;
  ScheduleRun slow(settings);
  slow.add("dead", begin, 0ms);
  for (Time now(0); now < 10s; now += 2500ms) {
    slow.add("a", begin + now, now);
    slow.work(now);
  }
  EXPECT_EQ(slow.merged.count(begin + 7500ms), 1u);
}

/** \brief What a caller got that takes some time for each merged frame. */
struct SlowRun {
  std::size_t frames = 0; ///< released
  std::vector<Time> merged;
  Time largest_delay{0}; ///< from a merged time until it was merged
  MergeCounts counts;
};

SlowRun
runSlowly(Time time_of_merge, bool skips_late)
{
  MergeScheduleSettings settings;
  settings.skips_late = skips_late;
  MergeSchedule schedule(settings);
  SlowRun run;
  Time sent = -50ms;
  for (Time now(0); now < 30s;) {
    while (sent + 50ms <= now) {
      sent += 50ms;
      for (const char* const stream : {"a", "b", "c"})
        schedule.add({stream, begin + sent, {}}, sent);
    }
    const MergeSchedule::Step step = schedule.next(now);
    run.frames += step.frames.size();
    if (!step.merge) {
      now += 5ms;
      continue;
    }
    now += time_of_merge;
    run.merged.push_back(*step.merge - begin);
    run.largest_delay = std::max(run.largest_delay, now - run.merged.back());
  }
  run.counts = schedule.counts();
  return run;
}

TEST(MergeSchedule, LeavesMergedFramesOutWhereTheCallerIsTooSlow)
{
  const SlowRun fast = runSlowly(90ms, true);
  EXPECT_EQ(fast.counts.left_out, 0u);
  EXPECT_EQ(fast.merged.size(), fast.counts.made);
  EXPECT_GE(fast.counts.made, 299u);
  EXPECT_LE(fast.largest_delay, 200ms);
  // A merged frame each 350 ms, of 300 that are due.
  const SlowRun slow = runSlowly(350ms, true);
  EXPECT_EQ(slow.merged.size(), slow.counts.made);
  EXPECT_GE(slow.counts.made, 30'000u / 350);
  const auto due = static_cast<std::size_t>(slow.merged.back() / 100ms) + 1;
  EXPECT_EQ(slow.counts.made + slow.counts.left_out, due);
  EXPECT_GE(slow.frames, 6 * due - 9); // all are decoded
  EXPECT_LE(slow.largest_delay, 2s);
  EXPECT_LE(30s - slow.merged.back(), 1s);
  // It does not fall back to late ones: each is as new as can be.
  const std::vector<Time>& merged = slow.merged;
  for (std::size_t i = merged.size() / 2; i < merged.size(); ++i)
    EXPECT_GE(merged[i] - merged[i - 1], 300ms);
  const SlowRun all = runSlowly(350ms, false);
  EXPECT_EQ(all.counts.left_out, 0u);
  for (std::size_t i = 0; i < all.merged.size(); ++i)
    EXPECT_EQ(all.merged[i], i * 100ms);
}

TEST(MergeSchedule, TakesAnyStamp)
{
  ScheduleRun run;
  for (int i = 0; i < 10; ++i) {
    const Time now = i * 100ms;
    run.add("first", i % 2 == 0 ? Time::min() : Time::max(), now);
    run.add("a", begin + now, now);
    run.add("b", begin + now, now);
    run.work(now);
    EXPECT_EQ(run.merged.count(begin + now), 1u);
  }
  ScheduleRun alone;
  alone.add("a", Time::min(), 0ms);
  alone.work(0ms);
  alone.add("a", Time::max(), 100ms);
  alone.work(100ms);
  alone.work(5s);
  EXPECT_EQ(alone.released.size(), 1u);
}

TEST(MergeSchedule, MergesByTheStampsOfAllTimesOfALink)
{
  constexpr Time last{std::int64_t{1} << 62};
  for (const Time first : {-2'000'000'000s, 0s, 4'000'000'000s}) {
    ScheduleRun run;
    for (Time now = 0ms; now <= 1s; now += 100ms) {
      for (const char* const stream : {"a", "b"})
        EXPECT_TRUE(run.add(stream, first + now, now));
      EXPECT_EQ(run.work(now), std::vector<Time>{first + now});
    }
  }
  ScheduleRun run;
  EXPECT_TRUE(run.add("a", last - 1ns, 0ms));
  EXPECT_TRUE(run.add("a", last, 100ms));
}

TEST(MergeSchedule, MergesWhatIsThereAtTheEnd)
{
  struct Case {
    Time period;
    Time max_wait;
    Time last_of_b; // "a" has frames until 900 ms
    std::vector<Time> merged;
  };
  for (const Case& test : {Case{100ms, 200ms, 900ms, {}},
                           Case{100ms, 10s, 700ms, {800ms, 900ms}},
                           Case{400ms, 10s, 900ms, {1200ms}},
                           Case{10s, 200ms, 900ms, {10s}},
                           Case{1h, 10s, 500ms, {1h}}}) {
    MergeScheduleSettings settings;
    settings.period = test.period;
    settings.max_wait = test.max_wait;
    ScheduleRun run(settings);
    constexpr Time day = 24h * 1000;
    for (Time now = 100ms; now < 1s; now += 100ms) {
      run.add("a", day + now, now);
      if (now <= test.last_of_b)
        run.add("b", day + now, now);
      run.work(now);
    }
    run.schedule.end();
    std::vector<Time> merged;
    for (const Time time : run.work(1s))
      merged.push_back(time - day);
    EXPECT_EQ(merged, test.merged);
    EXPECT_EQ(
        run.merged.rbegin()->second,
        (std::map<std::string, Time>{{"a", day + 900ms}, {"b", day + test.last_of_b}}));
    run.schedule.leaveOutRest();
    EXPECT_EQ(run.schedule.counts().left_out, 0u);
  }
}

TEST(MergeSchedule, MergesTheNewestFramesAtTheEndHoweverLongThePeriodIs)
{
  MergeScheduleSettings settings;
  settings.period = 1h;
  MergeSchedule schedule(settings);
  constexpr Time first = 24h * 1000 + 1min;
  schedule.add({"a", first, {}}, 0s);
  schedule.add({"a", first + 10s, {}}, 10s);
  EXPECT_FALSE(schedule.next(10s).merge);
  schedule.end();
  const MergeSchedule::Step step = schedule.next(10s);
  EXPECT_EQ(step.merge, 24h * 1000 + 1h);
  EXPECT_EQ(step.oldest, first + 10s - settings.max_age);
}

TEST(MergeSchedule, TellsWhichSettingIsWrong)
{
  EXPECT_EQ(faultOf({}), "");
  EXPECT_EQ(faultOf({500us, 0ms}), "period is 0 ms; it must be 1 ms to 1 hour");
  EXPECT_EQ(faultOf({2h, 0ms}), "period is 7200000 ms; it must be 1 ms to 1 hour");
  EXPECT_EQ(faultOf({1s, 0ms, 0ms}), "max_age is 0 ms; it must be 1 ms to 1 hour");
  EXPECT_EQ(faultOf({1s, -1ms}), "max_wait is -1 ms; it must be 0 to 1 hour");
}

} // namespace merge_schedule

} // namespace

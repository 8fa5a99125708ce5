// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/rate_window.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <vector>

namespace {

using namespace std::chrono_literals;
using pcl_ext::nodes::RateWindow;
using pcl_ext::nodes::StreamRates;
using pcl_ext::nodes::Time;

RateWindow::CodedFrame
frameAt(Time ready, std::size_t bytes = 100, double cycle = 0.01, double latency = 0.02)
{
  return {ready, bytes, cycle, latency};
}

void
expectRates(const StreamRates& rates, const StreamRates& expected)
{
  EXPECT_DOUBLE_EQ(rates.frames_per_second, expected.frames_per_second);
  EXPECT_DOUBLE_EQ(rates.bytes_per_second, expected.bytes_per_second);
  EXPECT_DOUBLE_EQ(rates.mean_cycle_seconds, expected.mean_cycle_seconds);
  EXPECT_DOUBLE_EQ(rates.max_cycle_seconds, expected.max_cycle_seconds);
  EXPECT_DOUBLE_EQ(rates.mean_latency_seconds, expected.mean_latency_seconds);
  EXPECT_DOUBLE_EQ(rates.max_latency_seconds, expected.max_latency_seconds);
}

void
expectNothing(const StreamRates& rates)
{
  expectRates(rates, StreamRates());
}

TEST(RateWindow, RatesAndMeansAreOfTheFramesInTheWindow)
{
  struct Case {
    const char* name;
    std::vector<RateWindow::CodedFrame> frames;
    Time now;
    StreamRates expected;
  };
  const std::vector<Case> cases = {
      {"nothing", {}, 1700000000s, {}},
      {"one frame has no rate",
       {frameAt(5s, 1000, 0.25, 0.5)},
       5s,
       {0.0, 0.0, 0.25, 0.25, 0.5, 0.5}},
      // Five frames a second would come of the first second, two of the window.
      // Bytes are those of the frames after the spaces.
      {"rates come from the spaces between frames",
       {frameAt(10000ms, 5000, 0.1, 0.3),
        frameAt(10250ms, 100, 0.4, 0.2),
        frameAt(10500ms, 300, 0.1, 0.7)},
       10900ms,
       {4.0, 800.0, 0.2, 0.4, 0.4, 0.7}},
      {"frames of one moment have no rate",
       {frameAt(1s, 100, 0.1), frameAt(1s, 100, 0.3)},
       1s,
       {0.0, 0.0, 0.2, 0.3, 0.02, 0.02}},
      {"latencies of a clock that is behind are negative",
       {frameAt(1s, 100, 0.1, -0.75), frameAt(2s, 100, 0.1, -0.25)},
       2s,
       {1.0, 100.0, 0.1, 0.1, -0.5, -0.25}},
      {"as of a moment before all frames", {frameAt(1s), frameAt(2s)}, 999ms, {}},
      {"as of a moment before the last frame",
       {frameAt(1000ms), frameAt(1500ms), frameAt(2000ms)},
       1500ms,
       {2.0, 200.0, 0.01, 0.01, 0.02, 0.02}}};
  for (const Case& of_frames : cases) {
    SCOPED_TRACE(of_frames.name);
    RateWindow window;
    for (const RateWindow::CodedFrame& frame : of_frames.frames)
      window.add(frame);
    expectRates(window.rates(of_frames.now), of_frames.expected);
  }
}

TEST(RateWindow, FramesCountUntilTheyAreOlderThanTheWindow)
{
  RateWindow window;
  window.add(frameAt(1s, 100, 0.5));
  window.add(frameAt(2s, 100, 0.1));
  window.add(frameAt(3s, 100, 0.1));
  EXPECT_DOUBLE_EQ(window.rates(3s).max_cycle_seconds, 0.5);
  EXPECT_DOUBLE_EQ(window.rates(3s).frames_per_second, 1.0);
  EXPECT_DOUBLE_EQ(window.rates(3s + 1ns).max_cycle_seconds, 0.1);
  EXPECT_DOUBLE_EQ(window.rates(3s + 1ns).frames_per_second, 1.0);
  EXPECT_EQ(window.rates(4s + 1ns).frames_per_second, 0.0);
  EXPECT_DOUBLE_EQ(window.rates(5s).mean_cycle_seconds, 0.1);
  expectNothing(window.rates(5s + 1ns));
}

TEST(RateWindow, AddingAFrameRemovesOldOnes)
{
  RateWindow window;
  window.add(frameAt(1s, 100, 0.5));
  window.add(frameAt(3s + 1ns, 100, 0.1));
  // As of then the first would count.
  EXPECT_EQ(window.rates(3s).max_cycle_seconds, 0.0);
  EXPECT_DOUBLE_EQ(window.rates(3s + 1ns).max_cycle_seconds, 0.1);
}

TEST(RateWindow, AClockSetBackRestartsTheWindow)
{
  RateWindow window;
  window.add(frameAt(1000s, 100, 0.9));
  window.add(frameAt(1001s, 100, 0.9));
  window.add(frameAt(10s));
  window.add(frameAt(11s));
  EXPECT_DOUBLE_EQ(window.rates(11s).frames_per_second, 1.0);
  EXPECT_DOUBLE_EQ(window.rates(11s).max_cycle_seconds, 0.01);
  // Nor do they come back when their time comes again.
  expectNothing(window.rates(1001s));
}

TEST(RateWindow, AClockSetBackALittleForgetsLaterFrames)
{
  RateWindow window;
  window.add(frameAt(10000ms));
  window.add(frameAt(11000ms, 100, 0.9));
  window.add(frameAt(10500ms));
  window.add(frameAt(10750ms));
  for (const Time now : {10750ms, 11000ms}) {
    const StreamRates rates = window.rates(now);
    EXPECT_DOUBLE_EQ(rates.frames_per_second, 2.0 / 0.75);
    EXPECT_DOUBLE_EQ(rates.bytes_per_second, 200.0 / 0.75);
    EXPECT_DOUBLE_EQ(rates.max_cycle_seconds, 0.01);
  }
}

TEST(RateWindow, MemoryIsBoundedWhileTheClockStands)
{
  RateWindow window;
  window.add(frameAt(1s, 100, 100.0));
  for (int i = 0; i < 10000; ++i)
    window.add(frameAt(1s, 100, 1.0));
  EXPECT_DOUBLE_EQ(window.rates(1s).max_cycle_seconds, 1.0);
  EXPECT_DOUBLE_EQ(window.rates(1s).mean_cycle_seconds, 1.0);
}

} // namespace

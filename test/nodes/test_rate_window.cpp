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

/** \brief Frames that are added to a window, and the rates as of a moment. */
struct RatesCase {
  const char* name;
  std::vector<RateWindow::CodedFrame> frames;
  Time now;
  StreamRates expected;
};

void
expectRates(const std::vector<RatesCase>& cases)
{
  for (const RatesCase& of_frames : cases) {
    SCOPED_TRACE(of_frames.name);
    RateWindow window;
    for (const RateWindow::CodedFrame& frame : of_frames.frames)
      window.add(frame);
    expectRates(window.rates(of_frames.now), of_frames.expected);
  }
}

TEST(RateWindow, RatesAndMeansAreOfTheFramesInTheWindow)
{
  expectRates(
      {{"nothing", {}, 1700000000s, {}},
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
        {2.0, 200.0, 0.01, 0.01, 0.02, 0.02}}});
}

TEST(RateWindow, FramesCountUntilTheyAreOlderThanTheWindow)
{
  const std::vector<RateWindow::CodedFrame> three = {
      frameAt(1s, 100, 0.5), frameAt(2s, 100, 0.1), frameAt(3s, 100, 0.1)};
  const std::vector<RateWindow::CodedFrame> set_back = {
      frameAt(1000s, 100, 0.9), frameAt(1001s, 100, 0.9), frameAt(10s), frameAt(11s)};
  const std::vector<RateWindow::CodedFrame> set_back_a_little = {
      frameAt(10000ms), frameAt(11000ms, 100, 0.9), frameAt(10500ms), frameAt(10750ms)};
  // The window has two seconds.
  expectRates(
      {{"all of them", three, 3s, {1.0, 100.0, 0.7 / 3, 0.5, 0.02, 0.02}},
       {"two", three, 3s + 1ns, {1.0, 100.0, 0.1, 0.1, 0.02, 0.02}},
       {"one has no rate", three, 4s + 1ns, {0.0, 0.0, 0.1, 0.1, 0.02, 0.02}},
       {"the last one", three, 5s, {0.0, 0.0, 0.1, 0.1, 0.02, 0.02}},
       {"none", three, 5s + 1ns, {}},
       // Adding a frame removes old ones: as of 3 s the first would count.
       {"removed", {frameAt(1s, 100, 0.5), frameAt(3s + 1ns, 100, 0.1)}, 3s, {}},
       {"not the new one",
        {frameAt(1s, 100, 0.5), frameAt(3s + 1ns, 100, 0.1)},
        3s + 1ns,
        {0.0, 0.0, 0.1, 0.1, 0.02, 0.02}},
       // Those of before do not come back when their time comes again.
       {"a clock that was set back",
        set_back,
        11s,
        {1.0, 100.0, 0.01, 0.01, 0.02, 0.02}},
       {"the time of before", set_back, 1001s, {}},
       {"a clock that was set back a little, before",
        set_back_a_little,
        10750ms,
        {2.0 / 0.75, 200.0 / 0.75, 0.01, 0.01, 0.02, 0.02}},
       {"a clock that was set back a little, after",
        set_back_a_little,
        11000ms,
        {2.0 / 0.75, 200.0 / 0.75, 0.01, 0.01, 0.02, 0.02}}});
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

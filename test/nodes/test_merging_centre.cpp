// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A centre that checks, denoises and merges streams; to be run under
 * ThreadSanitizer, too.
 */
#include "support/tested_centre.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace merging_centre {

using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using namespace std::chrono_literals;
using Voxels = pcl_ext::test::WorldVoxels;

/** \brief Settings of a centre that works when it is told to.
 * \param[in] turn of its work
 */
MergingCentreSettings
settingsOf(const std::optional<Time>& turn)
{
  MergingCentreSettings settings;
  settings.node = centralSettings();
  settings.has_thread = false;
  settings.turn = turn;
  return settings;
}

TEST(MergingCentre, ForgetsStreamsThatAreRemoved)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  TestedCentre centre(now);
  for (const char* const name : {"a", "b"}) {
    ASSERT_TRUE(centre->addStream(name).ok());
    ASSERT_TRUE(centre->receive(name, stream.frames[0], first_stamp).ok());
  }
  expectCode(centre->addStream("a"), CentralNodeCode::StreamExists);
  centre->work();
  const Voxels both = centre.merged.at(first_stamp);
  ASSERT_TRUE(centre->removeStream("a").ok());
  expectCode(centre->removeStream("a"), CentralNodeCode::UnknownStream);
  expectCode(centre->receive("a", stream.frames[1], first_stamp),
             CentralNodeCode::UnknownStream);
  now = 100ms;
  ASSERT_TRUE(centre->receive("b", stream.frames[1], first_stamp + 100ms).ok());
  centre->work(); // does not wait for it
  ASSERT_EQ(centre.merged.count(first_stamp + 100ms), 1u);
  EXPECT_EQ(centre.merged.at(first_stamp + 100ms).size(), stream.decoded[1].size());
  EXPECT_EQ(centre->describeHealth(0).size(), 2u); // and all streams
  // It may come back, and begins anew.
  ASSERT_TRUE(centre->addStream("a").ok());
  EXPECT_EQ(reportOf(centre, "a").message(), "No frames have arrived yet");
}

TEST(MergingCentre, HasNoiseOfAllStreamsAndOfOne)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  TestedCentre centre(now);
  centre->setMerging(false);
  centre->setNoise({{"min_intensity", 2.0}});
  ASSERT_TRUE(centre->addStream("a").ok());
  ASSERT_TRUE(centre->addStream("b").ok());
  centre->setNoise("b", {{"min_intensity", 4.0}});
  const auto kept = [&](const std::string& name, std::size_t number) {
    EXPECT_TRUE(centre->receive(name, stream.frames[number], first_stamp).ok());
    centre->node().waitUntilDecoded();
    VoxelFrame voxels;
    EXPECT_TRUE(centre->node().latestVoxels(name, voxels));
    return voxels.size();
  };
  const auto expected = [&](std::size_t number, float least) {
    std::size_t count = 0;
    pcl_ext::io::forEachVoxelCentre(
        stream.decoded[number],
        [&](float, float, float, float intensity) { count += intensity >= least; });
    return count;
  };
  ASSERT_GT(expected(0, 2.0f), expected(0, 4.0f));
  ASSERT_GT(expected(1, 3.0f), expected(1, 4.0f));
  EXPECT_EQ(kept("a", 0), expected(0, 2.0f));
  EXPECT_EQ(kept("b", 0), expected(0, 4.0f));
  centre->setNoise({{"min_intensity", 3.0}});
  EXPECT_EQ(kept("a", 1), expected(1, 3.0f));
  EXPECT_EQ(kept("b", 1), expected(1, 4.0f));
  centre->setNoise("b", {});
  EXPECT_EQ(kept("b", 2), expected(2, 3.0f));
}

TEST(MergingCentre, TellsOfRepeatedStamps)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  TestedCentre centre(now);
  ASSERT_TRUE(centre->addStream("a").ok());
  for (std::size_t i = 0; i < 3; ++i) {
    now = 100ms * i;
    ASSERT_TRUE(centre->receive("a", stream.frames[i], first_stamp).ok());
    centre->work();
    EXPECT_EQ(centre.merged.size(), 1 + i);
  }
  EXPECT_EQ(centre->stampsRepeated("a"), 2u);
  EXPECT_EQ(reportOf(centre, "a").message(),
            "Frames have the stamp of the one before: they are merged as they arrive");
  EXPECT_EQ(reportOf(centre, "a").message(), "OK"); // since then
}

TEST(MergingCentre, DecodesAtOnceWhatNobodyWantsMerged)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  TestedCentre centre(now);
  ASSERT_TRUE(centre->addStream("a").ok());
  ASSERT_TRUE(centre->addStream("behind").ok());
  ASSERT_TRUE(centre->receive("behind", stream.frames[0], first_stamp).ok());
  for (std::size_t i = 0; i < 4; ++i)
    ASSERT_TRUE(centre->receive("a", stream.frames[i], first_stamp + 100ms * i).ok());
  centre->work();
  centre->node().waitUntilDecoded();
  EXPECT_EQ(centre->node().health()[0].frames_decoded, 2u);
  // What was held back comes first, in its order.
  centre->setMerging(false);
  ASSERT_TRUE(centre->receive("a", stream.frames[4], first_stamp + 400ms).ok());
  centre->node().waitUntilDecoded();
  EXPECT_EQ(centre->node().health()[0].frames_decoded, 5u);
  EXPECT_EQ(centre->node().health()[0].frames_lost, 0u);
}

TEST(MergingCentre, MergesByItself)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  TestedCentre centre(now, true);
  ASSERT_TRUE(centre->addStream("a").ok());
  ASSERT_TRUE(centre->receive("a", stream.frames[0], first_stamp).ok());
  std::vector<TestedCentre::Sent> sent;
  while (sent.empty()) // ctest ends it
    sent = centre.takeSent();
  EXPECT_EQ(sent[0].time, first_stamp);
}

TEST(MergingCentre, WorkDoesNotWaitIfItNeedNot)
{
  const CodedStream stream({});
  Gate gate;
  std::vector<Time> merged;
  MergingCentre centre(
      settingsOf(0s),
      [&](const ReceivedFrame&) { gate.pass(); },
      [&](const MergedFrame& frame) { merged.push_back(frame.time); });
  centre.setMerging(true);
  ASSERT_TRUE(centre.addStream("a").ok());
  for (std::size_t i = 0; i < 2; ++i)
    ASSERT_TRUE(centre.receive("a", stream.frames[i], first_stamp + 100ms * i).ok());
  centre.work();
  gate.waitForArrivals(1);
  centre.work();
  EXPECT_TRUE(merged.empty()); // its frame is being decoded
  gate.open();
  // One at a time, and both in their order.
  for (std::size_t i = 1; i <= 2; ++i) {
    while (merged.size() < i) // ctest ends it
      centre.work();
    EXPECT_EQ(merged.size(), i);
  }
  EXPECT_EQ(merged[1], first_stamp + 100ms);
  EXPECT_EQ(centre.mergeCounts().made, 2u);
  EXPECT_EQ(centre.mergeCounts().left_out, 0u);
}

TEST(MergingCentre, MergesAllThatIsDueInOneTurn)
{
  const CodedStream stream = streamOf(30, 20);
  std::vector<Time> merged;
  MergingCentre centre(settingsOf(1h), {}, [&](const MergedFrame& frame) {
    merged.push_back(frame.time);
  });
  centre.setMerging(true);
  ASSERT_TRUE(centre.addStream("a").ok());
  for (std::size_t i = 0; i < stream.frames.size(); ++i)
    ASSERT_TRUE(centre.receive("a", stream.frames[i], first_stamp + 100ms * i).ok());
  centre.work();
  ASSERT_EQ(merged.size(), stream.frames.size());
  EXPECT_EQ(merged.back(), first_stamp + 100ms * (stream.frames.size() - 1));
  EXPECT_EQ(centre.mergeCounts().left_out, 0u);
}

TEST(MergingCentre, MergesOrCountsWhatIsThereAtTheEnd)
{
  const CodedStream stream({});
  for (const bool has_time : {true, false}) {
    TestTime now{Time(0)};
    MergingCentreSettings settings = settingsOf(0s);
    settings.arrival_clock = [&now] { return now.load(); };
    Gate gate;
    std::vector<Time> merged;
    MergingCentre centre(
        settings,
        [&](const ReceivedFrame&) { gate.pass(); },
        [&](const MergedFrame& frame) { merged.push_back(frame.time); });
    centre.setMerging(true);
    for (const char* const name : {"a", "behind"})
      ASSERT_TRUE(centre.addStream(name).ok());
    ASSERT_TRUE(centre.receive("behind", stream.frames[0], first_stamp).ok());
    for (std::size_t i = 0; i < 4; ++i)
      ASSERT_TRUE(centre.receive("a", stream.frames[i], first_stamp + 100ms * i).ok());
    if (has_time)
      gate.open();
    centre.finish(has_time ? std::nullopt : std::optional(Time(0)));
    EXPECT_EQ(merged.size(), has_time ? 4u : 0u);
    EXPECT_EQ(centre.mergeCounts().made, has_time ? 4u : 0u);
    EXPECT_EQ(centre.mergeCounts().left_out, has_time ? 0u : 4u);
    gate.open();
  }
}

TEST(MergingCentre, RefusesNoFrameOfABurst)
{
  const CodedStream stream = streamOf(30, 20);
  for (const bool waits : {false, true}) {
    MergingCentreSettings settings =
        settingsOf(waits ? MergingCentreSettings().turn : std::optional(Time(0)));
    settings.node.max_waiting_frames = 3;
    std::atomic<std::size_t> merged{0};
    MergingCentre centre(settings, {}, [&](const MergedFrame&) { ++merged; });
    centre.setMerging(true);
    for (const char* const name : {"late", "a"})
      ASSERT_TRUE(centre.addStream(name).ok());
    ASSERT_TRUE(centre.receive("a", stream.frames[0], first_stamp).ok());
    while (merged == 0) // ctest ends it
      centre.work();
    for (std::size_t i = 0; i < stream.frames.size(); ++i)
      ASSERT_TRUE(
          centre.receive("late", stream.frames[i], first_stamp - 1s + 1ms * i).ok());
    while (centre.node().health()[1].frames_decoded < stream.frames.size())
      centre.work();
    EXPECT_EQ(centre.node().health()[1].frames_refused, 0u);
  }
}

TEST(MergingCentre, StreamsComeAndGoWhileFramesArrive)
{
  const CodedStream stream = streamOf(30, 5);
  std::atomic<std::size_t> merged{0};
  MergingCentreSettings settings;
  settings.node = centralSettings();
  settings.schedule.period = 10ms;
  MergingCentre centre(settings, {}, [&](const MergedFrame& frame) {
    merged += frame.status.ok() ? 1 : 0;
  });
  centre.setMerging(true);
  ASSERT_TRUE(centre.addStream("stays").ok());
  std::atomic<bool> is_over{false};
  std::vector<std::thread> threads;
  for (const char* const name : {"stays", "a", "b"})
    threads.emplace_back([&, name] {
      for (std::size_t i = 0; merged < 20 || i < stream.frames.size(); ++i) {
        const std::size_t number = i % stream.frames.size();
        centre.receive(
            name, stream.frames[number], first_stamp + 10ms * i); // or unknown
        std::this_thread::sleep_for(1ms);
      }
    });
  std::thread others([&] {
    while (!is_over)
      for (const char* const name : {"a", "b"}) {
        centre.addStream(name);
        centre.setNoise(name, {{"min_intensity", 2.0}});
        centre.setSources(name, first_stamp, {{"source", first_stamp, 1}});
        centre.describeHealth(0);
        centre.setMerging(false);
        centre.setMerging(true);
        centre.removeStream(name);
      }
  });
  for (std::thread& thread : threads)
    thread.join();
  is_over = true;
  others.join();
  EXPECT_GE(merged, 20u);
}

TEST(MergingCentre, TellsWhichSettingIsWrong)
{
  MergingCentreSettings settings;
  settings.schedule.period = 0ms;
  MergingCentre wrong(settings, {}, {});
  expectCode(wrong.settingsStatus(), CentralNodeCode::InvalidSettings);
  EXPECT_EQ(wrong.settingsStatus().message(),
            "period is 0 ms; it must be 1 ms to 1 hour");
  expectCode(wrong.addStream("a"), CentralNodeCode::InvalidSettings);
  settings.schedule.period = 1s;
  settings.node.resolution = 0.0;
  EXPECT_EQ(MergingCentre(settings, {}, {}).settingsStatus().message(),
            "resolution is 0; it must be 1e-06 to 1e+06 m");
}

} // namespace merging_centre

} // namespace

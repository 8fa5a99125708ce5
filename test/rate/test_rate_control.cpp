// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "rate/rate_control.h"
#include "support/rated_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <tuple>
#include <utility>

namespace {

namespace rate_control {

using namespace pcl_ext::io;
using namespace std::chrono_literals;
using pcl_ext::io::test::CloudCost;
using pcl_ext::io::test::RatedStream;

constexpr double max_rate = 1e6;              // bits a second
constexpr double bytes_of_all = 1e6 / 8 / 10; // of each of 10 frames a second

EncoderSettings
limitedSettings()
{
  EncoderSettings settings;
  settings.max_rate = max_rate;
  settings.effort = Effort::Balanced; // that of CloudCost
  return settings;
}

EncoderSettings
timedSettings(double max_encode_ms)
{
  EncoderSettings settings;
  settings.max_encode_ms = max_encode_ms;
  settings.effort = Effort::Balanced;
  return settings;
}

/** \brief A P-frame that takes a share of the rate at 10 Hz, without I-frames. */
CloudCost
share(double of_rate)
{
  return {of_rate * bytes_of_all, 1.0};
}

TEST(RateControl, WhatFitsStaysAsItIs)
{
  RatedStream stream(limitedSettings());
  EXPECT_EQ(stream.sendFor(600s, share(0.9)), 6000u);
  EXPECT_TRUE(stream.status().is_on);
  EXPECT_EQ(stream.status().changes, 0u);
  EXPECT_NEAR(stream.status().used_rate, 0.9 * max_rate, 0.03 * max_rate);
  // Whatever there is without a budget.
  RatedStream unlimited(EncoderSettings{});
  EXPECT_EQ(unlimited.sendFor(30s, {1e9, 1e5}), 300u);
  EXPECT_FALSE(unlimited.status().is_on);
  EXPECT_EQ(unlimited.status().changes, 0u);
  EXPECT_EQ(unlimited.status().clouds_left_out, 0u);
  EXPECT_EQ(unlimited.status().not_kept, "");
  EXPECT_EQ(unlimited.status().reason, "at the start of the stream");
}

TEST(RateControl, TheFirstPFrameIsTriedAsItMayBeSmall)
{
  RateControl control(limitedSettings(), true, false, std::nullopt);
  const auto encode = [&control](std::size_t bytes, bool is_i_frame) {
    return control.endFrame(bytes, is_i_frame, 1ms, VoxelGrid(), SensorMotion::Unknown);
  };
  // Of 31,250 bytes of the buffer 12,500 still wait when the second cloud comes.
  EXPECT_TRUE(control.beginCloud(0ms, true));
  EXPECT_TRUE(encode(25'000, true));
  EXPECT_TRUE(control.beginCloud(100ms, false));
  EXPECT_TRUE(encode(8'000, false));
  EXPECT_TRUE(control.beginCloud(200ms, false));
  EXPECT_TRUE(encode(8'000, false));
  EXPECT_EQ(control.status().changes, 0u);
  EXPECT_EQ(control.status().clouds_left_out, 0u);
}

TEST(RateControl, AnOverloadIsEndedWithinTwoSecondsAndTheStepTakenBackLater)
{
  for (const double load : {1.2, 2.0, 3.0, 5.0, 20.0, 50.0}) {
    SCOPED_TRACE(load);
    RatedStream stream(limitedSettings());
    stream.sendFor(10s, share(0.5));
    EXPECT_EQ(stream.status().step_number, 0u);
    stream.sendFor(2s, share(load));
    EXPECT_GT(stream.status().step_number, 0u);
    // Of the overload's next 30 seconds hardly a cloud is left out.
    EXPECT_GE(stream.sendFor(30s, share(load)), 290u);
    EXPECT_EQ(stream.status().not_kept, "");
    EXPECT_GE(stream.sendFor(180s, share(0.5)), 1795u);
    EXPECT_EQ(stream.status().step_number, 0u);
    EXPECT_EQ(stream.status().resolution, 0.01);
  }
}

TEST(RateControl, NoContentTakesMoreThanTheRate)
{
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    RatedStream stream(limitedSettings());
    std::lognormal_distribution<double> bytes(std::log(0.5 * bytes_of_all), 1.5);
    std::exponential_distribution<double> seconds(10.0);
    std::uniform_int_distribution<int> percent(0, 99);
    RatedStream::Nanoseconds stamp = 1000s;
    RatedStream::Nanoseconds latest = stamp;
    for (int i = 0; i < 3000; ++i) {
      const int kind = percent(random);
      if (kind == 0)
        stamp += 200s;
      else if (kind == 1)
        stamp -= 200s; // it begins again, as a recording that is repeated
      else if (kind < 20)
        stamp -= 30ms; // out of order
      else if (kind > 30)
        stamp +=
            RatedStream::Nanoseconds(static_cast<std::int64_t>(1e9 * seconds(random)));
      if (stamp > latest)
        stream.link().advance(stamp - latest);
      latest = kind == 1 ? stamp : std::max(stamp, latest);
      stream.sendAt(stamp, {bytes(random), 1.0});
      ASSERT_FALSE(::testing::Test::HasFailure()) << seed << ' ' << i;
    }
    EXPECT_GT(stream.link().frames(), 300u);
  }
}

TEST(RateControl, StampsOfAnySizeAreTimes)
{
  RateControl control(limitedSettings());
  constexpr auto last = std::chrono::nanoseconds::max();
  std::size_t frames = 0;
  for (int i = 0; i < 20; ++i)
    for (const auto stamp : {last, -last, 0ns, last - 1ns})
      if (control.beginCloud(stamp, frames == 0))
        frames += control.endFrame(100, frames == 0, 1ms, VoxelGrid()) ? 1 : 0;
  // As fast as these clouds come they are too many, but some always find room.
  EXPECT_GT(frames, 20u);
}

TEST(RateControl, RepeatedStampsCountAsClouds)
{
  // Each stamp twice: 20 clouds a second.
  RatedStream stream(limitedSettings());
  for (int i = 0; i < 600; ++i)
    stream.send(i % 2 * 100ms, share(0.8));
  EXPECT_GT(stream.status().step_number, 0u);
  EXPECT_LT(stream.status().clouds_left_out, 60u);
}

TEST(RateControl, ContentThatHardlyFitsABetterStepHasFewChanges)
{
  for (const double load : {0.9, 1.1}) {
    SCOPED_TRACE(load);
    RatedStream stream(limitedSettings());
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> noise(0.85, 1.05);
    stream.sendFor(20s, share(3.0));
    const RateControlStatus before = stream.status();
    for (int i = 0; i < 6000; ++i)
      stream.send(100ms, share(load * noise(random)));
    const RateControlStatus status = stream.status();
    EXPECT_LE(status.changes - before.changes, 8u);
    EXPECT_LE(status.clouds_left_out - before.clouds_left_out, 30u);
    EXPECT_LE(status.step_number, 1u);
    EXPECT_EQ(status.not_kept, "");
  }
}

TEST(RateControl, APauseSaysNothingOfTheLoad)
{
  RatedStream stream(limitedSettings());
  stream.sendFor(300s, share(2.0));
  const RateControlStatus before = stream.status();
  for (int i = 0; i < 5; ++i) {
    stream.send(10min, share(2.0));
    stream.sendFor(1s, share(2.0));
  }
  EXPECT_EQ(stream.status().changes, before.changes);
  EXPECT_EQ(stream.status().clouds_left_out, before.clouds_left_out);
}

TEST(RateControl, ContentThatAlternatesHasFewChanges)
{
  RatedStream stream(limitedSettings());
  for (int i = 0; i < 100; ++i) {
    stream.sendFor(3s, share(2.0));
    stream.sendFor(3s, share(0.3));
  }
  EXPECT_LE(stream.status().changes, 60u);
}

TEST(RateControl, ARateThatCannotBeKeptIsSaidAndKeptByLeavingOut)
{
  RatedStream stream(limitedSettings());
  // Far more than the buffer on any step.
  stream.sendFor(10s, share(1000.0));
  EXPECT_EQ(stream.link().frames(), 0u);
  EXPECT_LE(stream.encoded(), 20u); // others would be encoded in vain
  const RateControlStatus status = stream.status();
  EXPECT_EQ(status.step_number, status.last_step);
  EXPECT_EQ(status.clouds_left_out, 100u);
  EXPECT_EQ(status.not_kept.rfind("clouds are left out, as frames take ", 0), 0u)
      << status.not_kept;
  stream.sendFor(10s, share(0.5));
  EXPECT_EQ(stream.sendFor(10s, share(0.5)), 100u);
  EXPECT_EQ(stream.status().not_kept, "");
}

TEST(RateControl, AStepWhoseFramesExceedTheWholeBufferIsLeftAtOnce)
{
  // Of a buffer of 31,250 bytes: the third doubling, which is guessed to take far
  // fewer, is 2 % above it, and the fourth fits.
  constexpr std::array<std::size_t, 5> bytes = {120000, 80000, 50000, 31900, 28000};
  RateControl control(limitedSettings());
  std::size_t clouds = 1;
  for (; control.beginCloud(clouds * 100ms, true); ++clouds) {
    const std::size_t frame = bytes[control.status().step.doublings];
    if (control.endFrame(frame, true, 1ms, VoxelGrid(), SensorMotion::Moving))
      break;
  }
  EXPECT_EQ(clouds, 3u);
  EXPECT_EQ(control.status().step.doublings, 4u);
  EXPECT_EQ(control.status().clouds_left_out, 2u);
}

TEST(RateControl, LeastRateIsTheLeastThatChangesNothing)
{
  // Decided by the buffer, a second with an I-frame, and the mean.
  for (const auto& [i_frame_rate, rate_buffer] : {std::pair(1000u, 0.1),
                                                  std::pair(10u, 1.0),
                                                  std::pair(30u, 0.5),
                                                  std::pair(1u, 1.0)}) {
    SCOPED_TRACE(i_frame_rate);
    EncoderSettings settings = limitedSettings();
    settings.i_frame_rate = i_frame_rate;
    settings.rate_buffer = rate_buffer;
    const double least = leastRate(settings, 0.1, 1.25 * bytes_of_all, bytes_of_all);
    const auto isKept = [&](double rate) {
      settings.max_rate = rate;
      RatedStream stream(settings);
      return stream.sendFor(60s, share(1.0)) == 600 && stream.status().changes == 0;
    };
    EXPECT_TRUE(isKept(1.001 * least));
    EXPECT_FALSE(isKept(0.99 * least));
  }
}

TEST(RateControl, CloudsAreLeftOutBeforeTheEdgeDoubles)
{
  EncoderSettings settings = limitedSettings();
  settings.rate_temporal_filter = 0;
  settings.intensity_bits = 4; // no other step
  settings.rate_buffer = 1.0;
  for (const auto& [load, sent_share, sent, doublings] :
       {std::tuple(2.0, 0.33, 150.0, 0u),
        std::tuple(2.0, 1.0, 300.0, 1u),
        std::tuple(4.0, 0.33, 195.0, 1u),  // of which doubling leaves 1.6
        std::tuple(4.0, 0.2, 60.0, 0u)}) { // two of 0.4 s in any second
    settings.rate_sent_share = sent_share;
    RatedStream stream(settings);
    stream.sendFor(20s, share(load));
    EXPECT_NEAR(
        static_cast<double>(stream.sendFor(30s, share(load))), sent, 0.1 * sent);
    EXPECT_EQ(stream.status().step.doublings, doublings);
    EXPECT_EQ(stream.status().not_kept.empty(), sent == 300.0);
  }
}

TEST(RateControl, TheTemporalFilterIsForSensorsAtRest)
{
  // Of one that moves it would save nothing.
  EncoderSettings settings = limitedSettings();
  settings.i_frame_rate = 1000000;
  RatedStream stream(settings);
  for (const auto motion : {SensorMotion::Unknown, SensorMotion::Moving}) {
    stream.setSensorMotion(motion);
    for (int i = 0; i < 100; ++i) {
      stream.send(100ms, share(1.5));
      EXPECT_EQ(stream.control().settings().temporal_filter, 0u);
    }
  }
  EncoderSettings without = settings;
  without.rate_temporal_filter = 0;
  RatedStream same(without);
  same.sendFor(20s, share(1.5));
  EXPECT_EQ(stream.status().clouds_left_out, same.status().clouds_left_out);
  EXPECT_EQ(stream.status().choice, same.status().choice);
  // It is used some time after the sensor has come to rest, and no more in the cloud
  // after one in which it moves.
  stream.setSensorMotion(SensorMotion::AtRest);
  stream.sendFor(9s, share(1.5));
  EXPECT_EQ(stream.status().step.temporal_filter, 0u);
  stream.sendFor(10s, share(1.5));
  EXPECT_EQ(stream.status().step.temporal_filter, 8u);
  EXPECT_EQ(stream.status().step.intensity_bits, 0u);
  EXPECT_EQ(stream.status().not_kept, "");
  stream.setSensorMotion(SensorMotion::Moving);
  stream.send(100ms, share(1.5));
  stream.send(100ms, share(1.5));
  EXPECT_EQ(stream.status().step.temporal_filter, 0u);
  EXPECT_EQ(stream.status().reason, "the sensor moves");
}

TEST(RateControl, TextsSayWhatAndWhy)
{
  EncoderSettings settings;
  settings.max_rate = 5e5;
  settings.rate_doublings = 1;
  settings.rate_temporal_filter = 0;
  settings.rate_sent_share = 1.0;
  settings.i_frame_rate = 1;
  RateControl control(settings, false);
  // Frames of 10 kB at 10 Hz: 800 kbit/s.
  VoxelGrid grid;
  grid.resolution = 0.01;
  for (int i = 0; i < 300; ++i)
    if (control.beginCloud(i * 100ms, true))
      control.endFrame(10000, true, 20ms, grid);
  const RateControlStatus status = control.status();
  EXPECT_EQ(status.reason, "frames take 800 kbit/s of 500 kbit/s at most");
  EXPECT_EQ(status.choice, "voxels of 0.02 m, effort fast");
  EXPECT_EQ(status.not_kept,
            "clouds are left out, as frames take 800 kbit/s of 500 kbit/s at most");
  EXPECT_EQ(status.encode_ms, 20.0);
  EXPECT_EQ(status.resolution, 0.02);
  EXPECT_EQ(control.settings().resolution, 0.02);
  RateControl first(settings);
  ASSERT_TRUE(first.beginCloud(0s, true));
  EXPECT_FALSE(first.endFrame(40000, true, 20ms, grid));
  EXPECT_EQ(
      first.leftOutMessage().withIds(),
      "the cloud was left out, as max_rate of 500 kbit/s has room for 15625 bytes "
      "now, the last frame that was tried takes 40000");
}

TEST(RateControl, TextsNameSettingsAsTheFaceOfTheUserDoes)
{
  EncoderSettings settings;
  settings.max_rate = 2000.0;
  settings.rate_doublings = 0;
  RateControl control(settings, false);
  VoxelGrid grid;
  for (int i = 0; i < 30; ++i)
    if (control.beginCloud(i * 100ms, true))
      control.endFrame(10000, true, 20ms, grid);
  const std::string too_large =
      "I-frames 10 kB of the 0.0625 kB that the buffer lets them take";
  const std::string message =
      control.leftOutMessage().with([](const std::string& id) { return "--" + id; });
  EXPECT_EQ(message.find("the cloud was left out, as --max_rate of 2 kbit/s"), 0u)
      << message;
  for (const std::string& text : {message, control.status().not_kept}) {
    EXPECT_NE(text.find(too_large), std::string::npos) << text;
    EXPECT_EQ(text.find("rate_buffer"), std::string::npos) << text;
  }
}

TEST(RateControl, LongEncodingLowersTheEffortAndThenTheVoxels)
{
  RatedStream first(timedSettings(50.0));
  first.sendFor(1s, {100.0, 70.0});
  EXPECT_EQ(first.status().reason, "frames took 70 ms of 50 at most");
  RatedStream stream(timedSettings(50.0));
  stream.sendFor(10s, {100.0, 49.0});
  EXPECT_EQ(stream.status().changes, 0u);
  stream.sendFor(2s, {100.0, 70.0});
  EXPECT_EQ(stream.status().step.effort, Effort::Fast);
  EXPECT_EQ(stream.status().step.doublings, 0u);
  stream.sendFor(3s, {100.0, 300.0});
  EXPECT_EQ(stream.status().step.effort, Effort::Fast);
  EXPECT_EQ(stream.status().step.doublings, 1u);
  EXPECT_EQ(stream.status().not_kept, "");
  stream.sendFor(60s, {100.0, 10.0});
  EXPECT_EQ(stream.status().step.effort, Effort::Balanced);
  EXPECT_EQ(stream.status().step.doublings, 0u);
  EXPECT_EQ(stream.status().changes, 4u);
  stream.sendFor(10s, {100.0, 1e5});
  EXPECT_EQ(
      stream.status().not_kept,
      "the encode time is not kept: frames took 1024 ms of 50 at most on the coarsest "
      "step");
  EXPECT_EQ(stream.status().clouds_left_out, 0u);
}

TEST(RateControl, SpareTimeRaisesTheEffortBeforeVoxelsBecomeCoarser)
{
  EncoderSettings settings = timedSettings(50.0);
  settings.max_rate = max_rate;
  RatedStream stream(settings);
  stream.sendFor(10s, {1.02 * bytes_of_all, 10.0});
  EXPECT_EQ(stream.status().step.effort, Effort::Small);
  // Without time for it the other steps remain.
  stream.sendFor(20s, {1.02 * bytes_of_all, 70.0});
  EXPECT_EQ(stream.status().step.effort, Effort::Fast);
  EXPECT_EQ(stream.status().step.temporal_filter, 8u);
  EXPECT_EQ(stream.status().step.doublings, 0u);
}

TEST(RateControl, TheRateMayChangeAndIsThatOfTheLink)
{
  RatedStream stream(limitedSettings());
  stream.sendFor(10s, share(0.8));
  const auto change = [&](double rate) {
    stream.control().setMaxRate(rate);
    stream.link().setRate(rate);
  };
  change(max_rate / 2);
  EXPECT_EQ(stream.status().max_rate, max_rate / 2);
  stream.sendFor(4s, share(0.8));
  EXPECT_GE(stream.sendFor(20s, share(0.8)), 195u);
  EXPECT_GT(stream.status().step_number, 0u);
  change(max_rate);
  stream.sendFor(120s, share(0.5));
  EXPECT_EQ(stream.status().step_number, 0u);
  for (const double wrong : {0.0, -1.0, std::nan("")})
    stream.control().setMaxRate(wrong);
  EXPECT_EQ(stream.status().max_rate, max_rate);
  stream.control().setMaxRate(1.0);
  EXPECT_EQ(stream.status().max_rate, least_max_rate);
  stream.control().setMaxRate(std::numeric_limits<double>::infinity());
  EXPECT_EQ(stream.status().max_rate, most_max_rate);
  RatedStream unlimited(timedSettings(50.0));
  unlimited.control().setMaxRate(1000.0);
  EXPECT_EQ(unlimited.status().max_rate, 0.0);
  EXPECT_EQ(unlimited.sendFor(1s, share(10.0)), 10u);
}

TEST(RateControl, ARateThatFallsFarIsFollowedWithinTheSecond)
{
  for (const double part : {2.0, 20.0, 1000.0}) {
    RatedStream stream(limitedSettings());
    stream.sendFor(10s, share(0.8 / part));
    EXPECT_EQ(stream.status().step_number, 0u);
    stream.control().setMaxRate(max_rate / part);
    stream.link().setRate(max_rate / part);
    stream.sendFor(2s, share(0.8));
    EXPECT_GT(stream.status().step_number, 0u) << part;
    EXPECT_FALSE(stream.status().not_kept.empty() && part > 100.0) << part;
  }
}

TEST(RateControl, CoarseVoxelsAreThoseOfTheFinestGrid)
{
  EncoderSettings settings;
  settings.max_encode_ms = 1.0;
  settings.effort = Effort::Fast;
  settings.use_coordinate_step = true;
  RateControl control(settings);
  VoxelGrid grid;
  grid.resolution = 0.05; // the clouds' step
  grid.origin = {500000.0, -0.025, 0.0};
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(control.beginCloud(i * 100ms, i == 0));
    if (control.hasChanged())
      break;
    EXPECT_TRUE(control.endFrame(100, i == 0, 20ms, grid));
  }
  ASSERT_TRUE(control.hasChanged());
  EXPECT_EQ(control.settings().resolution, 0.1);
  EXPECT_EQ(control.settings().origin, grid.origin);
  EXPECT_FALSE(control.settings().use_coordinate_step);
}

TEST(RateControl, AMovedControlGoesOn)
{
  RatedStream stream(limitedSettings());
  stream.sendFor(10s, share(2.0));
  const std::size_t step = stream.status().step_number;
  ASSERT_GT(step, 0u);
  RateControl moved(std::move(stream.control()));
  EXPECT_EQ(moved.status().step_number, step);
  stream.control() = std::move(moved);
  EXPECT_GE(stream.sendFor(10s, share(2.0)), 97u);
}

} // namespace rate_control

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>

#include "codec/payload_coder.h"
#include "rate/rate_estimate.h"
#include "support/point_views.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::io::test::viewOf;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using CloudTime = std::optional<nanoseconds>;

EncoderSettings
settingsOf(unsigned int i_frame_rate, double i_frame_every)
{
  EncoderSettings settings;
  settings.resolution = 0.1;
  settings.i_frame_rate = i_frame_rate;
  settings.i_frame_every = i_frame_every;
  settings.bounding_box = {{0.0, 0.0, 0.0}, {2.0, 2.0, 2.0}};
  return settings;
}

/** \brief Times of milliseconds; none where there is no time. */
std::vector<CloudTime>
timesOf(const std::vector<int>& numbers)
{
  std::vector<CloudTime> times;
  for (const int number : numbers)
    times.push_back(number < 0 ? CloudTime() : milliseconds(number));
  return times;
}

constexpr int none = -1;

/** \brief Kinds of the frames of a wall that stands still: I or P.
 * \param[in] requested number of the cloud before which an I-frame is requested
 */
std::string
kindsOf(const EncoderSettings& settings,
        const std::vector<CloudTime>& times,
        std::size_t requested = 0)
{
  std::vector<std::array<float, 3>> points;
  for (int i = 0; i < 400; ++i)
    points.push_back(
        {0.1f * static_cast<float>(i % 20), 0.1f * static_cast<float>(i / 20), 1.0f});
  const PointView view = viewOf(points, {20, 20});
  CloudEncoder encoder(settings, pcl_ext::IntensityUnit::None);
  EXPECT_TRUE(encoder.settingsStatus().ok()) << encoder.settingsStatus();
  std::string kinds;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (i == requested)
      encoder.requestIFrame();
    CloudInfo info;
    info.time = times[i];
    EXPECT_TRUE(encoder.encode(view, info, bytes).ok());
    kinds += encoder.statistics().coding.is_i_frame ? 'I' : 'P';
  }
  return kinds;
}

std::string
kindsOf(unsigned int i_frame_rate,
        double i_frame_every,
        const std::vector<int>& numbers)
{
  return kindsOf(settingsOf(i_frame_rate, i_frame_every), timesOf(numbers));
}

TEST(ScheduledIFrames, CloudsWithoutATimeAreCountedOnly)
{
  EXPECT_EQ(kindsOf(4, 0.1, {none, none, none, none, none}), "IPPPI");
  EXPECT_EQ(kindsOf(100, 0.4, {0, none, 300, none, 400, none, 700}), "IPPPIPP");
  // Where the I-frame has no time, from the first one after it on.
  EXPECT_EQ(kindsOf(100, 0.4, {none, none, 1000, 1399, 1400}), "IPPPI");
  EXPECT_EQ(kindsOf(3, 0.4, {1000, none, none, none, 1200, 1599, 1600}), "IPPIPPI");
}

TEST(ScheduledIFrames, TimesMayBeTheEndsOfTheirRange)
{
  const std::vector<CloudTime> ends = {
      nanoseconds::min(), nanoseconds::max(), nanoseconds::max(), nanoseconds::min()};
  EXPECT_EQ(kindsOf(settingsOf(100, 86400.0), ends), "IIPI");
}

TEST(ScheduledIFrames, NanosecondsOfClocksCount)
{
  // A float of 64 bits has no nanoseconds of these.
  const nanoseconds today{1'700'000'000'123'456'789};
  const nanoseconds second{1'000'000'000};
  for (const double every : {1.0, 0.1, 0.3, 0.007}) {
    const auto period = nanoseconds(std::llround(every * 1e9));
    EXPECT_EQ(kindsOf(settingsOf(100, every),
                      {today, today + period - nanoseconds(1), today + period}),
              "IPI");
  }
  EXPECT_EQ(kindsOf(settingsOf(100, 1.0), {today + second, today, today + second}),
            "III");
}

TEST(ScheduledIFrames, AreThoseOfTheRuleForAnyTimes)
{
  std::mt19937_64 random(5);
  constexpr int requested = 40;
  std::vector<int> times;
  std::string expected;
  int at = 100000;
  int of_i_frame = 0;
  int since = 0;
  for (int i = 0; i < 300; ++i) {
    const auto number = static_cast<int>(random() % 100);
    at += number < 3 ? -700 : number < 6 ? -200 : number;
    times.push_back(at);
    const bool is_due =
        i == 0 || i == requested || since == 17 || std::abs(at - of_i_frame) >= 600;
    expected += is_due ? 'I' : 'P';
    since = is_due ? 1 : since + 1;
    of_i_frame = is_due ? at : of_i_frame;
  }
  EXPECT_EQ(kindsOf(settingsOf(17, 0.6), timesOf(times), requested), expected);
}

TEST(ScheduledIFrames, AreThoseOfScansAndThePublishedLayout)
{
  const std::vector<CloudTime> times = timesOf({0, 300, 600, 900, 1200, 1500});
  EncoderSettings settings = settingsOf(100, 0.6);
  settings.keep_order = true;
  settings.bounding_box.reset();
  EXPECT_EQ(kindsOf(settings, times), "IPIPIP");
  settings = settingsOf(100, 0.6);
  settings.format = StreamFormat::Published;
  settings.colour_bits = 0;
  EXPECT_EQ(kindsOf(settings, times), "IPIPIP");
}

TEST(ScheduledIFrames, TheirShareOfBytesIsExpected)
{
  StreamSettings stream;
  stream.i_frame_rate = 30;
  EXPECT_EQ(framesOfIFrame(stream, 0.1), 30.0);
  stream.i_frame_every = 1.0;
  EXPECT_EQ(framesOfIFrame(stream, 0.0), 30.0);
  EXPECT_EQ(framesOfIFrame(stream, 0.125), 8.0);
  EXPECT_EQ(framesOfIFrame(stream, 0.3), 4.0);
  EXPECT_EQ(framesOfIFrame(stream, 0.01), 30.0);
  EXPECT_EQ(framesOfIFrame(stream, 5.0), 1.0);
  stream.i_frame_rate = 0;
  EXPECT_EQ(framesOfIFrame(stream, 0.1), 1.0);
  // 100 kB of an I-frame and 7 of 20 kB in a second.
  stream.i_frame_rate = 30;
  RateEstimate estimate(stream);
  for (int i = 0; i < 20; ++i)
    estimate.addInterval(milliseconds(125));
  estimate.addFrame(100000, true, milliseconds(1));
  estimate.addFrame(20000, false, milliseconds(1));
  EXPECT_NEAR(estimate.bytesPerSecond(), 240000.0, 1.0);
}

/** \brief A frame that shares some of its voxels with another one. */
VoxelFrame
sharing(std::mt19937_64& random,
        const VoxelFrame& other,
        std::size_t shared,
        std::size_t count)
{
  std::set<std::uint64_t> keys(
      other.keys.begin(), other.keys.begin() + static_cast<std::ptrdiff_t>(shared));
  const std::set<std::uint64_t> others(other.keys.begin(), other.keys.end());
  while (keys.size() < count) {
    const std::uint64_t key = below(random, std::uint64_t{1} << (3 * other.grid.depth));
    if (others.count(key) == 0)
      keys.insert(key);
  }
  VoxelFrame frame = other;
  setVoxels(random, keys, frame);
  return frame;
}

bool
isSecondAnIFrame(const VoxelFrame& first, const VoxelFrame& second, Effort effort)
{
  FrameEncoder encoder(StreamFormat::Version1, 1000, effort);
  FrameDecoder decoder;
  VoxelFrame back;
  for (const VoxelFrame* frame : {&first, &second}) {
    EXPECT_EQ(decoded(decoder, encoded(encoder, *frame), back), CompressionCode::Ok);
    expectSameFrame(back, *frame);
    EXPECT_EQ(decoder.statistics().is_i_frame, encoder.statistics().is_i_frame);
  }
  return encoder.statistics().is_i_frame;
}

TEST(UnscheduledIFrames, AreSentWhenTheHistoryIsTooLarge)
{
  // A sensor that sees much, then almost nothing: its history is as large as before,
  // and costs time for nothing.
  std::mt19937_64 random(2);
  const auto isIFrameAfter = [&](std::size_t records, std::size_t voxels) {
    const VoxelFrame first = randomFrame(random, 8, records);
    return isSecondAnIFrame(
        first, sharing(random, first, voxels, voxels), Effort::Balanced);
  };
  const std::size_t few = 100;
  EXPECT_FALSE(isIFrameAfter(maxTracked(few), few));
  EXPECT_TRUE(isIFrameAfter(maxTracked(few) + 1, few));
  EXPECT_FALSE(isIFrameAfter(maxTracked(0), 0));
  EXPECT_TRUE(isIFrameAfter(maxTracked(0) + 1, 0));
}

TEST(UnscheduledIFrames, DecodersWithTheSameLimitAcceptEveryFrame)
{
  // Voxels that wander as fast as they can without an I-frame.
  DecoderLimits limits;
  limits.max_voxels = 2000;
  for (const Effort effort : all_efforts) {
    std::mt19937_64 random(3);
    FrameEncoder encoder(StreamFormat::Version1, 1000, effort);
    FrameDecoder decoder(limits);
    VoxelFrame back;
    VoxelFrame frame = randomFrame(random, 12, limits.max_voxels);
    for (int i = 0; i < 25; ++i) {
      ASSERT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
      ASSERT_EQ(back.keys, frame.keys);
      ASSERT_EQ(encoder.statistics().is_i_frame, i == 0);
      frame = sharing(random, frame, limits.max_voxels / 2, limits.max_voxels);
    }
  }
}

} // namespace

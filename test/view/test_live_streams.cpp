// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/live_source.h"
#include "view/live_streams.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace {

struct Live {
  explicit Live(const ViewServerLimits& limits = ViewServerLimits(),
                bool can_request = true)
  : streams(limits, can_request)
  {
    streams.addStream({"/sensor", {}});
  }

  void
  publish(Bytes frame)
  {
    const ViewServerStatus status =
        streams.publish(0, timeOfFrame(0), std::move(frame));
    EXPECT_TRUE(status.ok()) << status;
  }

  /** \brief Takes all that waits for a viewer; its frames. */
  std::vector<OutgoingMessage>
  take(const std::shared_ptr<ViewerQueue>& viewer)
  {
    std::vector<OutgoingMessage> frames;
    OutgoingMessage message;
    while (streams.next(*viewer, message))
      if (!message.text)
        frames.push_back(message);
    return frames;
  }

  std::size_t
  requestsAt(std::chrono::milliseconds time)
  {
    return streams.dueIFrameRequests(LiveStreams::Clock::time_point(time)).size();
  }

  LiveStreams streams;
};

bool
isSkippedBefore(const OutgoingMessage& message)
{
  return message.head[4] == skipped_before;
}

using std::chrono::milliseconds;

} // namespace

TEST(LiveStreams, ANewViewerBeginsWithTheLastIFrame)
{
  Live live;
  LiveSource source(/* i_frame_rate */ 10);
  std::vector<Bytes> frames;
  for (int i = 0; i < 14; ++i) {
    frames.push_back(source.next());
    live.publish(frames.back());
  }
  const auto viewer = live.streams.addViewer();
  const auto begun = live.take(viewer);
  ASSERT_EQ(begun.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(*begun[i].frame, frames[10 + i]);
    EXPECT_FALSE(isSkippedBefore(begun[i]));
  }
  EXPECT_EQ(live.requestsAt(milliseconds(0)), 0u);
}

TEST(LiveStreams, ViewersKnowHowOldStreamsAreAndWhatIsWrong)
{
  Live live;
  live.streams.addStream({"/silent", {}});
  LiveSource source(10);
  live.publish(source.next());
  const auto viewer = live.streams.addViewer();
  const auto next_text = [&] {
    OutgoingMessage message;
    while (live.streams.next(*viewer, message))
      if (message.text && message.text->find("state") != std::string::npos)
        return nlohmann::json::parse(*message.text);
    return nlohmann::json();
  };
  const nlohmann::json state = next_text();
  EXPECT_EQ(state["type"], "state");
  EXPECT_EQ(state["problem"], "");
  ASSERT_EQ(state["ages_ms"].size(), 2u);
  EXPECT_GE(state["ages_ms"][0], 0);
  EXPECT_TRUE(state["ages_ms"][1].is_null());
  // The frame that was there before the viewer is told from one that comes.
  OutgoingMessage message;
  ASSERT_TRUE(live.streams.next(*viewer, message));
  EXPECT_EQ(message.head[4], published_before);
  EXPECT_EQ(next_text(), nlohmann::json());
  live.publish(source.next());
  ASSERT_TRUE(live.streams.next(*viewer, message));
  EXPECT_EQ(message.head[4], 0u);
  live.streams.setProblem("the connection is \"lost\"");
  EXPECT_EQ(next_text()["problem"], "the connection is \"lost\"");
  live.streams.setProblem("");
  EXPECT_EQ(next_text()["problem"], "");
}

TEST(LiveStreams, TooMuchForANewViewerIsRequestedAsAnIFrame)
{
  ViewServerLimits limits;
  limits.max_kept_frames = 5;
  Live live(limits);
  LiveSource source(1000);
  for (int i = 0; i < 6; ++i)
    live.publish(source.next());
  EXPECT_EQ(live.requestsAt(milliseconds(0)), 0u); // nobody looks
  const auto viewer = live.streams.addViewer();
  live.publish(source.next());
  EXPECT_TRUE(live.take(viewer).empty());
  EXPECT_EQ(live.requestsAt(milliseconds(0)), 1u);
  source.requestIFrame();
  const Bytes frame = source.next();
  live.publish(frame);
  const auto taken = live.take(viewer);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(*taken[0].frame, frame);
  EXPECT_EQ(live.requestsAt(milliseconds(10'000)), 0u);
}

TEST(LiveStreams, KeptBytesAreBounded)
{
  ViewServerLimits limits;
  limits.max_kept_bytes = 3000;
  Live live(limits);
  LiveSource source(1000, /* noise */ 200);
  ViewServerStatistics statistics;
  for (int i = 0; i < 20; ++i) {
    live.publish(source.next());
    live.streams.addTo(statistics);
    EXPECT_LE(statistics.kept_bytes, limits.max_kept_bytes);
  }
  EXPECT_EQ(statistics.kept_bytes, 0u);
}

TEST(LiveStreams, RequestsAreFarApartAndEndWithTheIFrame)
{
  Live live;
  const auto viewer = live.streams.addViewer();
  // 100 ms apart, then 200, and so on up to 1600.
  EXPECT_EQ(live.requestsAt(milliseconds(1000)), 1u);
  EXPECT_EQ(live.requestsAt(milliseconds(1099)), 0u);
  live.streams.restart(*viewer, 0);
  EXPECT_EQ(live.requestsAt(milliseconds(1099)), 0u);
  EXPECT_EQ(live.requestsAt(milliseconds(1100)), 1u);
  EXPECT_EQ(live.requestsAt(milliseconds(1299)), 0u);
  EXPECT_EQ(live.requestsAt(milliseconds(1300)), 1u);
  int requests = 0;
  for (int time = 1301; time < 101'301; ++time)
    requests += live.requestsAt(milliseconds(time)) > 0 ? 1 : 0;
  EXPECT_EQ(requests, 2 + 61); // at 1700, 2500, and then every 1600
  LiveSource source(10);
  live.publish(source.next());
  EXPECT_EQ(live.requestsAt(milliseconds(200'000)), 0u);
  live.streams.restart(*viewer, 0);
  EXPECT_EQ(live.requestsAt(milliseconds(200'000)), 1u);
  // A viewer that has lost step again and again is heard once a second.
  live.publish(source.next());
  source.requestIFrame();
  live.publish(source.next());
  live.streams.restart(*viewer, 0);
  EXPECT_EQ(live.requestsAt(milliseconds(200'999)), 0u);
  EXPECT_EQ(live.requestsAt(milliseconds(201'000)), 1u);
  live.streams.restart(*viewer, 7); // there is none
  live.streams.removeViewer(viewer);
  EXPECT_FALSE(live.streams.wantsIFrames());
}

TEST(LiveStreams, AFrameThatIsMissingIsNotKeptAndAnIFrameIsRequested)
{
  Live live;
  LiveSource source(100);
  const auto viewer = live.streams.addViewer();
  live.publish(source.next());
  live.publish(source.next());
  source.next(); // lost
  live.publish(source.next());
  EXPECT_EQ(live.take(viewer).size(), 3u); // the viewer says what it cannot decode
  EXPECT_EQ(live.requestsAt(milliseconds(1000)), 1u);
  const auto late = live.streams.addViewer();
  EXPECT_TRUE(live.take(late).empty());
  source.requestIFrame();
  live.publish(source.next());
  EXPECT_EQ(live.take(viewer).size(), 1u);
  EXPECT_EQ(live.take(late).size(), 1u);
}

TEST(LiveStreams, ASlowViewerGoesOnAtAnIFrame)
{
  ViewServerLimits limits;
  limits.max_queued_frames = 4;
  Live live(limits);
  LiveSource source(10);
  const auto slow = live.streams.addViewer();
  std::vector<Bytes> frames;
  for (int i = 0; i < 13; ++i) {
    frames.push_back(source.next());
    live.publish(frames.back());
  }
  // Of frames 0 to 3 the fifth one made it too slow; frame 10 is an I-frame.
  EXPECT_EQ(slow->skipped(), 10u);
  const auto taken = live.take(slow);
  ASSERT_EQ(taken.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(*taken[i].frame, frames[10 + i]);
    EXPECT_EQ(isSkippedBefore(taken[i]), i == 0);
  }
  EXPECT_EQ(slow->bytes(), 0u);
}

TEST(LiveStreams, ASlowViewerWithRoomAgainAsksForAnIFrame)
{
  ViewServerLimits limits;
  limits.max_queued_frames = 2;
  Live live(limits);
  LiveSource source(1000);
  const auto slow = live.streams.addViewer();
  for (int i = 0; i < 5; ++i)
    live.publish(source.next());
  EXPECT_EQ(live.requestsAt(milliseconds(1000)), 0u);
  EXPECT_TRUE(live.take(slow).empty());
  EXPECT_EQ(live.requestsAt(milliseconds(1000)), 1u);
  source.requestIFrame();
  live.publish(source.next());
  const auto taken = live.take(slow);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_TRUE(isSkippedBefore(taken[0]));
}

TEST(LiveStreams, ASlowViewersBytesAreBoundedAndOtherStreamsGoOn)
{
  ViewServerLimits limits;
  limits.max_queued_bytes = 20'000;
  Live live(limits);
  live.streams.addStream({"/small", {}});
  const auto slow = live.streams.addViewer();
  LiveSource large(5, /* noise */ 500);
  LiveSource small(5);
  for (int i = 0; i < 100; ++i) {
    live.publish(large.next());
    EXPECT_LE(slow->bytes(), limits.max_queued_bytes);
  }
  EXPECT_GT(slow->skipped(), 0u);
  live.take(slow);
  const Bytes frame = small.next();
  EXPECT_TRUE(live.streams.publish(1, timeOfFrame(0), Bytes(frame)).ok());
  const auto taken = live.take(slow);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(*taken[0].frame, frame);
  EXPECT_FALSE(isSkippedBefore(taken[0]));
}

TEST(LiveStreams, AFrameLargerThanTheQueueIsSentAlone)
{
  ViewServerLimits limits;
  limits.max_queued_bytes = 100;
  Live live(limits);
  LiveSource source(1, 500);
  const auto viewer = live.streams.addViewer();
  for (int i = 0; i < 3; ++i) {
    live.publish(source.next());
    EXPECT_EQ(live.take(viewer).size(), 1u);
  }
}

TEST(LiveStreams, WithoutAnEncoderToAskAViewerIsSentTheKeptFramesAgain)
{
  Live live(ViewServerLimits(), /* can_request */ false);
  LiveSource source(100);
  const auto viewer = live.streams.addViewer();
  for (int i = 0; i < 3; ++i)
    live.publish(source.next());
  EXPECT_EQ(live.take(viewer).size(), 3u);
  live.streams.restart(*viewer, 0);
  EXPECT_EQ(live.take(viewer).size(), 3u);
  EXPECT_FALSE(live.streams.wantsIFrames());
}

TEST(LiveStreams, WhatIsNoFrameIsRefused)
{
  Live live;
  LiveSource source(10);
  const auto viewer = live.streams.addViewer();
  const auto publish = [&](std::size_t stream, Bytes bytes) {
    return live.streams.publish(stream, timeOfFrame(0), std::move(bytes)).code();
  };
  Bytes frame = source.next();
  EXPECT_EQ(publish(0, {}), ViewServerCode::InvalidArgument);
  EXPECT_EQ(publish(0, {1, 2, 3}), ViewServerCode::InvalidArgument);
  EXPECT_EQ(publish(1, frame), ViewServerCode::InvalidArgument);
  frame.push_back(0);
  EXPECT_EQ(publish(0, frame), ViewServerCode::InvalidArgument);
  frame.resize(frame.size() - 2);
  EXPECT_EQ(publish(0, frame), ViewServerCode::InvalidArgument);
  EXPECT_TRUE(live.take(viewer).empty());
  live.streams.end();
  EXPECT_EQ(publish(0, source.next()), ViewServerCode::InvalidArgument);
}

TEST(LiveMessages, ListTheStreamsAndAskForIFrames)
{
  const auto json = nlohmann::json::parse(
      streamsMessage({{"/a\"b", {{"sensor_pose", "1,2"}}}, {"\xff", {}}}));
  EXPECT_EQ(json["type"], "streams");
  EXPECT_EQ(json["streams"][0]["id"], 0);
  EXPECT_EQ(json["streams"][0]["name"], "/a\"b");
  EXPECT_EQ(json["streams"][0]["metadata"]["sensor_pose"], "1,2");
  EXPECT_EQ(json["streams"][1]["id"], 1);
  EXPECT_TRUE(json["streams"][1]["metadata"].is_object());
  EXPECT_EQ(requestedIFrame(R"({"type":"i-frame","stream":3})"), 3u);
  for (const char* other : {"",
                            "{}",
                            "[]",
                            "i-frame",
                            R"({"type":"i-frame"})",
                            R"({"type":"i-frame","stream":-1})",
                            R"({"type":"i-frame","stream":1.5})",
                            R"({"type":"i-frame","stream":"1"})",
                            R"({"type":"p-frame","stream":1})",
                            R"({"type":"i-frame","stream":1)"})
    EXPECT_FALSE(requestedIFrame(other).has_value()) << other;
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test

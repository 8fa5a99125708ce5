// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/clients.h"
#include "view/running_server.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <atomic>
#include <thread>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace {

bool
areSame(const io::VoxelFrame& a, const io::VoxelFrame& b)
{
  return a.keys == b.keys && a.intensities == b.intensities;
}

} // namespace

TEST(LiveView, MessagesAreThoseOfTheProtocol)
{
  ViewServerSettings settings;
  settings.page = test_page;
  settings.name = "robot cell";
  ViewServer server(settings);
  std::size_t stream = 9;
  ASSERT_TRUE(server.addStream("/a", {{"sensor_pose", "1,2,3"}}, stream).ok());
  ASSERT_TRUE(server.start().ok());
  EXPECT_EQ(request(server.port(), "/api/source.json").body,
            R"({"kind":"live","name":"robot cell","socket":"api/live"})");
  LiveClient client(server.port());
  EXPECT_EQ(client.protocol(), "pcl_ext.live.v1");
  EXPECT_EQ(
      client.next()->text,
      R"({"streams":[{"id":0,"metadata":{"sensor_pose":"1,2,3"},"name":"/a"}],"type":"streams"})");
  LiveSource source(10);
  const Bytes frame = source.next();
  constexpr std::chrono::nanoseconds time{0x0102030405060708};
  ASSERT_TRUE(server.publish(stream, time, frame).ok());
  const LiveMessage message = client.next().value();
  EXPECT_EQ(message.text, "");
  EXPECT_EQ(message.stream, 0u);
  EXPECT_EQ(message.flags, 0u);
  EXPECT_EQ(message.time, time.count());
  EXPECT_EQ(message.frame, frame);
  // Streams that are added later, and what changes of a stream.
  ASSERT_TRUE(server.addStream("/b", {}, stream).ok());
  EXPECT_EQ(nlohmann::json::parse(client.next()->text)["streams"][1]["name"], "/b");
  ASSERT_TRUE(server.setMetadata(1, {{"intensity_law", "count"}}).ok());
  EXPECT_EQ(nlohmann::json::parse(
                client.next()->text)["streams"][1]["metadata"]["intensity_law"],
            "count");
  LiveSource other(10, 2, /* seed */ 2);
  ASSERT_TRUE(server.publish(1, std::chrono::nanoseconds(-1), other.next()).ok());
  const LiveMessage second = client.next().value();
  EXPECT_EQ(second.stream, 1u);
  EXPECT_EQ(second.time, -1);
  server.end();
  EXPECT_EQ(client.next()->text, R"({"type":"end"})");
  LiveClient late(server.port());
  EXPECT_TRUE(hasPart(late.next()->text, "streams"));
  EXPECT_EQ(late.next()->frame, frame);
  EXPECT_EQ(late.next()->stream, 1u);
  EXPECT_EQ(late.next()->text, R"({"type":"end"})");
}

TEST(LiveView, TheAgeOfAStreamGrowsWhileNothingComes)
{
  RunningServer live;
  LiveClient client(live.port());
  ASSERT_TRUE(live.waitForViewers(1));
  LiveSource source(10);
  live.publish(0, 0, source.next());
  std::int64_t age = -1;
  for (int states = 0; states < 2;) {
    const nlohmann::json ages = nlohmann::json::parse(client.nextState())["ages_ms"];
    if (ages.empty() || ages[0].is_null())
      continue; // of before
    EXPECT_GT(ages[0].get<std::int64_t>(), age);
    age = ages[0];
    ++states;
  }
  live.server->setProblem("nobody sends");
  while (nlohmann::json::parse(client.nextState())["problem"] != "nobody sends") {
  }
}

TEST(LiveView, AnIFrameIsRequestedWhereNoneIsKeptAndWhenAViewerAsks)
{
  RunningServer live;
  LiveClient client(live.port());
  EXPECT_TRUE(
      waitFor([&] { return live.requests > 0; })); // the encoder sends nothing yet
  LiveSource source(1000);
  live.publish(0, 0, source.next());
  live.publish(0, 1, source.next());
  client.nextFrame();
  client.nextFrame();
  const std::size_t before = live.requests;
  ASSERT_TRUE(client.send(R"({"type":"i-frame","stream":0})"));
  ASSERT_TRUE(waitFor([&] { return live.requests > before; }));
  source.requestIFrame();
  const Bytes frame = source.next();
  live.publish(0, 2, frame);
  EXPECT_EQ(client.nextFrame()->frame, frame);
}

TEST(LiveView, AViewerThatDoesNotReadDisturbsNobodyAndGoesOnAtAnIFrame)
{
  ViewServerLimits limits;
  limits.max_queued_frames = 10;
  limits.max_queued_bytes = 100'000;
  limits.idle_timeout = std::chrono::minutes(10); // it answers no ping
  RunningServer live(limits);
  LiveClient slow(live.port(), /* receive_buffer */ 4096);
  LiveClient fast(live.port());
  ASSERT_TRUE(live.waitForViewers(2));
  LiveSource source(/* i_frame_rate */ 5, /* noise */ 5000);
  std::size_t published = 0;
  const auto publish = [&] {
    const Bytes frame = source.next();
    live.publish(0, published++, frame);
    EXPECT_EQ(fast.nextFrame()->frame, frame);
    // The queue's own frames, without the one that is on its way.
    EXPECT_LE(live.server->statistics().queued_bytes, limits.max_queued_bytes);
  };
  // Until also the buffers of the system are full.
  while (live.server->statistics().frames_skipped < 40 && published < 2000)
    publish();
  const ViewServerStatistics statistics = live.server->statistics();
  EXPECT_GE(statistics.frames_skipped, 40u);
  EXPECT_LE(statistics.largest_queue_bytes, limits.max_queued_bytes);
  EXPECT_LE(statistics.largest_queue_frames, limits.max_queued_frames);

  // It reads again: whatever it gets can be decoded.
  io::FrameDecoder decoder;
  io::VoxelFrame decoded;
  std::int64_t last = -1;
  std::size_t gaps = 0;
  const std::int64_t end = timeOfFrame(published + 4).count(); // with an I-frame
  for (int i = 0; i < 5; ++i)
    live.publish(0, published++, source.next());
  while (last < end) {
    const auto message = slow.nextFrame();
    ASSERT_TRUE(message.has_value());
    const bool is_gap = last >= 0 && message->time != last + 50'000'000;
    EXPECT_EQ(message->flags, is_gap ? 1u : 0u);
    gaps += is_gap ? 1 : 0;
    last = message->time;
    const auto status =
        decoder.decode(message->frame.data(), message->frame.size(), decoded);
    ASSERT_TRUE(status.ok()) << status;
  }
  EXPECT_GE(gaps, 1u);
  EXPECT_TRUE(areSame(decoded, source.voxels()));
}

TEST(LiveView, OnlyPagesOfThisServerReadTheStreams)
{
  RunningServer live;
  const std::string host = "Host: localhost:8080\r\n";
  const auto status = [&](const std::string& headers) {
    return upgradeStatus(live.port(), host + headers);
  };
  EXPECT_EQ(status(""), 101);
  EXPECT_EQ(status("Origin: http://localhost:8080\r\n"), 101);
  EXPECT_EQ(status("Origin: http://example.org\r\n"), 403);
  EXPECT_EQ(status("Origin: http://localhost:8081\r\n"), 403);
  EXPECT_EQ(status("Origin: http://localhost\r\n"), 403);
  EXPECT_EQ(status("Origin: null\r\n"), 403);
  EXPECT_EQ(status("Origin:\r\n"), 403);
  EXPECT_EQ(
      status("Origin: http://localhost:8080\r\nOrigin: http://localhost:8080\r\n"),
      403);
  EXPECT_EQ(
      upgradeStatus(live.port(), "Host: example.org\r\nOrigin: http://example.org\r\n"),
      421);
  EXPECT_EQ(status("Sec-WebSocket-Protocol: a, pcl_ext.live.v1\r\n"), 101);
  EXPECT_EQ(status("Sec-WebSocket-Protocol: pcl_ext.live.v2\r\n"), 400);
  EXPECT_EQ(upgradeStatus(live.port(), host, "/"), 404);
  EXPECT_EQ(upgradeStatus(live.port(), host, "/api/live/../files/0"), 404);
  EXPECT_EQ(request(live.port(), "/api/live").status, 404);
}

TEST(LiveView, StreamsGoOnWhileViewersComeAndGo)
{
  RunningServer live;
  std::atomic<bool> has_ended{false};
  std::thread publisher([&] {
    LiveSource source(5, 50);
    for (std::size_t i = 0; !has_ended; ++i) {
      live.publish(0, i, source.next());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  std::vector<std::thread> viewers;
  std::atomic<std::size_t> decoded{0};
  for (int i = 0; i < 4; ++i)
    viewers.emplace_back([&] {
      for (int visit = 0; visit < 10; ++visit) {
        LiveClient client(live.port());
        io::FrameDecoder decoder;
        io::VoxelFrame voxels;
        for (int frame = 0; frame < 5; ++frame) {
          const auto message = client.nextFrame();
          decoded +=
              message &&
                      decoder
                          .decode(message->frame.data(), message->frame.size(), voxels)
                          .ok()
                  ? 1
                  : 0;
        }
      }
    });
  for (std::thread& viewer : viewers)
    viewer.join();
  has_ended = true;
  publisher.join();
  EXPECT_EQ(decoded, 4u * 10u * 5u);
  EXPECT_TRUE(live.waitForViewers(0));
}

namespace {

constexpr char text_format[] = "text/plain; version=0.0.4; charset=utf-8";

/** \brief What the text tells of a metric without labels; empty if it tells nothing. */
std::string
valueOf(const std::string& text, const std::string& name)
{
  const std::size_t at = text.find('\n' + name + ' ');
  if (at == std::string::npos)
    return {};
  const std::size_t begin = at + name.size() + 2;
  return text.substr(begin, text.find('\n', begin) - begin);
}

} // namespace

TEST(ServerMetrics, AreOfTheServerAlone)
{
  RunningServer live;
  LiveClient client(live.port());
  ASSERT_TRUE(live.waitForViewers(1));
  LiveSource source(10);
  live.publish(0, 0, source.next());
  ASSERT_TRUE(client.nextFrame());
  const HttpAnswer answer = request(live.port(), "/metrics?x=1");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.headers.at("content-type"), text_format);
  EXPECT_EQ(answer.headers.at("cache-control"), "no-store");
  EXPECT_EQ(answer.headers.count("etag"), 0u);
  EXPECT_EQ(answer.body.rfind("# HELP pcl_ext_view_connections ", 0), 0u);
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_connections"), "2");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_viewers"), "1");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_frames_total"), "1");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_frames_sent_total"), "1");
  EXPECT_EQ(valueOf(answer.body, "pcl_ext_view_frames_skipped_total"), "0");
}

TEST(ServerMetrics, FollowThoseOfTheProgram)
{
  std::atomic<int> calls{0};
  ViewServerSettings settings;
  settings.metrics = [&calls] {
    return "# TYPE x gauge\nx " + std::to_string(++calls) + "\n";
  };
  ViewServer server(settings);
  ASSERT_TRUE(server.start().ok());
  for (const char* first :
       {"# TYPE x gauge\nx 1\n# HELP", "# TYPE x gauge\nx 2\n# HELP"})
    EXPECT_EQ(request(server.port(), "/metrics").body.rfind(first, 0), 0u);
  const HttpAnswer head = request(server.port(), "/metrics", "", "HEAD");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-type"), text_format);
  EXPECT_EQ(request(server.port(), "/metrics", "Host: example.org\r\n").status, 421);
  EXPECT_EQ(request(server.port(), "/metrics", "", "POST").status, 405);
  EXPECT_EQ(upgradeStatus(server.port(), "", "/metrics"), 404);
  EXPECT_EQ(request(server.port(), "/metrics/").status, 404);
  EXPECT_EQ(calls, 3);
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test

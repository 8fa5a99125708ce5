// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/site_program.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <memory>
#include <regex>
#include <string>
#include <thread>

namespace pcl_ext::tools::test {

using link::test::freePort;

namespace {

Bytes
iFrame(std::uint32_t width = 5)
{
  return knownStream(1, 1, 1, width).frames[0].bytes;
}

} // namespace

using ProgramSiteState = SiteTest;

TEST_F(ProgramSiteState, ThePageAndTheMetricsTellThatTheServerIsGone)
{
  writeText(folder / "page.html", view_page);
  const std::uint16_t page_port = freePort();
  const std::uint16_t metrics_port = freePort();
  Receiving receiving(folder,
                      at(server) + "--view --no-browser --page page.html --port " +
                          std::to_string(page_port) + " --metrics-port " +
                          std::to_string(metrics_port));
  SitePublisher sensor(server);
  sensor.publish(std::chrono::seconds(1), iFrame());
  view::test::LiveClient page(page_port);
  EXPECT_TRUE(page.nextFrame().has_value());
  const auto wait_for_problem = [&](const std::string& problem) {
    while (nlohmann::json::parse(page.nextState())["problem"] != problem) {
    }
  };
  wait_for_problem("");
  EXPECT_TRUE(hasPart(metricsAt(metrics_port), "\npcl_ext_link_connected 1\n"));
  server.stop();
  wait_for_problem("The connection to the server of site cell is lost");
  const std::string metrics = metricsAt(metrics_port);
  EXPECT_TRUE(hasPart(metrics, "\npcl_ext_link_connected 0\n"));
  EXPECT_TRUE(hasPart(metrics, "\npcl_ext_link_age_seconds{stream=\"/sensor\"} "));
  server.start();
  wait_for_problem("");
  // What is told alternates, however soon it is lost again.
  server.stop();
  wait_for_problem("The connection to the server of site cell is lost");
  server.start();
  wait_for_problem("");
  const auto times = [&](const std::string& text) {
    const std::regex part(text);
    const std::string errors = receiving.errors();
    return std::distance(std::sregex_iterator(errors.begin(), errors.end(), part), {});
  };
  EXPECT_TRUE(view::test::waitFor([&] { return times("is there again") == 2; }));
  EXPECT_EQ(times("is lost"), 2);
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
}

TEST_F(ProgramSiteState, ACentreThatIsTooSlowSaysSo)
{
  const std::uint16_t port = freePort();
  // A thousand merged frames a second are too many for any machine.
  Receiving receiving(folder,
                      at(server) +
                          "--merge all --merge-period 1ms --effort small "
                          "--metrics-port " +
                          std::to_string(port));
  SitePublisher sensor(server);
  const Bytes frame = iFrame(/* width */ 60);
  const auto start = std::chrono::steady_clock::now();
  const std::string told = "this machine is too slow for these streams: ";
  while (receiving.errors().find(told) == std::string::npos) { // ctest ends it
    sensor.publish(
        std::chrono::steady_clock::now() - start, frame, /* flushes */ false);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const std::string metrics = metricsAt(port);
  EXPECT_FALSE(hasPart(metrics, "\npcl_ext_merged_frames_left_out_total 0\n"));
  EXPECT_TRUE(hasPart(metrics, "\npcl_ext_merged_frames_left_out_total "));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  EXPECT_NE(receiving.errors().find(" left out; take ", receiving.errors().find(told)),
            std::string::npos)
      << receiving.errors();
  EXPECT_FALSE(hasPart(receiving.errors(), "--merge-age"));
}

TEST_F(ProgramSiteState, ACentreTellsWhyStreamsAreMissingInMergedFrames)
{
  Receiving receiving(
      folder,
      at(server) + "--merge all --merge-age 1500ms --max-voxels 1000 --resolution 0.1");
  const auto start = std::chrono::steady_clock::now();
  const auto publish = [&](SitePublisher& sensor, const Bytes& frame) {
    sensor.publish(std::chrono::steady_clock::now() - start, frame);
  };
  SitePublisher first(server, "/first");
  SitePublisher large(server, "/large");
  std::unique_ptr<SitePublisher> late;
  for (int i = 0; i < 80; ++i) {
    publish(first, iFrame());
    publish(large, iFrame(/* width */ 60));
    if (i == 20)
      late = std::make_unique<SitePublisher>(server, "/late");
    if (i >= 20 && i < 30)
      publish(*late, iFrame());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(receiving.end(SIGINT), 1);
  const std::string errors = receiving.errors();
  EXPECT_FALSE(hasPart(errors, "/first: missing"));
  const std::string at_large =
      errors.substr(std::min(errors.size(), errors.find("/large: missing in ")));
  EXPECT_TRUE(hasPart(at_large, ", as its last frame could not be decoded\n"))
      << errors;
  EXPECT_EQ(errors.find("/large: missing in ", errors.size() - at_large.size() + 1),
            std::string::npos)
      << errors;
  // Since it ended, and not before it began.
  EXPECT_TRUE(hasPart(errors, "/late: missing in "));
}

TEST_F(ProgramSiteState, WhatIsNotMergedAsItIsIsTold)
{
  auto clouds = roomClouds(5);
  writeClouds("room", clouds);
  for (auto& cloud : clouds)
    for (pcl::PointXYZI& point : cloud) {
      point.x += 500000.0f;
      point.y += 5400000.0f;
    }
  writeClouds("far", clouds);
  Receiving receiving(folder,
                      at(server) + "--merge all --map map.ot --resolution 0.5 "
                                   "--min-intensity 2 --remove-outliers --unit faces");
  expectRun("send -q room far --rate 20 -r 0.5 --law none" + at(server));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  EXPECT_TRUE(
      hasPart(receiving.errors(),
              "/far: Voxels are too far from those of other streams to be merged: in "))
      << receiving.errors();
  EXPECT_FALSE(hasPart(receiving.errors(), "/room: Voxels"));
  EXPECT_TRUE(hasPart(receiving.errors(),
                      "/room: its outliers stay: --unit is faces and the "
                      "intensity_law of the stream is none"));
  EXPECT_TRUE(hasPart(receiving.errors(),
                      "/room: its voxels have no intensities, so that --min-intensity "
                      "leaves none out"));
}

TEST_F(ProgramSiteState, AFullDiskEndsTheRecordingAndTheMapGoesOn)
{
  writeClouds("room", roomClouds(60));
  // A limit on the size of files in place of a full disk.
  Receiving receiving(folder,
                      at(server) + "-o x.mcap --map map.ot",
                      "trap '' XFSZ; ulimit -f 100; exec $P receive");
  expectRun("send -q room --rate 50 -r 0.02 --i-frame-rate 1" + at(server));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  EXPECT_TRUE(hasPart(receiving.errors(),
                      "; what was written until then is in 'x.mcap.unfinished'\n"))
      << receiving.errors();
  EXPECT_TRUE(std::filesystem::exists(folder / "map.ot"));
  EXPECT_TRUE(hasPart(receiving.output(), "nodes written to map.ot"));
  EXPECT_TRUE(hasPart(receiving.output(), "\nsite cell: 60 frames of 1 stream, "));
  EXPECT_TRUE(hasPart(receiving.output(), " of them recorded\n")) << receiving.output();
}

TEST_F(ProgramSiteState, AFileThatAnotherProgramWritesIsNotTakenForItsOwn)
{
  const Receiving receiving(folder, at(server) + "-o x.mcap");
  const ProgramRun other =
      expectRemark("receive -o x.mcap" + at(server),
                   "another program is writing 'x.mcap.unfinished'",
                   1);
  EXPECT_FALSE(hasPart(other.errors, "what was written"));
}

TEST_F(ProgramSiteState, AStreamOfAnotherClockIsToldAndTimesThatGoBackAre)
{
  Receiving receiving(folder, at(server) + "--merge all --merge-age 300ms");
  SitePublisher first(server, "/a");
  SitePublisher second(server, "/b");
  SitePublisher behind(server, "/behind");
  view::test::LiveSource source(1);
  for (int i = 0; receiving.errors().find("merged times go back") == std::string::npos;
       ++i) {
    const Bytes frame = source.next();
    const recording::Time time =
        std::chrono::hours(2) + std::chrono::milliseconds(50 * i);
    for (SitePublisher* const sensor : {&first, &second})
      if (i < 20)
        sensor->publish(time, frame);
    behind.publish(time - std::chrono::hours(1), frame);
    std::this_thread::sleep_for(std::chrono::milliseconds(50)); // ctest ends it
  }
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
  const std::string remark = ": its clock is more than 2 s from that of the other";
  EXPECT_TRUE(hasPart(receiving.errors(), "/behind" + remark)) << receiving.errors();
  EXPECT_FALSE(hasPart(receiving.errors(), "/a" + remark)) << receiving.errors();
}

TEST_F(ProgramSiteState, AMapThatIsTooSlowSaysSo)
{
  const std::uint16_t port = freePort();
  Receiving receiving(folder,
                      at(server) +
                          "--map map.ot --merge all --merge-period 1s --metrics-port " +
                          std::to_string(port));
  link::FramePublisher sensor(SitePublisher::settingsOf(server));
  ASSERT_TRUE(sensor.connect().ok());
  std::size_t stream = 0;
  // Whose rays are long.
  ASSERT_TRUE(
      sensor.addStream("/sensor", {{"sensor_pose", "30,30,30,1,0,0,0"}}, stream).ok());
  const Bytes frame = iFrame(/* width */ 60);
  const std::string told = "the map got ";
  // Clouds a second apart, as fast as they can be sent.
  for (int second = 0; receiving.errors().find(told) == std::string::npos; ++second) {
    sensor.publish(stream, std::chrono::seconds(second), frame.data(), frame.size());
    EXPECT_TRUE(sensor.flush(std::chrono::seconds(20))); // ctest ends it
  }
  const std::string metrics = metricsAt(port);
  EXPECT_TRUE(hasPart(metrics, "\npcl_ext_map_updates_total "));
  EXPECT_TRUE(hasPart(metrics, "\npcl_ext_map_updates_left_out_total "));
  EXPECT_FALSE(hasPart(metrics, "\npcl_ext_map_updates_left_out_total 0\n"));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  const std::string last = receiving.errors().substr(receiving.errors().rfind(told));
  EXPECT_TRUE(
      hasPart(last, " updates: this machine is too slow for a map of this resolution"));
}

TEST_F(ProgramSiteState, ASensorThatIsTooSlowSaysSo)
{
  const std::uint16_t port = freePort();
  BackgroundProgram sending(folder,
                            "exec $P send --cell --resolution 0.004 --effort small "
                            "--metrics-port " +
                                std::to_string(port) + at(server));
  sending.waitForError("sending robot cell to site cell");
  const std::string missed = "\npcl_ext_sender_clouds_missed_total{stream=\"/cell_";
  EXPECT_TRUE(view::test::waitFor([&] {
    const std::string metrics = metricsAt(port);
    const std::size_t at = metrics.find(missed);
    return at != std::string::npos &&
           metrics.substr(metrics.find("} ", at), 4) != "} 0\n";
  }));
  sending.end(SIGINT);
  EXPECT_TRUE(
      hasPart(sending.errors(), " left out, as this machine is too slow for them: "));
  EXPECT_TRUE(hasPart(sending.errors(), " a second of each sensor, not 20"));
}

TEST_F(ProgramSiteState, AnInterruptionBeforeTheServerAnswersIsToldAsThat)
{
  writeClouds("room", roomClouds(1));
  for (const std::string command : {"send room -r 0.05", "receive -o x.mcap"}) {
    const link::test::ListeningSocket silent;
    BackgroundProgram program(folder,
                              "exec $P " + command + " --server " + silent.url());
    const int connection = silent.accept();
    EXPECT_EQ(program.end(SIGINT), 130);
    EXPECT_TRUE(
        hasPart(program.errors(), ": interrupted before the server had answered"))
        << program.errors();
    ::close(connection);
  }
}

TEST_F(ProgramSiteState, ATerminalShowsHowFarItIs)
{
  const auto in_a_terminal = [&](const std::string& arguments) {
    return "export P; exec script --quiet --flush --return --command '$P " + arguments +
           at(server) + "' /dev/null";
  };
  // Ends by itself where a test's end does not reach it, as SIGHUP is ignored.
  const BackgroundProgram receiving(folder,
                                    in_a_terminal("receive -o all.mcap --for 100s"));
  receiving.waitForOutput("receiving from site");
  recordTwoStreams(folder / "sent.mcap");
  const BackgroundProgram sending(folder, in_a_terminal("send sent.mcap"));
  sending.waitForOutput(" a second, ");
  sending.waitForOutput(" kB/s, oldest ");
  receiving.waitForOutput("71 frames, 0.0 a second, 0.0 kB/s, oldest ");
  receiving.waitForOutput(" of 2 streams\x1b[K");
}

TEST_F(ProgramSiteState, VoxelsThatLeaveGapsAreTold)
{
  writeClouds("room", roomClouds(2));
  const std::string gaps = "/room: Voxels have an edge of 0.05 m, those of the merged "
                           "grid and the map 0.025 m, where they leave gaps: ";
  struct Row {
    std::string options;
    std::vector<std::string> edges; ///< that are sent, one after the other
    bool has_gaps;
  };
  for (const Row& row :
       {Row{"--map map.ot --resolution 0.025", {"0.05"}, true},
        {"--merge all --map other.ot --resolution 0.1", {"0.05"}, false},
        // What counts is the last one.
        {"--merge all --resolution 0.025", {"0.025", "0.05"}, true},
        {"--merge all --resolution 0.025", {"0.05", "0.025"}, false}}) {
    Receiving receiving(folder, at(server) + row.options);
    for (const std::string& edge : row.edges)
      expectRun("send -q room --rate 50 -r " + edge + at(server));
    EXPECT_EQ(receiving.end(SIGINT), row.has_gaps ? 1 : 0) << receiving.errors();
    EXPECT_EQ(hasPart(receiving.errors(), gaps), row.has_gaps) << receiving.errors();
  }
}

TEST_F(ProgramSiteState, AMapThatLacksVoxelsOrCannotBeWrittenTellsTheReason)
{
  pcl::PointCloud<pcl::PointXYZI> row; // the map ends at 1638.4 m
  for (const float x : {1637.3f, 1638.3f, 1638.5f, 1639.0f, 1640.0f})
    row.push_back(pcl::PointXYZI(x, 0.0f, 0.0f, 1.0f));
  writeClouds("row", {row});
  Receiving receiving(folder, at(server) + "--map map.ot");
  // A limit on the size of files in place of a full disk.
  Receiving full(folder,
                 at(server) + "--map full.ot",
                 "trap '' XFSZ; ulimit -f 2; exec $P receive");
  expectRun("send -q row --rate 50 -r 0.05" + at(server));
  writeClouds("room", roomClouds(2));
  expectRun("send -q room --rate 50 -r 0.02" + at(server));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  EXPECT_TRUE(
      hasPart(receiving.errors(), "are not in the map, 3 in all, as they are "));
  EXPECT_TRUE(std::filesystem::exists(folder / "map.ot"));
  EXPECT_EQ(full.end(SIGINT), 1);
  EXPECT_TRUE(
      hasPart(full.errors(),
              "The map could not be written to full.ot.unfinished: File too large"));
}

} // namespace pcl_ext::tools::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/link/frame_subscriber.h>

#include "support/stranger.h"
#include "tools/site_program.h"
#include "view/live_source.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <thread>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

using recording::Time;
using view::test::LiveSource;
using view::test::timeOfFrame;
using view::test::waitFor;

using ProgramLosses = SiteTest;

TEST_F(ProgramLosses, WhatCannotBeRecordedIsToldAndTheRestDecodes)
{
  Receiving receiving(folder, at(server) + "-o x.mcap");
  SitePublisher publisher(server);
  LiveSource source(1000);
  for (std::size_t i = 0; i < 40; ++i) {
    if (publisher.takeRequest())
      source.requestIFrame();
    Bytes frame = source.next();
    if (i == 20)
      frame.back() ^= 1;
    publisher.publish(i == 10 ? Time(-1) : timeOfFrame(i), frame);
    if (i == 10 || i == 20) {
      EXPECT_TRUE(waitFor([&] { return publisher.takeRequest(); }));
      source.requestIFrame();
      // The next request is not sent earlier.
      std::this_thread::sleep_for(link::SubscriberSettings().i_frame_request_interval);
    }
  }
  EXPECT_EQ(receiving.end(SIGINT), 1) << receiving.errors();
  EXPECT_TRUE(
      hasPart(receiving.errors(),
              "/sensor, frame 10: it is not recorded: a frame of a negative time"));
  EXPECT_TRUE(
      hasPart(receiving.errors(), "/sensor: 39 frames, 1 with a wrong checksum"));
  EXPECT_TRUE(hasPart(receiving.output(), "x.mcap: 38 frames"));
  EXPECT_EQ(decode(folder / "x.mcap").at(0).frames.size(), 38u);
}

TEST_F(ProgramLosses, FramesThatComeTwiceAreToldAndLoseNothing)
{
  Receiving receiving(folder, at(server) + "-o x.mcap");
  link::test::Stranger sensor(server);
  LiveSource source(1000);
  for (std::size_t i = 1; i <= 10; ++i) {
    const Bytes frame = source.next();
    const std::string header = "1 a " + std::to_string(i) + " 1000000";
    for (std::size_t times = 0; times < 1 + i % 2; ++times)
      sensor.publish("cell.sensor.frames", header, frame);
  }
  EXPECT_EQ(receiving.end(SIGINT), 0);
  EXPECT_TRUE(hasPart(receiving.errors(), "sensor: 5 frames late or repeated"));
  EXPECT_EQ(decode(folder / "x.mcap").at(0).frames.size(), 10u);
}

TEST_F(ProgramLosses, FramesThatNeedALostOneAreNotCopiedAndNotSent)
{
  KnownStream stream = knownStream(0, 30, 10);
  // Frame 3 is missing, and frame 14 has a wrong checksum.
  stream.frames[14].bytes.back() ^= 1;
  stream.frames.erase(stream.frames.begin() + 3);
  const Bytes damaged = framesOf(stream, 0, 29);
  writeBytes(folder / "damaged.pcxi", damaged);
  for (const std::string command : {"cut", "merge"}) {
    const std::string output = command + ".pcxi";
    const ProgramRun copied = run(command + " damaged.pcxi -o " + output);
    EXPECT_EQ(copied.status, 1);
    EXPECT_TRUE(
        hasPart(copied.output, output + ": 17 frames of 1 stream, 12 frames lost"));
    EXPECT_EQ(decode(folder / output).at(0).frames.size(), 17u);
  }
  for (const std::string input : {"damaged.pcxi", "- < damaged.pcxi"}) {
    SCOPED_TRACE(input);
    Receiving receiving(folder, at(server) + "--overwrite -o received.pcxi");
    const ProgramRun sent = run("send" + at(server) + input);
    EXPECT_EQ(sent.status, 1);
    EXPECT_TRUE(hasPart(sent.output, "17 frames sent"));
    EXPECT_TRUE(
        hasPart(sent.errors, "frame 3: left out, as a frame before it is missing"));
    EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
    EXPECT_EQ(bytesOf(folder / "received.pcxi"), bytesOf(folder / "cut.pcxi"));
  }
}

TEST_F(ProgramLosses,
       FramesThatCameAndWereLeftOutAreToldAndFailUnlessNoIFrameWasThereYet)
{
  const KnownStream stream = knownStream(0, 30, 10);
  const auto receive = [&](std::size_t first, std::size_t missing) {
    Receiving receiving(folder, at(server) + "--overwrite -o received.mcap");
    SitePublisher publisher(server);
    for (std::size_t i = first; i < stream.frames.size(); ++i)
      if (i != missing)
        publisher.publish(stream.frames[i].time, stream.frames[i].bytes);
    const int status = receiving.end(SIGINT);
    return std::make_pair(status, receiving.output() + receiving.errors());
  };
  const auto [gap_status, gap] = receive(0, 3);
  EXPECT_EQ(gap_status, 1);
  EXPECT_TRUE(hasPart(gap, "/sensor: 23 frames, 6 left out after a gap"));
  const auto [late_status, late] = receive(4, 30);
  EXPECT_EQ(late_status, 0);
  EXPECT_TRUE(hasPart(late, "20 frames of 1 stream"));
  EXPECT_TRUE(hasPart(late, "; 6 before the first I-frames left out"));
}

TEST_F(ProgramLosses, WhatAHangingServerDoesNotAnswerIsToldAndNotTheMachinesFault)
{
  writeClouds("room", roomClouds(200));
  Receiving receiving(folder, at(server) + "-o x.mcap");
  BackgroundProgram sending(
      folder, "exec $P send room --rate 20 --resolution 0.05" + at(server));
  EXPECT_TRUE(waitFor([&] {
    return fs::exists(folder / "x.mcap.unfinished") &&
           fs::file_size(folder / "x.mcap.unfinished") > 10000;
  }));
  server.hang();
  sending.waitForError("does not answer: frames are lost");
  receiving.waitForError("is lost");
  EXPECT_EQ(sending.end(SIGINT), 130) << sending.errors();
  EXPECT_TRUE(hasPart(sending.output(), " it is not known whether the server has "))
      << sending.output();
  EXPECT_FALSE(hasPart(sending.errors(), "too slow"));
  EXPECT_EQ(receiving.end(SIGINT), 1) << receiving.errors();
  EXPECT_TRUE(hasPart(receiving.errors(), "what was sent since then is missing"));
}

TEST_F(ProgramLosses, AFileOfOneStreamAsksForNoIFramesOfOthers)
{
  Receiving receiving(folder, at(server) + "-o x.pcxi");
  SitePublisher first(server);
  SitePublisher other(server, "/other");
  LiveSource source(1000);
  const Bytes i_frame = source.next();
  first.publish(timeOfFrame(0), i_frame);
  EXPECT_TRUE(waitFor([&] { return fs::exists(folder / "x.pcxi.unfinished"); }));
  other.publish(timeOfFrame(0), i_frame);
  receiving.waitForError("/other, frame 0: it is not recorded");
  for (std::size_t i = 1; i < 4; ++i) {
    const Bytes frame = source.next();
    first.publish(timeOfFrame(i), frame);
    other.publish(timeOfFrame(i), frame);
    // A request would come at once.
    std::this_thread::sleep_for(link::SubscriberSettings().i_frame_request_interval);
  }
  EXPECT_EQ(receiving.end(SIGINT), 1) << receiving.errors();
  EXPECT_FALSE(first.takeRequest());
  EXPECT_FALSE(other.takeRequest());
  EXPECT_TRUE(hasPart(receiving.errors(), "/other, frames 1 to 3: 3 more failures"));
  EXPECT_EQ(decode(folder / "x.pcxi").at(0).frames.size(), 4u);
}

} // namespace pcl_ext::tools::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "live/cloud_times.h"
#include "tools/cloud_bags.h"
#include "tools/site_program.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace pcl_ext::tools::test {

using link::test::freePort;

using ProgramSite = SiteTest;

TEST_F(ProgramSite, EncodesCloudsAndFollowsRequests)
{
  writeClouds("room", roomClouds(40));
  const std::uint16_t port = freePort();
  BackgroundProgram sending(
      folder,
      "exec $P send room --rate 20 --resolution 0.05 --prefix /north "
      "--metrics-port " +
          std::to_string(port) + at(server));
  sending.waitForError("sending room to site cell");
  // Without a request there is no other I-frame.
  Receiving receiving(folder, at(server) + "-o late.mcap");
  EXPECT_TRUE(view::test::waitFor([&] {
    return hasPart(metricsAt(port),
                   "pcl_ext_sender_frames_total{stream=\"/north/room\"}");
  })) << metricsAt(port);
  EXPECT_TRUE(hasPart(metricsAt(port), "pcl_ext_publisher_frames_not_sent_total 0\n"));
  EXPECT_EQ(sending.end(0), 0) << sending.errors();
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
  const std::vector<DecodedStream> received = decode(folder / "late.mcap");
  ASSERT_EQ(received.size(), 1u);
  EXPECT_EQ(received[0].name, "/north/room");
  EXPECT_GE(received[0].frames.size(), 10u);
  EXPECT_TRUE(received[0].frames[0].description.is_i_frame);
  EXPECT_EQ(received[0].frames[0].description.effort, io::Effort::Fast);
}

TEST_F(ProgramSite, TellsHowManyCloudsHadNoRoom)
{
  writeClouds("room", roomClouds(100));
  expectRun("encode room -q -o room.pcxi -r 0.05 --i-frame-rate 1");
  const std::size_t bits =
      8 * decode(folder / "room.pcxi").at(0).frames[0].bytes.size();
  const std::string options = "exec $P send room --rate 20 -r 0.05 --i-frame-rate 1 "
                              "--rate-doublings 0 --max-rate ";
  const std::uint16_t port = freePort();
  BackgroundProgram sending(folder,
                            options + std::to_string(5 * bits) +
                                "bit/s --metrics-port " + std::to_string(port) +
                                at(server));
  sending.waitForError("sending room to site cell");
  const auto value = [&](const std::string& metrics, const std::string& name) {
    const std::string begin = "\npcl_ext_sender_" + name + "_total{stream=\"/room\"} ";
    const std::size_t found = metrics.find(begin);
    return found == std::string::npos
               ? 0
               : std::stoi(metrics.substr(found + begin.size(), 8));
  };
  std::string metrics;
  EXPECT_TRUE(view::test::waitFor([&] {
    metrics = metricsAt(port);
    return value(metrics, "clouds_left_out") > 2;
  })) << metrics;
  EXPECT_EQ(value(metrics, "clouds"),
            value(metrics, "frames") + value(metrics, "clouds_left_out"));
  sending.end(SIGINT);
  EXPECT_TRUE(hasPart(sending.output(), " left out for --max-rate\n"));
}

TEST_F(ProgramSite, TellsWhatMaxRateHasChanged)
{
  writeClouds("room", roomClouds(20));
  const ProgramRun sent =
      run("send room --rate 20 -r 0.02 --max-rate 100kbit/s" + at(server));
  EXPECT_TRUE(hasPart(sent.errors, "/room: rate control, "));
  EXPECT_TRUE(hasPart(sent.errors, "at the end: voxels of "));
  writeClouds("few", roomClouds(5));
  const ProgramRun none = expectRemark(
      "send few --rate 20 -r 0.001 --rate-doublings 0 --max-rate 1kbit/s" + at(server),
      "/few: --max-rate has no room for any of its 5 clouds: ",
      1);
  EXPECT_FALSE(hasPart(none.errors, "max_rate"));
}

TEST_F(ProgramSite, PassesOnWhatAnotherProgramEncodes)
{
  writeClouds("room", roomClouds(5));
  Receiving receiving(folder, at(server) + "-o received.pcxi --map map.ot");
  const ProgramRun run = runShell(
      "\"$P\" encode room -q -o - | tee sent.pcxi | \"$P\" send -q -" + at(server));
  EXPECT_EQ(run.status, 0) << run.errors;
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
  EXPECT_EQ(bytesOf(folder / "received.pcxi"), bytesOf(folder / "sent.pcxi"));
  EXPECT_TRUE(hasPart(receiving.output(), "nodes written to map.ot"));
}

TEST_F(ProgramSite, TimesAreThoseOfTheCloudsNotOfTheirRecording)
{
  constexpr std::size_t clouds = 3;
  writeBag(folder / "clouds.mcap", clouds);
  expectRun("encode -q clouds.mcap -o frames.mcap");
  for (const std::string input : {"clouds", "frames"}) {
    const std::string output = input + "_received.mcap";
    Receiving receiving(folder, at(server) + "-o " + output);
    expectRun("send -q " + input + ".mcap" + at(server));
    EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
    const std::vector<DecodedStream> received = decode(folder / output);
    EXPECT_EQ(received.size(), 2u);
    for (const DecodedStream& stream : received) {
      ASSERT_EQ(stream.frames.size(), clouds) << stream.name;
      for (std::size_t i = 0; i < clouds; ++i) {
        EXPECT_EQ(stream.frames[i].stamp, stampOf(i));
        EXPECT_EQ(stream.frames[i].time, stampOf(i));
      }
    }
  }
}

TEST(CloudTimes, AreStampsUnlessTheFirstCloudHasNone)
{
  using recording::Time;
  CloudTimes stamped;
  EXPECT_EQ(stamped.timeOf(Time(5), Time(90)), Time(5));
  EXPECT_EQ(stamped.timeOf(Time(3), Time(91)), Time(3));   // a clock that was set back
  EXPECT_EQ(stamped.timeOf(Time(-1), Time(92)), Time(92)); // no time of a recording
  for (const Time first : {Time(0), Time(-1)}) {
    CloudTimes recorded;
    EXPECT_EQ(recorded.timeOf(first, Time(90)), Time(90));
    EXPECT_EQ(recorded.timeOf(Time(5), Time(91)), Time(91));
  }
}

TEST_F(ProgramSite, WhatIsKeptBeginsWithAnIFrame)
{
  const NatsServer keeping("jetstream { store_dir: \"FOLDER\" }");
  writeClouds("room", roomClouds(100));
  const std::uint16_t port = freePort();
  const BackgroundProgram sending(folder,
                                  "exec $P send room --rate 10 --resolution 0.05 "
                                  "--i-frame-rate 100000 --metrics-port " +
                                      std::to_string(port) + at(keeping));
  sending.waitForError("to site cell");
  // Until the first frame was sent, which is an I-frame.
  EXPECT_TRUE(view::test::waitFor([&] {
    const std::string metrics = metricsAt(port);
    return hasPart(metrics, "\npcl_ext_publisher_frames_total ") &&
           !hasPart(metrics, "\npcl_ext_publisher_frames_total 0\n");
  }));
  expectRun("keep --max-age 720h --max-size 1GB" + at(keeping));
  EXPECT_TRUE(hasPart(expectRun("keep" + at(keeping)).output,
                      "of the last 720 h, up to 1 GB;"));
  expectRun("receive -q --replay all -o kept.mcap" + at(keeping));
  EXPECT_TRUE(decode(folder / "kept.mcap")[0].frames[0].description.is_i_frame);
}

TEST_F(ProgramSite, TheFirstCloudWithPointsDecidesOnTheIntensities)
{
  const auto plain = [](const std::string& points, const std::string& data) {
    const std::string text =
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
        points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA ascii\n" + data;
    return Bytes(text.begin(), text.end());
  };
  writeClouds("empty", roomClouds(3));
  writeClouds("bare", roomClouds(3));
  writeBytes(folder / "empty/000.pcd", plain("0", ""));
  writeBytes(folder / "bare/000.pcd", plain("1", "1 2 3\n"));
  Receiving receiving(folder, at(server) + "-o received.mcap");
  EXPECT_EQ(
      expectRun("send -q empty --rate 50" + at(server)).output.rfind("3 frames", 0),
      0u);
  const std::string remark = "/bare, frame 1: its field 'intensity' is left out";
  EXPECT_TRUE(hasPart(run("send bare --rate 50" + at(server)).errors, remark));
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
  for (const DecodedStream& stream : decode(folder / "received.mcap")) {
    ASSERT_EQ(stream.voxels.size(), 3u) << stream.name;
    EXPECT_EQ(stream.voxels[0].pointCount(), stream.name == "/bare" ? 1u : 0u);
    EXPECT_EQ(stream.voxels[2].hasIntensities(), stream.name == "/empty");
  }
}

TEST_F(ProgramSite, OptionsWithoutEffectOnWhatIsSentAreRefused)
{
  recordTwoStreams(folder / "x.mcap");
  const std::string frames =
      "; 'x.mcap' has encoded frames, which are sent as they are: leave it out";
  for (const std::string option : {"--max-rate 1Mbit/s",
                                   "--crop 0,0,0,1,1,1",
                                   "-r 0.1",
                                   "--topics /a",
                                   "--bin-fields x,y,z",
                                   "--pose 0,0,0,0,0,0",
                                   "--remove-outliers",
                                   "--law none",
                                   "--no-header",
                                   "--fields all"})
    expectFailure("send x.mcap " + option + at(server), 2, " is for clouds" + frames);
  expectRefusals(
      2,
      {{"send x.mcap --rate 5" + at(server),
        "--rate is for files; 'x.mcap' has its own times"},
       {"send - -e small" + at(server),
        "--effort is for clouds; the standard input has encoded frames"},
       {"send --cell --pose 0,0,0,0,0,0" + at(server), "--pose is for inputs"},
       {"advise --cell --pose 0,0,0,0,0,0", "--pose is for inputs"}});
}

} // namespace pcl_ext::tools::test

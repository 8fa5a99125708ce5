// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/point_outlier_removal.h>

#include "support/lidar_room.h"
#include "tools/program.h"

#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <filesystem>

namespace pcl_ext::tools::test {

namespace {

namespace fs = std::filesystem;

using recording::test::knownStream;
using recording::test::record;

/** \brief Succeeds where programs get a terminal of their own. */
const std::string has_terminals = "script -qec true /dev/null > /dev/null < /dev/null";
constexpr const char* no_terminals = "the machine has no terminals: mount /dev/pts";

} // namespace

using ProgramOptions = ProgramTest;

TEST_F(ProgramOptions, OutputsThatCannotBeWrittenAreRefused)
{
  writeClouds("room", roomClouds(2));
  expectRun("encode room -o x.pcxi");
  // What is there is replaced with --overwrite alone, by all commands alike.
  expectRun("encode room -o y.mcap");
  const Bytes earlier = bytesOf(folder / "y.mcap");
  for (const std::string command : {"encode room/000.pcd",
                                    "cut x.pcxi --frames 0",
                                    "merge x.pcxi",
                                    "decode x.pcxi"}) {
    expectFailure(command + " -o y.mcap", 2, "exists: name another output, or");
    EXPECT_EQ(bytesOf(folder / "y.mcap"), earlier);
    expectRun(command + " -o y.mcap --overwrite");
    EXPECT_NE(bytesOf(folder / "y.mcap"), earlier);
    writeBytes(folder / "y.mcap", earlier);
  }
  expectRun("encode room -o bag");
  const Bytes recorded = bytesOf(folder / "bag/bag_0.mcap");
  for (const std::string output : {"bag/bag_0.mcap", "./bag/new.mcap"})
    expectFailure(
        "cut bag --frames 0 -o " + output, 2, "would be a part of the input 'bag'");
  EXPECT_EQ(bytesOf(folder / "bag/bag_0.mcap"), recorded);
  EXPECT_EQ(filesIn(folder / "bag"), 2u);
  // A terminal as the standard output.
  ASSERT_EQ(runShell(has_terminals).status, 0) << no_terminals;
  const ProgramRun terminal =
      runShell("export P; script -qec '\"$P\" encode room -o - 2> "
               "refused' typescript > typed < /dev/null");
  EXPECT_EQ(terminal.status, 2);
  EXPECT_TRUE(hasPart(textOf(folder / "refused"), "the standard output is a terminal"));
}

TEST_F(ProgramOptions, AStreamThatTheyAreNotForIsLeftOut)
{
  writeClouds("a", roomClouds(2));
  fs::create_directories(folder / "b");
  pcl::PointCloud<pcl::PointXYZ> plain;
  plain.push_back({0.0f, 0.0f, 1.0f});
  pcl::io::savePCDFileBinary(folder / "b/0.pcd", plain);
  const ProgramRun result = run("encode a b -o x.mcap --intensity-range 100");
  ASSERT_EQ(result.status, 1) << result.errors;
  EXPECT_TRUE(hasPart(result.errors,
                      "/b: its clouds are left out: --intensity-range has no "
                      "effect on clouds without intensities"));
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_EQ(streams[0].frames.size(), 2u);
}

TEST_F(ProgramOptions, WhatIsLeftOfAnOutputThatFailedIsTold)
{
  writeClouds("room", roomClouds(30));
  expectRun("encode room -o all.mcap -r 0.01 --i-frame-rate 1");
  // A limit on the size of files in place of a full disk.
  const std::string limit = "trap '' XFSZ; ulimit -f 100; \"$P\" ";
  for (const std::string command : {"encode room -o x.mcap -r 0.01 --i-frame-rate 1",
                                    "encode room -o x.pcxi -r 0.01 --i-frame-rate 1",
                                    "decode all.mcap -o y.mcap"}) {
    const ProgramRun result = runShell(limit + command);
    EXPECT_EQ(result.status, 1) << command;
    EXPECT_TRUE(hasPart(result.errors, "; what was written until then is in '"));
  }
  for (const std::string left : {"x.mcap", "x.pcxi", "y.mcap"}) {
    EXPECT_TRUE(fs::exists(folder / (left + ".unfinished")));
    EXPECT_FALSE(fs::exists(folder / left));
  }
}

TEST_F(ProgramOptions, FramesAndStreamsAreChosenAsPeopleWriteThem)
{
  writeClouds("room", roomClouds(5));
  expectRun("encode room -o x.mcap");
  expectRun("decode x.mcap -o bag.mcap");
  expectRun("encode bag.mcap -o small.mcap");
  // One number is one frame.
  const ProgramRun one = expectRun("decode small.mcap -o one --frames 3");
  EXPECT_TRUE(hasPart(one.output, "one: 1 frame, "));
  EXPECT_TRUE(fs::exists(folder / "one/000003.pcd"));
  // Streams by the topics of their clouds, with blanks after commas.
  expectRun("cut small.mcap -o a.mcap --streams /room");
  expectRun("cut small.mcap -o b.mcap --streams '/room/pcl_ext, room'");
  EXPECT_EQ(bytesOf(folder / "a.mcap"), bytesOf(folder / "b.mcap"));
}

TEST_F(ProgramOptions, FoldersWithoutANameAndStreamsWithoutSlash)
{
  writeClouds("room", roomClouds(2));
  expectRun("encode room -o a.mcap --pose /room=1,2,3,0,0,0");
  expectRun("encode room -o b.mcap --pose room=1,2,3,0,0,0");
  const ProgramRun result =
      runShell("cd room && \"$P\" encode . -o ../c.mcap --pose 1,2,3,0,0,0");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(bytesOf(folder / "a.mcap"), bytesOf(folder / "b.mcap"));
  EXPECT_EQ(bytesOf(folder / "a.mcap"), bytesOf(folder / "c.mcap"));
}

TEST_F(ProgramOptions, RemovedOutliersOfLidarsAreCountedAsPoints)
{
  pcl_ext::test::LidarRoom room;
  room.width = 180;
  room.height = 16;
  room.snow = 0.05;
  const pcl_ext::test::LidarScan scan = room.scan();
  writeClouds("lidar", {scan.cloud<pcl::PointCloud<pcl::PointXYZI>>()});
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  const std::size_t removed = removal.score(scan.view(), log_odds).removed;
  ASSERT_TRUE(removed > 50 && removed < 1000) << removed;
  const std::string points = " points removed as outliers by a lidar's rays";
  // With a remark that rows and columns are not kept.
  const std::string encode =
      "encode lidar --law count --remove-outliers --overwrite -o ";
  const ProgramRun judged = run(encode + "x.pcxi -r 0.05");
  EXPECT_EQ(judged.status, 0) << judged.errors;
  EXPECT_TRUE(hasPart(judged.output, std::to_string(removed) + " of 2,"));
  EXPECT_TRUE(hasPart(judged.output, points));
  EXPECT_FALSE(hasPart(judged.output, "voxels removed"));
  EXPECT_FALSE(hasPart(judged.output, "beyond box"));
  const std::string named = run(encode + "y.pcxi -r 0.05 --unit voxels").output;
  EXPECT_FALSE(hasPart(named, "lidar's rays"));
  EXPECT_TRUE(hasPart(named, " voxels removed as outliers"));
  // Points are judged at any edge, voxels are not.
  EXPECT_TRUE(hasPart(run(encode + "z.pcxi -r 0.25").output, points));
  const std::string refused =
      "--resolution is 0.25; it must be 0.001 to 0.2 m for outliers to be removed";
  expectFailure(encode + "z.pcxi -r 0.25 --unit rays", 2, refused);
  writeClouds("room", roomClouds(2));
  expectFailure("encode room -r 0.25 --remove-outliers -o w.pcxi", 2, refused);
}

TEST_F(ProgramOptions, WhyNoCloudHasRoomIsTold)
{
  writeClouds("room", roomClouds(5));
  const ProgramRun result =
      expectRemark("encode room -o x.mcap -r 0.001 --rate 10 --max-rate 1kbit/s "
                   "--rate-doublings 0",
                   " no room for any of its 5 clouds",
                   1);
  EXPECT_TRUE(
      hasPart(result.errors, "has room for 31 bytes now, the last frame that "));
}

TEST_F(ProgramOptions, AnAssumedRateOfCloudsIsToldWithABudget)
{
  writeClouds("room", roomClouds(2));
  const std::string told = "/room: nothing tells the times of its clouds: 10.0 Hz are ";
  const std::string encode = "encode room -o x.mcap --overwrite";
  EXPECT_TRUE(hasPart(run(encode + " --max-rate 1Gbit/s").errors, told));
  EXPECT_FALSE(hasPart(run(encode + " --max-rate 1Gbit/s --rate 10").errors, told));
  EXPECT_FALSE(hasPart(run(encode).errors, told));
}

TEST_F(ProgramOptions, WhatTheRateControlDoesToVoxelsIsTold)
{
  // Its voxels are too large to be judged, and its temporal filter hides and holds some.
  writeClouds("room", roomClouds(40));
  const std::string encode =
      "encode room --law count --rate 20 -o x.mcap --overwrite --remove-outliers -r ";
  const ProgramRun large = run(encode + "0.15 --max-rate 4kbit/s");
  EXPECT_TRUE(hasPart(large.errors, "/room: outliers stay in "));
  EXPECT_FALSE(hasPart(large.output, "judged by"));
  expectRemark("decode x.mcap -o decoded -q --remove-outliers",
               "outliers stay: no voxel was judged",
               1);
  const auto json = nlohmann::json::parse(
      run(encode + "0.02 --max-rate 100kbit/s --json").output)["bags"][0];
  const auto number = [&](const char* name) { return json[name].get<std::size_t>(); };
  EXPECT_EQ(json["frames"].get<std::size_t>() + number("clouds_left_out"), 40u);
  EXPECT_GT(number("voxels_hidden") + number("voxels_held"), 0u);
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.size(), 1u);
  std::size_t voxels = 0;
  for (const io::VoxelFrame& frame : streams[0].voxels)
    voxels += frame.size();
  EXPECT_EQ(number("voxels"), voxels);
  const ProgramRun text = run(encode + "0.02 --max-rate 100kbit/s");
  EXPECT_TRUE(hasPart(text.output, " hidden by the temporal filter"));
}

TEST_F(ProgramOptions, ProgressFitsANarrowTerminal)
{
  ASSERT_EQ(runShell(has_terminals).status, 0) << no_terminals;
  // It is interrupted as soon as there is a bar.
  const ProgramRun result = runShell(
      "export P; script -qefc 'stty cols 40; echo $$ > pid; exec \"$P\" demo --sensors "
      "1 "
      "-n 1000000 -o \"\" > table' typescript > typed < /dev/null & "
      "for i in $(seq 600); do grep -aq 'a second' typed && break; sleep 0.1; done; "
      "kill -INT $(cat pid); wait $!");
  EXPECT_EQ(result.status, 130);
  const std::string text = textOf(folder / "typed");
  EXPECT_TRUE(hasPart(text, " a second"));
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find_first_of("\r\n", begin)) != std::string::npos;
       begin = end + 1) {
    const std::string line = text.substr(begin, end - begin);
    EXPECT_LT(line.substr(0, line.find('\x1b')).size(), 40u) << line;
  }
}

} // namespace pcl_ext::tools::test

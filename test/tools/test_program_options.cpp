#include <pcl_ext/filters/point_outlier_removal.h>

#include "support/lidar_room.h"
#include "tools/program.h"

#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace pcl_ext {
namespace tools {
namespace test {

namespace {

namespace fs = std::filesystem;

using recording::test::knownStream;
using recording::test::record;

/** \brief Succeeds where programs get a terminal of their own. */
const std::string has_terminals = "script -qec true /dev/null > /dev/null < /dev/null";
constexpr const char* no_terminals = "the machine has no terminals: mount /dev/pts";

} // namespace

TEST(ProgramOptions, ThoseWithoutEffectAreRefused)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(2));
  expectRun(folder, "encode room -o x.mcap");
  expectRun(folder, "decode x.mcap -o bag.mcap");
  const auto expectRefusal = [&](const std::string& arguments,
                                 const std::string& text) {
    expectFailure(folder, arguments, 2, text);
  };
  expectRefusal("decode x.mcap -o y.mcap --ply", "--ply is for a folder of files");
  expectRefusal("decode x.mcap -o y.mcap --pcd ascii", "--pcd is for a folder");
  expectRefusal("decode x.mcap -o y --unit points",
                "--unit requires --remove-outliers");
  const std::string encode = "encode room -o y.pcxi ";
  expectRefusal(encode + "--unit points", "--unit requires --remove-outliers");
  expectRefusal(encode + "--sensor kinect_v2", "add --law quadratic");
  expectRefusal(encode + "--sensor kinect_v2 -l count", "add --law quadratic");
  expectRefusal(encode + "-l count --intensity-field a", "--intensity-field has no");
  expectRefusal(encode + "-l none --intensity-bits 4",
                "--intensity-bits has no effect");
  expectRefusal(encode + "-l none --aggregation sum", "--aggregation has no effect");
  expectRefusal(encode + "-l count --format published -e small", "--effort has no");
  expectRefusal(encode + "-l count --format published --colour-bits 5",
                "--colour-bits has no effect");
  expectRefusal(encode + "--no-header --frame-id hall", "--frame-id has no effect");
  expectRefusal(encode + "--sensor kinect_v2 -l linear --coarsen", "--coarsen has no");
  expectRefusal(encode + "--region 0,0,0,1,1,1", "must be x0,y0,z0,x1,y1,z1=EDGE");
  expectRefusal(encode + "--region 0,0,0,1,1,1=0.1,0.2", "one edge after =");
  expectRefusal(
      encode + "-r 0.05 --region 0,0,0,1,1,1=0.15",
      "the edge is 0.15 m; it must be --resolution (0.05 m) times 1, 2, 4, 8, "
      "16 or 32");
  expectRefusal(encode + "--outside left-out", "--outside requires --region");
  expectRefusal(encode + "--region-frame sensor", "--region-frame requires --region");
  expectRefusal(encode + "--most-doublings 2",
                "--most-doublings requires --coarser-beyond");
  expectRefusal(encode + "--coarser-beyond 5 --keep-point-counts",
                "--keep-point-counts is on; it must be off with regions");
  expectRefusal(encode + "--pose 0,0,0,0,0,0 --pose 1,0,0,0,0,0",
                "--pose is given twice");
  expectRefusal(encode + "--temporal-filter 8",
                "there is no '8'; as the number of --temporal-filter it is given as "
                "--temporal-filter=8");
  expectRefusal(encode + "--temporal-filter --keep-point-counts",
                "--keep-point-counts is on; it must be off with --temporal-filter");
  expectRefusal("encode bag.mcap -o y.mcap --rate 5", "--rate is for files");
  expectRefusal("demo --sensor kinect_v1 -n 1", "add --law quadratic");
  expectRefusal("merge x.mcap -o y.pcxi --prefix a", "--prefix has no effect");
  EXPECT_FALSE(fs::exists(folder / "y.pcxi"));
  EXPECT_FALSE(fs::exists(folder / "y.mcap"));
}

TEST(ProgramOptions, OutputsThatCannotBeWrittenAreRefused)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(2));
  expectRun(folder, "encode room -o x.pcxi");
  fs::create_directories(folder / "there");
  fs::create_directories(folder / "there.pcxi");
  for (const std::string command : {"encode room", "cut x.pcxi", "merge x.pcxi"}) {
    for (const std::string output : {"there", "there.pcxi"})
      expectFailure(folder, command + " -o " + output, 2, "exists: name another");
    for (const std::string output : {"/dev/null", "/dev/stdout", "/dev/full"})
      expectFailure(folder, command + " -o " + output, 2, "is no file or folder");
  }
  expectFailure(folder, "decode x.pcxi -o there --bag", 2, "exists: name another");
  // What is there is replaced with --overwrite alone, by all commands alike.
  expectRun(folder, "encode room -o y.mcap");
  const Bytes earlier = bytesOf(folder / "y.mcap");
  for (const std::string command : {"encode room/000.pcd",
                                    "cut x.pcxi --frames 0",
                                    "merge x.pcxi",
                                    "decode x.pcxi"}) {
    expectFailure(folder, command + " -o y.mcap", 2, "exists: name another output, or");
    EXPECT_EQ(bytesOf(folder / "y.mcap"), earlier);
    expectRun(folder, command + " -o y.mcap --overwrite");
    EXPECT_NE(bytesOf(folder / "y.mcap"), earlier);
    writeBytes(folder / "y.mcap", earlier);
  }
  expectFailure(folder, "decode x.pcxi -o /dev/null", 2, "is no file or folder");
  expectRun(folder, "encode room -o bag");
  const Bytes recorded = bytesOf(folder / "bag/bag_0.mcap");
  for (const std::string output : {"bag/bag_0.mcap", "./bag/new.mcap"})
    expectFailure(folder,
                  "cut bag --frames 0 -o " + output,
                  2,
                  "would be a part of the input 'bag'");
  EXPECT_EQ(bytesOf(folder / "bag/bag_0.mcap"), recorded);
  EXPECT_EQ(filesIn(folder / "bag"), 2u);
  // A terminal as the standard output.
  ASSERT_EQ(runShell(folder, has_terminals).status, 0) << no_terminals;
  const ProgramRun terminal =
      runShell(folder,
               "export P; script -qec '\"$P\" encode room -o - 2> "
               "refused' typescript > typed < /dev/null");
  EXPECT_EQ(terminal.status, 2);
  const Bytes refused = bytesOf(folder / "refused");
  EXPECT_NE(std::string(refused.begin(), refused.end())
                .find("the standard output is a terminal"),
            std::string::npos);
}

TEST(ProgramOptions, AStreamThatTheyAreNotForIsLeftOut)
{
  const TestFolder folder;
  writeClouds(folder, "a", roomClouds(2));
  fs::create_directories(folder / "b");
  pcl::PointCloud<pcl::PointXYZ> plain;
  plain.push_back({0.0f, 0.0f, 1.0f});
  pcl::io::savePCDFileBinary(folder / "b/0.pcd", plain);
  const ProgramRun result = run(folder, "encode a b -o x.mcap --intensity-range 100");
  ASSERT_EQ(result.status, 1) << result.errors;
  EXPECT_NE(result.errors.find("/b: its clouds are left out: --intensity-range has no "
                               "effect on clouds without intensities"),
            std::string::npos)
      << result.errors;
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_EQ(streams[0].frames.size(), 2u);
  // Before the first frame nothing is written.
  expectFailure(folder,
                "encode b a -o y.mcap --intensity-range 100",
                2,
                "has no effect on clouds without intensities");
  EXPECT_FALSE(fs::exists(folder / "y.mcap.unfinished"));
}

TEST(ProgramOptions, FullStandardOutputIsAFailure)
{
  const TestFolder folder;
  record({knownStream(0, 3, 3)}, folder / "x.pcxi");
  const std::string text = "cannot write to the standard output";
  expectFailure(folder, "info x.pcxi > /dev/full", 1, text);
  expectFailure(folder, "info --json x.pcxi > /dev/full", 1, text);
  expectFailure(folder, "verify x.pcxi > /dev/full", 1, text);
  expectFailure(folder, "--help > /dev/full", 1, text);
}

TEST(ProgramOptions, WhatIsLeftOfAnOutputThatFailedIsTold)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(30));
  expectRun(folder, "encode room -o all.mcap -r 0.01 --i-frame-rate 1");
  // A limit on the size of files in place of a full disk.
  const std::string limit = "trap '' XFSZ; ulimit -f 100; \"$P\" ";
  for (const std::string command : {"encode room -o x.mcap -r 0.01 --i-frame-rate 1",
                                    "encode room -o x.pcxi -r 0.01 --i-frame-rate 1",
                                    "decode all.mcap -o y.mcap"}) {
    const ProgramRun result = runShell(folder, limit + command);
    EXPECT_EQ(result.status, 1) << command;
    EXPECT_NE(result.errors.find("; what was written until then is in '"),
              std::string::npos)
        << result.errors;
  }
  for (const std::string left : {"x.mcap", "x.pcxi", "y.mcap"}) {
    EXPECT_TRUE(fs::exists(folder / (left + ".unfinished")));
    EXPECT_FALSE(fs::exists(folder / left));
  }
}

TEST(ProgramOptions, MessagesNameOptions)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(1));
  expectFailure(
      folder, "encode room -o x.pcxi -r 1e-5 --remove-outliers", 2, "--resolution is");
  const ProgramRun range = run(folder, "encode room -o x.pcxi --intensity-range 10");
  EXPECT_NE(
      range.errors.find("use a larger --intensity-range or more --intensity-bits"),
      std::string::npos)
      << range.errors;
}

TEST(ProgramOptions, FramesOfTheTemporalFilterAreFewAndWhole)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(1));
  for (const std::string frames : {"1", "65", "4.5", "-8", "0x8", "many"})
    expectFailure(folder,
                  "encode room -o x.pcxi --temporal-filter=" + frames,
                  2,
                  "--temporal-filter: '" + frames +
                      "' is no whole number from 2 to 64, or 0");
}

TEST(ProgramOptions, NanIsNoNumber)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(1));
  for (const char* option : {"--rate", "--resolution", "--intensity-range"})
    expectFailure(folder,
                  std::string("encode room -o x.mcap ") + option + " nan",
                  2,
                  std::string(option) + ": 'nan' is no number");
  expectRun(folder, "encode room -o x.mcap");
  expectFailure(folder,
                "decode x.mcap -o out --min-intensity nan",
                2,
                "--min-intensity: 'nan' is no number");
}

TEST(ProgramOptions, FramesAndStreamsAreChosenAsPeopleWriteThem)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(5));
  expectRun(folder, "encode room -o x.mcap");
  expectRun(folder, "decode x.mcap -o bag.mcap");
  expectRun(folder, "encode bag.mcap -o small.mcap");
  // One number is one frame.
  const ProgramRun one = expectRun(folder, "decode small.mcap -o one --frames 3");
  EXPECT_NE(one.output.find("one: 1 frame, "), std::string::npos) << one.output;
  EXPECT_TRUE(fs::exists(folder / "one/000003.pcd"));
  // Streams by the topics of their clouds, with blanks after commas.
  expectRun(folder, "cut small.mcap -o a.mcap --streams /room");
  expectRun(folder, "cut small.mcap -o b.mcap --streams '/room/pcl_ext, room'");
  EXPECT_EQ(bytesOf(folder / "a.mcap"), bytesOf(folder / "b.mcap"));
  expectFailure(folder,
                "cut small.mcap -o c.mcap --from 2 --to 1",
                2,
                "--from must be less than --to");
  expectFailure(folder, "cut one.mcap -o c.mcap", 1, "cannot open 'one.mcap'");
}

TEST(ProgramOptions, FoldersWithoutANameAndStreamsWithoutSlash)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(2));
  expectRun(folder, "encode room -o a.mcap --pose /room=1,2,3,0,0,0");
  expectRun(folder, "encode room -o b.mcap --pose room=1,2,3,0,0,0");
  const ProgramRun result =
      runShell(folder, "cd room && \"$P\" encode . -o ../c.mcap --pose 1,2,3,0,0,0");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(bytesOf(folder / "a.mcap"), bytesOf(folder / "b.mcap"));
  EXPECT_EQ(bytesOf(folder / "a.mcap"), bytesOf(folder / "c.mcap"));
}

TEST(ProgramOptions, RemovedOutliersAreCounted)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(2));
  const ProgramRun result =
      expectRun(folder, "encode room -o x.pcxi -r 0.05 --law count --remove-outliers");
  EXPECT_NE(result.output.find(" voxels removed as outliers"), std::string::npos)
      << result.output;
}

TEST(ProgramOptions, ThatHardlyAnyOutlierIsRemovedIsToldWithTheRemedy)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(2));
  const std::string remedy = "a depth camera's noise is found with --law count or "
                             "quadratic; of a lidar, points "
                             "are judged where its clouds are in its own coordinates";
  const std::string command =
      "encode room -o x.pcxi --overwrite -r 0.05 --remove-outliers";
  const ProgramRun blind = run(folder, command + " --law none");
  EXPECT_EQ(blind.status, 0);
  EXPECT_NE(blind.errors.find(remedy), std::string::npos) << blind.errors;
  expectRun(folder, command + " --law count");
}

TEST(ProgramOptions, RemovedOutliersOfLidarsAreCountedAsPoints)
{
  const TestFolder folder;
  pcl_ext::test::LidarRoom room;
  room.width = 180;
  room.height = 16;
  room.snow = 0.05;
  const pcl_ext::test::LidarScan scan = room.scan();
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (std::size_t i = 0; i < scan.size(); ++i)
    cloud.push_back({scan.coordinates[3 * i],
                     scan.coordinates[3 * i + 1],
                     scan.coordinates[3 * i + 2],
                     1.0f});
  cloud.width = scan.width;
  cloud.height = scan.height;
  cloud.is_dense = false;
  writeClouds(folder, "lidar", {cloud});
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  const std::size_t removed = removal.score(scan.view(), log_odds).removed;
  const auto returns = std::count_if(
      scan.ranges.begin(), scan.ranges.end(), [](float range) { return range > 0.0f; });
  ASSERT_GT(removed, 50u);
  const std::string encode = "encode lidar -r 0.05 --law count --remove-outliers ";
  ASSERT_TRUE(removed < 1000 && returns > 1999 && returns < 3000) << returns;
  const std::string points = std::to_string(removed) + " of 2," +
                             std::to_string(returns).substr(1) +
                             " points removed as outliers by a lidar's rays";
  // With a remark that rows and columns are not kept.
  const ProgramRun judged = run(folder, encode + "-o x.pcxi");
  EXPECT_EQ(judged.status, 0) << judged.errors;
  const std::string& output = judged.output;
  EXPECT_NE(output.find(points), std::string::npos) << output;
  EXPECT_EQ(output.find("voxels removed"), std::string::npos) << output;
  EXPECT_EQ(output.find("beyond box"), std::string::npos) << output;
  const std::string named = run(folder, encode + "-o y.pcxi --unit voxels").output;
  EXPECT_EQ(named.find("lidar's rays"), std::string::npos) << named;
  EXPECT_NE(named.find(" voxels removed as outliers"), std::string::npos) << named;
}

TEST(ProgramOptions, ProgressFitsANarrowTerminal)
{
  const TestFolder folder;
  ASSERT_EQ(runShell(folder, has_terminals).status, 0) << no_terminals;
  // It is interrupted as soon as there is a bar.
  const ProgramRun result = runShell(
      folder,
      "export P; script -qefc 'stty cols 40; echo $$ > pid; exec \"$P\" demo --sensors "
      "1 "
      "-n 1000000 -o \"\" > table' typescript > typed < /dev/null & "
      "for i in $(seq 600); do grep -aq 'a second' typed && break; sleep 0.1; done; "
      "kill -INT $(cat pid); wait $!");
  EXPECT_EQ(result.status, 130);
  const Bytes typed = bytesOf(folder / "typed");
  const std::string text(typed.begin(), typed.end());
  EXPECT_NE(text.find(" a second"), std::string::npos) << text;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find_first_of("\r\n", begin)) != std::string::npos;
       begin = end + 1) {
    const std::string line = text.substr(begin, end - begin);
    EXPECT_LT(line.substr(0, line.find('\x1b')).size(), 40u) << line;
  }
}

} // namespace test
} // namespace tools
} // namespace pcl_ext

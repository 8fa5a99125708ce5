// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "support/lidar_room.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

using ProgramDecode = ProgramTest;

TEST_F(ProgramDecode, FilesOfAllKindsHaveTheVoxels)
{
  const std::vector<KnownStream> streams = {knownStream(0, 6, 3)};
  record(streams, folder / "x.pcxi");
  for (const std::string option :
       {"", "--pcd binary", "--pcd compressed", "--pcd ascii", "--ply"}) {
    SCOPED_TRACE(option);
    expectRun("decode x.pcxi -o out --overwrite " + option);
    EXPECT_EQ(filesIn(folder / "out"), 6u);
    for (std::size_t i = 0; i < 6; ++i)
      expectVoxels(streams[0].frames[i].voxels,
                   readCloud(folder / ("out/00000" + std::to_string(i) +
                                       (option == "--ply" ? ".ply" : ".pcd"))));
  }
  EXPECT_FALSE(fs::exists(folder / "out.unfinished"));
}

TEST_F(ProgramDecode, WhatHasTheNameOfItsUnfinishedFolderStays)
{
  record({knownStream(0, 3, 3)}, folder / "x.pcxi");
  fs::create_directory(folder / "out.unfinished");
  writeBytes(folder / "out.unfinished/notes.txt", {1, 2, 3});
  expectRun("decode x.pcxi -o out");
  EXPECT_EQ(filesIn(folder / "out"), 3u);
  EXPECT_EQ(bytesOf(folder / "out.unfinished/notes.txt"), (Bytes{1, 2, 3}));
  EXPECT_FALSE(fs::exists(folder / "out.unfinished.1"));
}

TEST_F(ProgramDecode, RunsAtOnceDoNotMixTheirFiles)
{
  record({knownStream(0, 20, 3)}, folder / "x.pcxi");
  const ProgramRun runs = runShell(
      "for i in 1 2 3 4; do $P decode x.pcxi -o out -q --overwrite --pcd ascii "
      "& done; wait");
  EXPECT_EQ(filesIn(folder / "out"), 20u) << runs.errors;
}

TEST_F(ProgramDecode, StreamsHaveFoldersAndFramesAreChosen)
{
  const std::vector<KnownStream> streams = recordTwoStreams(folder / "x.mcap");
  expectRun("decode x.mcap -o by_number --frames 12:15");
  for (std::size_t stream = 0; stream < 2; ++stream) {
    const std::string of_stream = "by_number/sensor_" + std::to_string(stream);
    EXPECT_EQ(filesIn(folder / of_stream), 3u);
    for (std::size_t i = 12; i < 15; ++i)
      expectVoxels(
          streams[stream].frames[i].voxels,
          readCloud(folder / (of_stream + "/0000" + std::to_string(i) + ".pcd")));
  }
  // Frames are 50 ms apart; stream 1 is a millisecond behind.
  expectRun("decode x.mcap -o by_time --from 0.5 --to 0.601 --streams /sensor_1");
  EXPECT_EQ(filesIn(folder / "by_time"), 2u);
  expectVoxels(streams[1].frames[10].voxels, readCloud(folder / "by_time/000010.pcd"));
  expectVoxels(streams[1].frames[11].voxels, readCloud(folder / "by_time/000011.pcd"));
}

TEST_F(ProgramDecode, VoxelsAreFiltered)
{
  const std::vector<KnownStream> streams = {knownStream(0, 3, 3)};
  record(streams, folder / "x.pcxi");
  expectRun("decode x.pcxi -o faint --min-intensity 5");
  io::VoxelFrame kept = streams[0].frames[2].voxels;
  ASSERT_GT(removeVoxelsBelow(kept, 5.0f), 0u);
  expectVoxels(kept, readCloud(folder / "faint/000002.pcd"));
  expectRun("decode x.pcxi -o clean --remove-outliers --unit points");
  VoxelOutlierRemoval removal({PointsUnit()});
  for (std::size_t i = 0; i < 3; ++i) {
    io::VoxelFrame voxels = streams[0].frames[i].voxels;
    ASSERT_TRUE(removal.filter(voxels).ok());
    if (!voxels.keys.empty())
      expectVoxels(voxels,
                   readCloud(folder / ("clean/00000" + std::to_string(i) + ".pcd")));
  }
}

TEST_F(ProgramDecode, ScansWithoutIntensitiesOfVoxelsAreToldOf)
{
  writeClouds("room", roomClouds(1));
  const std::string remark = "/room: its voxels have no intensities, so that "
                             "--min-intensity leaves none out";
  EXPECT_EQ(run("encode room -o x.mcap --keep-order --fields all").status, 0);
  EXPECT_TRUE(hasPart(run("decode x.mcap -o out --min-intensity 1000").errors,
                      remark + "; those of its points are a further field: encode with "
                               "--law native\n"));
  EXPECT_EQ(run("encode room -o y.mcap --keep-order --law none").status, 0);
  const ProgramRun bare = run("decode y.mcap -o bare --min-intensity 1000");
  EXPECT_TRUE(hasPart(bare.errors, remark + "\n"));
  EXPECT_EQ(bare.status, 1);
}

/** \brief A room with noise away from its surfaces. */
std::vector<pcl::PointCloud<pcl::PointXYZI>>
snowyRoom(int count)
{
  auto clouds = roomClouds(count);
  std::mt19937_64 random(6);
  for (auto& cloud : clouds)
    for (int i = 0; i < 50; ++i) {
      pcl::PointXYZI point;
      point.x = io::test::uniform(random, -1.0, 1.0);
      point.y = io::test::uniform(random, -1.0, 1.0);
      point.z = io::test::uniform(random, 0.2, 1.2);
      cloud.push_back(point);
    }
  return clouds;
}

TEST_F(ProgramDecode, OutliersAreJudgedByTheLawAndThePoseOfTheRecording)
{
  writeClouds("room", snowyRoom(2));
  expectRun("encode room -o x.mcap -r 0.05 --law count --pose 4,1,2,0,0,0");
  const std::string decode = "decode x.mcap --remove-outliers -o ";
  EXPECT_TRUE(hasPart(expectRun(decode + "automatic").output,
                      "of the voxels or points left out, judged by points"));
  expectRun(decode + "points --unit points");
  // The room is far sparser than a lidar there would see it.
  EXPECT_TRUE(
      hasPart(expectRemark(decode + "pose --unit rays",
                           "more than noise usually is; --sensor-position tells")
                  .output,
              "of the voxels or points left out, judged by rays"));
  run(decode + "option --unit rays --sensor-position 4,1,2");
  expectRun(decode + "elsewhere --unit rays --sensor-position 0,9,9");
  const auto last = [&](const std::string& of) {
    return bytesOf(folder / (of + "/000001.pcd"));
  };
  EXPECT_EQ(last("automatic"), last("points"));
  EXPECT_EQ(last("pose"), last("option"));
  EXPECT_NE(last("pose"), last("elsewhere"));
  // Frames alone do not tell their law. By faces all voxels would be removed.
  expectRun("encode room -o x.pcxi -r 0.05 --law count");
  expectRemark("decode x.pcxi -o c --remove-outliers", "--unit points");
  expectFailure(
      "decode x.pcxi -o d --remove-outliers --unit faces",
      1,
      "more than noise usually is; for counts name --unit points, for a lidar "
      "--unit rays");
  // A unit must fit the law.
  expectFailure(decode + "e --unit faces",
                2,
                "/room: --unit is faces and the intensity_law of the stream is "
                "count, whose intensities are numbers of points; choose automatic or "
                "points");
  expectRun("encode room -o native.mcap -r 0.05 --law native -q");
  expectFailure("decode native.mcap -o f --remove-outliers --unit points",
                2,
                "is native, whose intensities are no densities");
  // Numbers of points that the frames have are densities.
  expectRun("encode room -o kept.mcap -r 0.2 --law native --keep-points -q");
  EXPECT_NE(run("decode kept.mcap -o g --remove-outliers --unit points").status, 2);
}

TEST_F(ProgramDecode, WhereHardlyAnyVoxelIsLeftOutLidarsAreToldOfRays)
{
  writeClouds("room", snowyRoom(2));
  for (const char* law : {"none", "native"}) {
    expectRun(std::string("encode room -o x.mcap --overwrite -r 0.05 --law ") + law);
    const ProgramRun automatic =
        run(std::string("decode x.mcap --remove-outliers -o ") + law);
    EXPECT_EQ(automatic.status, 0);
    EXPECT_TRUE(hasPart(automatic.output, "judged by voxels"));
    EXPECT_TRUE(hasPart(
        automatic.errors,
        "removed as outliers: for a lidar, --unit rays finds noise such as snow"));
  }
  // Named, it says nothing.
  EXPECT_EQ(expectRun("decode x.mcap -o rays --remove-outliers --unit rays").errors,
            "");
}

TEST_F(ProgramDecode, CountsOfALidarAreNotJudgedAsThoseOfACamera)
{
  pcl_ext::test::LidarRoom room;
  writeClouds("lidar", {room.scan().cloud<pcl::PointCloud<pcl::PointXYZI>>()});
  EXPECT_EQ(run("encode lidar -o x.mcap -r 0.1 --law count").status, 0);
  const ProgramRun automatic =
      expectRemark("decode x.mcap -o automatic --remove-outliers",
                   "for a lidar, --unit rays finds noise such as snow");
  EXPECT_TRUE(hasPart(automatic.output, "judged by voxels"));
  EXPECT_FALSE(hasPart(automatic.errors, "does not tell"));
  expectRun("decode x.mcap -o all");
  run("decode x.mcap -o points --remove-outliers --unit points");
  const auto pointsIn = [&](const std::string& of) {
    return readCloud(folder / (of + "/000000.pcd")).size();
  };
  EXPECT_GE(100 * pointsIn("automatic"), 98 * pointsIn("all"));
  EXPECT_LE(100 * pointsIn("points"), 95 * pointsIn("all"));
}

TEST_F(ProgramDecode, FolderOfTheUserIsNotTouched)
{
  record({knownStream(0, 3, 3)}, folder / "x.pcxi");
  fs::create_directories(folder / "out");
  for (const std::string name : {"notes", "000001", "000007"})
    writeBytes(folder / ("out/" + name + ".pcd"), {1});
  expectFailure("decode x.pcxi -o out", 2, "is not empty");
  // One that no new one replaces may be the user's; the others would be mixed with it.
  expectFailure(
      "decode x.pcxi -o out --overwrite",
      1,
      "1 cloud that pcl_ext has not written, such as 'out/000007.pcd', would be "
      "mixed with the new ones, which are in '");
  EXPECT_EQ(filesIn(folder / "out"), 3u);
  EXPECT_EQ(bytesOf(folder / "out/000001.pcd").size(), 1u);
  EXPECT_EQ(filesIn(folder / "out.unfinished"), 3u);
  fs::remove(folder / "out/000007.pcd");
  expectRun("decode x.pcxi -o out --overwrite");
  EXPECT_EQ(bytesOf(folder / "out/notes.pcd").size(), 1u);
  EXPECT_GT(bytesOf(folder / "out/000001.pcd").size(), 1u);
  EXPECT_EQ(filesIn(folder / "out"), 4u);
}

TEST_F(ProgramDecode, CloudsOfOtherStreamsAreNeitherMixedInNorRemoved)
{
  recordTwoStreams(folder / "x.mcap");
  expectRun("decode x.mcap -o out --frames 0:2");
  writeBytes(folder / "out/sensor_1/notes.txt", {1});
  expectRun("cut x.mcap -o one.mcap --streams /sensor_0 --frames 0:1");
  expectFailure("decode one.mcap -o out --overwrite", 2, "remove them, or name");
  EXPECT_TRUE(fs::exists(folder / "out/sensor_0/000001.pcd"));
  EXPECT_TRUE(fs::exists(folder / "out/sensor_1/000001.pcd"));
  // The streams' own are replaced, and files of other names stay.
  expectRun("decode x.mcap -o out --frames 0:1 --overwrite");
  EXPECT_TRUE(fs::exists(folder / "out/sensor_1/000000.pcd"));
  EXPECT_FALSE(fs::exists(folder / "out/sensor_1/000001.pcd"));
  EXPECT_TRUE(fs::exists(folder / "out/sensor_1/notes.txt"));
}

TEST_F(ProgramDecode, FoldersThatAreLinksGetAndKeepClouds)
{
  record({knownStream(0, 3, 1)}, folder / "x.mcap");
  fs::create_directory(folder / "real");
  fs::create_directory_symlink("real", folder / "link");
  expectRun("decode x.mcap -o link");
  EXPECT_EQ(filesIn(folder / "real"), 3u);
  expectRun("decode x.mcap -o link --frames 1:2 --overwrite");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(filesIn(folder / "real"), 1u);
  EXPECT_FALSE(fs::exists(folder / "real.unfinished"));
}

TEST_F(ProgramDecode, NamesOfStreamsDoNotLeaveTheFolder)
{
  std::vector<KnownStream> streams = {knownStream(0, 1, 1), knownStream(1, 1, 1)};
  streams[0].name = "/../../escaped";
  streams[1].name = "..";
  record(streams, folder / "x.mcap");
  expectRun("decode x.mcap -o out");
  EXPECT_EQ(filesIn(folder / "out"), 2u);
  EXPECT_TRUE(fs::exists(folder / "out/______escaped/000000.pcd"));
  EXPECT_TRUE(fs::exists(folder / "out/__/000000.pcd"));
}

} // namespace pcl_ext::tools::test

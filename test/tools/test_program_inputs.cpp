// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"
#include "tools/program.h"

#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace pcl_ext::tools::test {

namespace {

namespace fs = std::filesystem;

std::size_t
linesOf(const std::string& text)
{
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/** \brief A PLY file of a few points, or none; intensity 7 if the points have it. */
Bytes
plyOf(std::size_t points, bool has_intensity)
{
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points) +
                     "\nproperty float x\nproperty float y\nproperty float z\n" +
                     (has_intensity ? "property float intensity\n" : "") +
                     "end_header\n";
  for (std::size_t i = 0; i < points; ++i)
    text += std::to_string(i) + " 0 0" + (has_intensity ? " 7\n" : "\n");
  return {text.begin(), text.end()};
}

} // namespace

using ProgramInputs = ProgramTest;

TEST_F(ProgramInputs, StandardInputAndPipesHaveNames)
{
  writeClouds("room", roomClouds(3));
  expectRun("encode room -o x.pcxi");
  ASSERT_EQ(runShell("mkfifo pipe pipe2").status, 0);
  const std::string info = "> out.txt && $P info y.mcap --json && rm y.mcap";
  const std::pair<const char*, std::string> rows[] = {
      {"stdin", "cat x.pcxi | $P info - --json"},
      {"stdin", "$P info - --json < x.pcxi"},
      {"/stdin", "cat x.pcxi | $P cut - -o y.mcap " + info},
      {"/stdin", "cat room/000.pcd | $P encode - -o y.mcap " + info},
      {"/pipe", "cat room/000.pcd > pipe & $P encode pipe -o y.mcap " + info},
      {"/pipe2", "cat x.pcxi > pipe2 & $P cut pipe2 -o y.mcap " + info}};
  for (const auto& [name, line] : rows) {
    const ProgramRun result = runShell(line);
    EXPECT_EQ(result.status, 0) << line;
    EXPECT_EQ(result.errors, "") << line;
    const nlohmann::json streams = nlohmann::json::parse(result.output)["streams"];
    ASSERT_EQ(streams.size(), 1u) << line;
    EXPECT_EQ(streams[0]["name"], name) << line;
  }
}

TEST_F(ProgramInputs, FilesAndFramesComeThroughPipesAsTheyAre)
{
  writeClouds("room", roomClouds(3));
  expectRun("encode room/000.pcd -o one.pcxi");
  expectRun("encode room -o x.pcxi");
  const ProgramRun piped =
      runShell("mkfifo pipe; cat room/000.pcd | $P encode - -o input.pcxi -q && "
               "{ cat room/000.pcd > pipe & } && $P encode pipe -o named.pcxi -q && "
               "$P encode room -o - -q | $P decode - -o out -q && "
               "$P encode room -o - -q | $P cut - -o part.pcxi --frames 0:2");
  EXPECT_EQ(piped.status, 0) << piped.errors;
  EXPECT_EQ(bytesOf(folder / "input.pcxi"), bytesOf(folder / "one.pcxi"));
  EXPECT_EQ(bytesOf(folder / "named.pcxi"), bytesOf(folder / "one.pcxi"));
  const DecodedStream whole = decode(folder / "x.pcxi")[0];
  expectVoxels(whole.voxels[0], readCloud(folder / "out/000000.pcd"));
  EXPECT_EQ(decode(folder / "part.pcxi")[0].frames.size(), 2u);
  expectSameFrames(whole, 0, decode(folder / "part.pcxi")[0]);
}

TEST_F(ProgramInputs, HugeFilesOfZerosAreNoRecordings)
{
  for (const char* extension : {"mcap", "pcxi", "pcd", "ply", "bin"}) {
    SCOPED_TRACE(extension);
    const std::string name = std::string("x.") + extension;
    writeBytes(folder / name, {});
    fs::resize_file(folder / name, std::uintmax_t{1} << 36);
    EXPECT_EQ(run("encode " + name + " -o y.pcxi").status, 1);
    expectFailure("info " + name, 1, "is not a recording");
  }
}

TEST_F(ProgramInputs, WhatIsLeftOutOfAFolderIsTold)
{
  writeClouds("room", roomClouds(2));
  writeClouds("room/rear", roomClouds(1));
  writeBytes(folder / "room/notes.txt", {1});
  writeBytes(folder / "room/.hidden", {1});
  const ProgramRun result = run("encode room -o x.pcxi");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors,
            "pcl_ext encode: 'room': left out: 1 folder (rear) and 1 other file "
            "(notes.txt); each folder that is named is a stream\n");
  expectRun("encode room -o x.pcxi --quiet --overwrite");
  ASSERT_EQ(runShell("mkfifo room/002.pcd").status, 0);
  EXPECT_TRUE(hasPart(run("encode room -o y.pcxi").errors, "2 other files (002.pcd"));
}

TEST_F(ProgramInputs, FilesOfSeveralFoldersAreAStreamForEach)
{
  writeClouds("front", roomClouds(3, 1));
  writeClouds("rear", roomClouds(2, 2));
  expectRun("encode front rear -o folders.mcap");
  expectRun("encode '*/0*.pcd' -o pattern.mcap");
  expectRun("encode front/*.pcd rear/*.pcd -o names.mcap");
  const std::vector<DecodedStream> streams = decode(folder / "folders.mcap");
  for (const std::string file : {"pattern.mcap", "names.mcap"}) {
    const std::vector<DecodedStream> others = decode(folder / file);
    ASSERT_EQ(others.size(), 2u) << file;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(others[i].name, streams[i].name);
      EXPECT_EQ(others[i].frames.size(), streams[i].frames.size());
      expectSameFrames(streams[i], 0, others[i]);
    }
  }
  const ProgramRun one = expectRemark("encode '*/0*.pcd' -o one.pcxi",
                                      "files of 2 folders become one stream");
  EXPECT_EQ(decode(folder / "one.pcxi")[0].frames.size(), 5u);
}

TEST_F(ProgramInputs, QosOfABagsMetadataIsKept)
{
  writeClouds("room", roomClouds(2));
  expectRun("encode room -o x.mcap");
  expectRun("decode x.mcap -o bag --bag");
  std::string text = textOf(folder / "bag/metadata.yaml");
  const std::string key = "offered_qos_profiles: \"";
  ASSERT_TRUE(hasPart(text, key));
  text.insert(text.find(key) + key.size(), "- durability: 1\\n  depth: 2");
  writeText(folder / "bag/metadata.yaml", text);
  expectRun("encode bag -o small");
  expectRun("decode small -o again.mcap");
  expectRun("cut small -o cut.mcap --frames 0:1");
  expectRun("merge small -o merged");
  for (const std::string path : {"small", "again.mcap", "cut.mcap", "merged"}) {
    recording::BagReader reader;
    ASSERT_TRUE(reader.open(folder / path).ok());
    const auto& metadata = reader.channels().at(0).metadata;
    ASSERT_EQ(metadata.count("offered_qos_profiles"), 1u) << path;
    EXPECT_EQ(metadata.at("offered_qos_profiles"), "- durability: 1\n  depth: 2");
  }
}

TEST_F(ProgramInputs, AnotherCloudBehindTheFirstIsNotLeftOutSilently)
{
  const auto cloud = roomClouds(1)[0];
  pcl::io::savePCDFileASCII(folder / "ascii.pcd", cloud);
  pcl::io::savePCDFileBinary(folder / "binary.pcd", cloud);
  pcl::io::savePCDFileBinaryCompressed(folder / "compressed.pcd", cloud);
  for (const std::string kind : {"ascii", "binary", "compressed"}) {
    const ProgramRun result =
        runShell("cat " + kind + ".pcd ascii.pcd | \"$P\" encode - -o y.pcxi");
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(hasPart(result.errors, "another cloud follows the first one"));
  }
}

TEST_F(ProgramInputs, AnEmptyCloudIsAFrame)
{
  const std::string empty =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 "
      "1 1\nWIDTH 0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n";
  fs::create_directories(folder / "none");
  writeText(folder / "none/0.pcd", empty);
  writeText(folder / "none/1.pcd", empty);
  const ProgramRun kept = expectRun("encode none -o x.mcap --keep-order");
  EXPECT_FALSE(hasPart(kept.errors, "the order of the points"));
  expectRun("encode none -o x.mcap --overwrite");
  EXPECT_EQ(decode(folder / "x.mcap")[0].frames.size(), 2u);
  expectRun("verify x.mcap");
  // A topic whose messages have no fields either.
  recording::McapMessage message;
  recording::writePointCloud({}, false, message.bytes);
  writeMcap(folder / "bag.mcap", {recording::pointCloudChannel("/empty")}, {message});
  for (const std::string options :
       {"", " -l none", " -l native", " -l count", " --intensity-field a"}) {
    expectRun("encode bag.mcap -o small.mcap --overwrite" + options);
    EXPECT_EQ(decode(folder / "small.mcap")[0].frames.size(), 1u) << options;
  }
}

TEST_F(ProgramInputs, FailuresThatAreAlikeAreCounted)
{
  writeClouds("room", roomClouds(30));
  for (std::size_t i = 10; i < 25; ++i)
    fs::resize_file(folder / ("room/0" + std::to_string(i) + ".pcd"), 5000 + i);
  const ProgramRun encoded = run("encode room -o x.mcap");
  EXPECT_EQ(encoded.status, 1);
  EXPECT_EQ(linesOf(encoded.errors), 2u) << encoded.errors;
  EXPECT_TRUE(hasPart(encoded.errors,
                      "pcl_ext encode: /room, frame 10: cannot read 'room/010.pcd': it "
                      "was cut off: it has "));
  EXPECT_TRUE(
      hasPart(encoded.errors,
              "/room, frames 11 to 24: 14 more failures like that of frame 10"));
  EXPECT_TRUE(hasPart(encoded.output, ", 15 failed"));
  // The others have their times.
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.at(0).frames.size(), 15u);
  EXPECT_EQ(streams[0].frames[10].time, std::chrono::milliseconds(2500));
  // A stream without its first I-frame.
  writeBytes(folder / "lost.pcxi", framesOf(knownStream(0, 40, 40), 1, 40));
  const ProgramRun verified = run("verify lost.pcxi");
  EXPECT_EQ(verified.status, 1);
  EXPECT_EQ(linesOf(verified.output), 3u) << verified.output;
  EXPECT_TRUE(hasPart(verified.output,
                      "lost, frames 1 to 38: 38 more failures like that of frame 0"));
  const ProgramRun decoded = run("decode lost.pcxi -o out");
  EXPECT_EQ(decoded.status, 1);
  EXPECT_EQ(linesOf(decoded.errors), 3u) << decoded.errors;
}

TEST_F(ProgramInputs, CloudsWithoutPointsDoNotDecideOnTheLaw)
{
  fs::create_directories(folder / "ply");
  writeBytes(folder / "ply/0.ply", plyOf(0, false));
  writeBytes(folder / "ply/1.ply", plyOf(3, true));
  writeBytes(folder / "ply/2.ply", plyOf(0, false));
  expectRun("encode ply -o files.mcap");
  expectRun("decode files.mcap -o bag.mcap");
  expectRun("encode bag.mcap -o bag_again.mcap");
  // The same with a first message that has no fields either.
  recording::BagReader bag;
  ASSERT_TRUE(bag.open(folder / "bag.mcap").ok());
  std::vector<recording::McapMessage> messages(3);
  for (std::size_t i = 0; i < messages.size(); ++i)
    ASSERT_TRUE(bag.read(bag.index().at(i), messages[i]).ok());
  recording::writePointCloud({}, false, messages[0].bytes);
  writeMcap(folder / "bare.mcap", {bag.channels()[0]}, messages);
  expectRun("encode bare.mcap -o bare_again.mcap");
  for (const char* name : {"files.mcap", "bag_again.mcap", "bare_again.mcap"}) {
    recording::RecordingReader reader;
    ASSERT_TRUE(reader.open(folder / name).ok());
    EXPECT_EQ(reader.streams()[0].metadata.at("intensity_law"), "native") << name;
    const DecodedStream stream = decode(folder / name)[0];
    ASSERT_EQ(stream.voxels.size(), 3u) << name;
    EXPECT_EQ(stream.voxels[0].pointCount(), 0u) << name;
    EXPECT_TRUE(stream.voxels[1].hasIntensities()) << name;
  }
}

TEST_F(ProgramInputs, AnIntensityThatTheFirstCloudLacksIsNamedOnce)
{
  fs::create_directories(folder / "ply");
  writeBytes(folder / "ply/0.ply", plyOf(3, false));
  writeBytes(folder / "ply/1.ply", plyOf(3, true));
  writeBytes(folder / "ply/2.ply", plyOf(3, true));
  EXPECT_EQ(
      run("encode ply -o x.mcap").errors,
      "pcl_ext encode: /ply, frame 1: its field 'intensity' is left out, and in later "
      "clouds, as the first cloud of the stream has none; --fields all keeps it\n");
  EXPECT_EQ(run("encode ply -o y.mcap --fields all").errors, "");
  EXPECT_EQ(run("encode ply -o z.mcap --law none").errors, "");
}

TEST_F(ProgramInputs, AnIntensityThatLaterCloudsLackIs0)
{
  fs::create_directories(folder / "ply");
  writeBytes(folder / "ply/0.ply", plyOf(3, true));
  writeBytes(folder / "ply/1.ply", plyOf(3, false));
  writeBytes(folder / "ply/2.ply", plyOf(3, false));
  writeBytes(folder / "ply/3.ply", plyOf(3, true));
  for (const char* const options : {"", " --law native", " --keep-order"}) {
    expectRemark(std::string("encode ply -o x.mcap --overwrite") + options,
                 "/ply, frame 1: its points get the intensity 0, and those of "
                 "later clouds like it, as it has no field 'intensity' that can "
                 "be read; the first cloud of the stream has one\n");
    EXPECT_EQ(run("decode x.mcap -o out --overwrite").status, 0);
    for (const char* const name : {"0", "1", "2", "3"}) {
      const auto cloud = readCloud(folder / ("out/00000" + std::string(name) + ".pcd"));
      ASSERT_EQ(cloud.size(), 3u);
      EXPECT_EQ(cloud[0].intensity > 0.0f, *name == '0' || *name == '3') << name;
    }
  }
  // The first cloud must have what is named.
  fs::remove(folder / "ply/0.ply");
  EXPECT_EQ(run("encode ply -o y.mcap --law native").status, 2);
}

} // namespace pcl_ext::tools::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/bag_reader.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

using ProgramInfo = ProgramTest;
using ProgramVerify = ProgramTest;
using ProgramNames = ProgramTest;

TEST_F(ProgramInfo, ColumnsAreAlignedWhereNamesHaveOtherLetters)
{
  KnownStream stream = knownStream(0, 2, 1);
  stream.name = "/T\xc3\xbcr"; // two bytes of one letter
  record({stream, knownStream(1, 2, 1)}, folder / "x.mcap");
  const std::string table = expectRun("info x.mcap").output;
  EXPECT_TRUE(hasPart(table, "| stream    |"));
  EXPECT_TRUE(hasPart(table, "| /T\xc3\xbcr      |"));
}

TEST_F(ProgramInfo, JsonHasTheFiguresOfTheStreams)
{
  const std::vector<KnownStream> streams = recordTwoStreams(folder / "x.mcap");
  const ProgramRun result = expectRun("info x.mcap --json");
  const nlohmann::json json = nlohmann::json::parse(result.output);
  EXPECT_EQ(json["frames"], 71);
  EXPECT_EQ(json["file_bytes"], fs::file_size(folder / "x.mcap"));
  EXPECT_EQ(json["is_unfinished"], false);
  EXPECT_EQ(json["duration_s"], 1.95);
  ASSERT_EQ(json["streams"].size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& stream = json["streams"][i];
    std::size_t bytes = 0;
    std::size_t voxels = 0;
    for (const auto& frame : streams[i].frames) {
      bytes += frame.bytes.size();
      voxels += frame.voxels.size();
    }
    const double frames = static_cast<double>(streams[i].frames.size());
    EXPECT_EQ(stream["name"], streams[i].name);
    EXPECT_EQ(stream["frames"], streams[i].frames.size());
    EXPECT_EQ(stream["i_frames"], i == 0 ? 4 : 5);
    EXPECT_EQ(stream["missing_frames"], 0);
    EXPECT_EQ(stream["bytes"], bytes);
    EXPECT_DOUBLE_EQ(stream["mean_frame_voxels"], static_cast<double>(voxels) / frames);
    EXPECT_DOUBLE_EQ(stream["bytes_per_voxel"],
                     static_cast<double>(bytes) / static_cast<double>(voxels));
    EXPECT_DOUBLE_EQ(stream["rate_hz"], 20.0);
    EXPECT_DOUBLE_EQ(stream["resolution_m"],
                     streams[i].frames[0].voxels.grid.resolution);
    EXPECT_EQ(stream["effort"], "balanced");
    EXPECT_EQ(stream["frame_id"], "world");
  }
  const ProgramRun table = expectRun("info x.mcap");
  EXPECT_TRUE(
      hasPart(table.output, "| /sensor_1 | 31     | 5        | 0    | 20.0    |"));
}

TEST_F(ProgramInfo, FilesOfFramesThatWerePutTogetherHaveTheTimesOfTheirFrames)
{
  const KnownStream stream = knownStream(0, 10, 5);
  const std::vector<std::size_t> order = {5, 6, 7, 8, 9, 0, 1, 2, 3, 4};
  writeBytes(folder / "x.pcxi", framesOf(stream, order));
  const auto json = nlohmann::json::parse(expectRun("info x.pcxi --json").output);
  EXPECT_EQ(json["first_time_ns"], stream.frames[5].time.count());
  EXPECT_EQ(json["last_time_ns"], stream.frames[9].time.count());
  for (const std::string command : {"decode", "cut"}) {
    expectRun(command + " x.pcxi -o " + command + ".mcap");
    recording::BagReader bag;
    ASSERT_TRUE(bag.open(folder / (command + ".mcap")).ok());
    ASSERT_EQ(bag.index().size(), 10u);
    for (std::size_t i = 0; i < 10; ++i)
      EXPECT_EQ(bag.index()[i].log_time, stream.frames[i].time) << command;
  }
}

TEST_F(ProgramInfo, SeveralRecordingsAreToldOfOneAfterTheOther)
{
  recordTwoStreams(folder / "a.mcap");
  recordTwoStreams(folder / "b.mcap");
  const std::string table = expectRun("info a.mcap b.mcap").output;
  EXPECT_LT(table.find("a.mcap: "), table.find("\nb.mcap: "));
  EXPECT_TRUE(hasPart(table, "\nb.mcap: "));
  const ProgramRun list = expectRun("info --json a.mcap b.mcap");
  const nlohmann::json json = nlohmann::json::parse(list.output);
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[1]["file"], "b.mcap");
  EXPECT_EQ(json[1]["frames"], 71);
  EXPECT_EQ(expectRun("verify a.mcap b.mcap").output,
            "a.mcap: 71 frames decoded, 0 lost\nb.mcap: 71 frames decoded, 0 lost\n");
  // One that is missing does not keep the others from their turn.
  const ProgramRun info = run("info none.mcap b.mcap");
  EXPECT_EQ(info.status, 1);
  EXPECT_EQ(info.output.find("b.mcap: "), 0u) << info.output;
  const ProgramRun verified = run("verify none.mcap b.mcap");
  EXPECT_EQ(verified.status, 1);
  EXPECT_EQ(verified.output, "b.mcap: 71 frames decoded, 0 lost\n");
  EXPECT_TRUE(hasPart(verified.errors, "none.mcap"));
}

TEST_F(ProgramVerify, EachLossHasALine)
{
  const KnownStream stream = knownStream(0, 20, 5);
  record({stream}, folder / "good.pcxi");
  const ProgramRun good = expectRun("verify good.pcxi");
  EXPECT_EQ(good.output, "20 frames decoded, 0 lost\n");
  // Without frame 7 the next two cannot be decoded; frame 13 has a wrong bit.
  Bytes bytes = framesOf(stream, 0, 7);
  const std::size_t at_8 = bytes.size();
  const std::size_t at_13 = at_8 + framesOf(stream, 8, 13).size();
  const Bytes rest = framesOf(stream, 8, 20);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  bytes[at_13 + stream.frames[13].bytes.size() - 6] ^= 1;
  writeBytes(folder / "bad.pcxi", bytes);
  const ProgramRun bad = run("verify bad.pcxi");
  EXPECT_EQ(bad.status, 1);
  const std::string& text = bad.output;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5) << text;
  EXPECT_TRUE(hasPart(text,
                      "frame 7 at byte " + std::to_string(at_8) +
                          ": 1 frame before it is not in the recording"));
  EXPECT_TRUE(hasPart(text,
                      "frame 7 at byte " + std::to_string(at_8) +
                          ": it needs a frame before it"));
  // Frames are counted in one way, also where the decoder tells their own numbers.
  EXPECT_TRUE(hasPart(text,
                      "frame 12 at byte " + std::to_string(at_13) +
                          ": corrupt frame: checksum mismatch: "));
  EXPECT_TRUE(
      hasPart(text, "bad, frames 8 to 13: 2 more failures like that of frame 7"));
  EXPECT_TRUE(hasPart(text, "15 frames decoded, 5 lost"));
  const ProgramRun info = run("info bad.pcxi --json");
  EXPECT_EQ(info.status, 1);
  EXPECT_EQ(nlohmann::json::parse(info.output)["streams"][0]["missing_frames"], 1);
}

TEST_F(ProgramVerify, FileThatWasCutOffIsReadUpToThere)
{
  recordTwoStreams(folder / "x.mcap");
  Bytes bytes = bytesOf(folder / "x.mcap");
  bytes.resize(bytes.size() * 2 / 3);
  writeBytes(folder / "cut.mcap", bytes);
  const ProgramRun result = run("verify cut.mcap");
  EXPECT_TRUE(hasPart(result.output, "was not finished"));
  EXPECT_TRUE(hasPart(result.output, " 0 lost"));
  const ProgramRun info = run("info cut.mcap");
  EXPECT_EQ(info.status, result.status);
  EXPECT_TRUE(hasPart(info.output, "unfinished"));
}

TEST_F(ProgramVerify, FrameThatCannotBeReadIsCountedOnce)
{
  recordTwoStreams(folder / "x.mcap");
  Bytes bytes = bytesOf(folder / "x.mcap");
  bytes[bytes.size() / 2] ^= 1; // within a chunk of frames
  writeBytes(folder / "x.mcap", bytes);
  const nlohmann::json json = nlohmann::json::parse(run("info x.mcap --json").output);
  std::size_t frames = 0;
  std::size_t unreadable = 0;
  for (const nlohmann::json& stream : json["streams"]) {
    EXPECT_EQ(stream["missing_frames"], 0);
    frames += stream["frames"].get<std::size_t>();
    unreadable += stream["unreadable_frames"].get<std::size_t>();
  }
  EXPECT_EQ(frames, 71u);
  EXPECT_GT(unreadable, 1u);
  const ProgramRun result = run("verify x.mcap");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(hasPart(result.output,
                      std::to_string(frames - unreadable) + " frames decoded, " +
                          std::to_string(unreadable) + " lost"));
}

TEST_F(ProgramNames, ControlCharactersAreNotPrinted)
{
  const std::string name = "/a\x1b[31m\nb\xc2\x9b\xff\xc3\xa9\xe2\x80\xae";
  const std::string shown = "/a\\x1b[31m\\x0ab\\xc2\\x9b\\xff\xc3\xa9\\xe2\\x80\\xae";
  KnownStream stream = knownStream(0, 10, 5);
  stream.name = name;
  stream.frames.erase(stream.frames.begin() + 7);
  record({stream}, folder / "x.mcap");
  writeBytes(folder / "\x1b[31m.pcd", {});
  for (const char* const arguments : {"info x.mcap",
                                      "verify x.mcap",
                                      "decode x.mcap -o out",
                                      "cut x.mcap --streams y "
                                      "-o y.mcap",
                                      "encode *.pcd -o z.pcxi",
                                      "'\x1b[31m'"}) {
    const ProgramRun result = run(arguments);
    const std::string printed = result.output + result.errors;
    EXPECT_EQ(printed.find('\x1b'), std::string::npos) << arguments;
    EXPECT_EQ(printed.find('\xff'), std::string::npos) << arguments;
    EXPECT_TRUE(hasPart(printed, "\\x1b[31m")) << arguments;
    const bool has_stream = std::string(arguments).find("x.mcap") != std::string::npos;
    EXPECT_EQ(printed.find(shown) != std::string::npos, has_stream) << printed;
  }
}

TEST_F(ProgramInfo, WhatHeadersDoNotTellIsUnknown)
{
  auto clouds = roomClouds(1);
  clouds.push_back(clouds[0]);
  clouds[1].resize(3);
  writeClouds("room", clouds);
  expectRun("encode room -o published.pcxi -r 0.05 -l count --format published");
  nlohmann::json stream = nlohmann::json::parse(
      expectRun("info published.pcxi --json").output)["streams"][0];
  EXPECT_EQ(stream["i_frames"], 1);
  EXPECT_FALSE(stream.contains("mean_frame_voxels")) << stream;
  EXPECT_EQ(stream["format"], "published");
  // No frame can be read.
  expectRun("encode room -o x.mcap -r 0.05 -l count");
  Bytes bytes = bytesOf(folder / "x.mcap");
  const Bytes frame = decode(folder / "x.mcap")[0].frames[0].bytes;
  const auto begin =
      std::search(bytes.begin(), bytes.end(), frame.begin(), frame.end());
  ASSERT_NE(begin, bytes.end());
  begin[static_cast<std::ptrdiff_t>(frame.size() / 2)] ^= 1;
  writeBytes(folder / "x.mcap", bytes);
  const ProgramRun table = run("info x.mcap");
  EXPECT_TRUE(hasPart(table.output, "| unknown |"));
  EXPECT_FALSE(hasPart(table.output, "fast"));
  stream = nlohmann::json::parse(run("info x.mcap --json").output)["streams"][0];
  EXPECT_FALSE(stream.contains("format") || stream.contains("effort")) << stream;
}

} // namespace pcl_ext::tools::test

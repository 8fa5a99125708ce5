// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/recording/recording_writer.h>

#include "recording/bag_reader.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

TEST(RecordingOutputs, AFileWithoutAPlaceHasItsNameOnlyWhenItIsComplete)
{
  const TestFolder folder;
  const std::string path = folder / "bag.mcap";
  writeBytes(path, {1, 2, 3});
  for (const bool has_message : {false, true}) {
    {
      McapWriter writer;
      ASSERT_TRUE(writer.open(path, "").ok());
      McapMessage message;
      ASSERT_TRUE(writer
                      .addChannel(compressedPointCloudChannel("/a"),
                                  McapChunking::Shared,
                                  message.channel)
                      .ok());
      EXPECT_EQ(bytesOf(path), (Bytes{1, 2, 3}));
      if (has_message) {
        ASSERT_TRUE(writer.write(message).ok());
      }
    }
    // Else nothing was written but the beginning.
    EXPECT_EQ(std::filesystem::exists(path + ".unfinished"), has_message);
  }
  EXPECT_EQ(bytesOf(path), (Bytes{1, 2, 3}));
  BagReader reader;
  ASSERT_TRUE(reader.open(path + ".unfinished").ok());
  EXPECT_TRUE(reader.isUnfinished());
  EXPECT_EQ(reader.index().size(), 1u);
}

TEST(RecordingOutputs, NamesOfNoKindAreRefusedBeforeAnythingIsWritten)
{
  const TestFolder folder;
  writeBytes(folder / "file", {1});
  const std::pair<std::string, RecordingCode> rows[] = {
      {"", RecordingCode::OutputFailed}, // the folder
      {"x.PCXI", RecordingCode::InvalidArgument},
      {"x.bag", RecordingCode::InvalidArgument},
      {std::string("x\0y", 3), RecordingCode::InvalidArgument},
      {"file", RecordingCode::OutputFailed}};
  for (const auto& [name, code] : rows) {
    RecordingWriter writer;
    EXPECT_EQ(writer.open(folder / name).code(), code) << name;
  }
  RecordingWriter writer;
  EXPECT_EQ(writer.open("").code(), RecordingCode::InvalidArgument);
  const std::filesystem::directory_iterator all(folder / "");
  EXPECT_EQ(std::distance(begin(all), end(all)), 1);
}

TEST(RecordingOutputs, WhatARecorderLeftIsKeptBesideTheNextRecording)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 3, 10)};
  for (const std::string name : {"cell.mcap", "cell.pcxi", "cell"}) {
    const std::string file = name == "cell" ? "/cell_0.mcap" : "";
    for (int run = 0; run < 3; ++run) {
      RecordingWriter writer;
      std::size_t number = 0;
      ASSERT_TRUE(writer.open(folder / name).ok()) << name;
      ASSERT_TRUE(writer.addStream({streams[0].name, "", {}}, number).ok());
      const KnownFrame& frame = streams[0].frames[0];
      ASSERT_TRUE(
          writer.append(number, frame.time, frame.bytes.data(), frame.bytes.size())
              .ok());
    }
    for (const char* left : {".unfinished", ".unfinished.1", ".unfinished.2"})
      EXPECT_EQ(readAll(folder / (name + left + file), streams).decoded[0], 1u)
          << name << left;
    record(streams, folder / name);
    EXPECT_EQ(readAll(folder / name, streams).decoded[0], 3u);
    EXPECT_TRUE(std::filesystem::exists(folder / (name + ".unfinished.3")));
    EXPECT_FALSE(std::filesystem::exists(folder / (name + ".unfinished")));
  }
}

TEST(RecordingOutputs, AFullDiskIsReportedAndEndsTheFile)
{
  // Every write to this device fails as on a full disk.
  const TestFolder folder;
  std::filesystem::create_symlink("/dev/full", folder / "full.mcap.unfinished");
  McapWriter mcap;
  RecordingStatus status = mcap.open(folder / "full.mcap", "");
  EXPECT_EQ(status.code(), RecordingCode::OutputFailed);
  EXPECT_TRUE(hasPart(status.message(), "No space left"));
  EXPECT_EQ(mcap.finish().code(), RecordingCode::OutputFailed);
  EXPECT_FALSE(std::filesystem::exists(folder / "full.mcap"));
}

TEST(RecordingOutputs, PathsThatCannotBeWrittenAreRefused)
{
  const TestFolder folder;
  McapWriter writer;
  EXPECT_EQ(writer.open(folder / "missing/bag.mcap", "").code(),
            RecordingCode::OutputFailed);
  std::filesystem::create_directories(folder / "folder.mcap");
  EXPECT_EQ(writer.open(folder / "folder.mcap", "").code(),
            RecordingCode::OutputFailed);
  std::filesystem::create_directories(folder / "bag");
  EXPECT_TRUE(hasPart(writer.open(folder / "bag", "").message(), "exists"));
  std::size_t number = 0;
  EXPECT_EQ(
      writer.addChannel(compressedPointCloudChannel("/a"), McapChunking::Shared, number)
          .code(),
      RecordingCode::OutputFailed);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

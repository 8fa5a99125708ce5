// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_description.h>

#include "recording/bag_reader.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"
#include "support/test_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

std::vector<KnownStream>
threeStreams()
{
  return {knownStream(0, 40, 10), knownStream(1, 31, 7), knownStream(2, 12, 1)};
}

void
expectAllFrames(const std::string& path, const std::vector<KnownStream>& streams)
{
  const ReadRecording read = readAll(path, streams);
  EXPECT_TRUE(read.status.ok()) << read.status;
  for (std::size_t i = 0; i < streams.size(); ++i)
    EXPECT_EQ(read.decoded[i], streams[i].frames.size()) << streams[i].name;
  EXPECT_EQ(read.failed, 0u);
  EXPECT_EQ(read.wrong, 0u);
  EXPECT_EQ(read.damages, 0u);
  EXPECT_FALSE(read.is_unfinished);
}

class Recordings : public ::testing::Test {
protected:
  void
  open(const std::vector<KnownStream>& streams)
  {
    record(streams, folder / "cell.mcap");
    ASSERT_TRUE(reader.open(folder / "cell.mcap").ok());
  }

  const TestFolder folder;
  RecordingReader reader;
  RecordedFrame frame;
  io::VoxelFrame voxels;
};

} // namespace

TEST_F(Recordings, OfAllKindsHaveAllFramesOfAllStreams)
{
  const std::vector<KnownStream> streams = threeStreams();
  record(streams, folder / "cell.mcap");
  record(streams, folder / "cell");
  EXPECT_TRUE(hasPart(textOf(folder / "cell/metadata.yaml"),
                      "nanoseconds_since_epoch: 1000000000000\n"));
  EXPECT_TRUE(std::filesystem::exists(folder / "cell/cell_0.mcap"));
  EXPECT_FALSE(std::filesystem::exists(folder / "cell.unfinished"));
  record({streams[0]}, folder / "sensor.pcxi");
  EXPECT_EQ(bytesOf(folder / "sensor.pcxi"), framesOf(streams[0], 0, 40));
  // The kind is found by the content.
  std::filesystem::copy(folder / "cell.mcap", folder / "cell.bin");
  std::filesystem::copy(folder / "sensor.pcxi", folder / "sensor.mcap");
  for (const std::string name : {"cell.mcap", "cell", "cell.bin"})
    expectAllFrames(folder / name, streams);
  for (const std::string name : {"sensor.pcxi", "sensor.mcap"})
    expectAllFrames(folder / name, {streams[0]});
}

TEST_F(Recordings, StreamsOfOneTopicHaveNamesOfTheirOwn)
{
  PointCloudMessage cloud;
  cloud.format = "pcl_ext";
  cloud.bytes = knownStream(0, 1, 1).frames.front().bytes;
  std::vector<McapMessage> of_publishers(2);
  of_publishers[1].channel = 1;
  for (McapMessage& message : of_publishers)
    writePointCloud(cloud, true, message.bytes);
  const McapChannel channel = compressedPointCloudChannel("/a");
  writeMcap(folder / "a.mcap", {channel, channel}, of_publishers);
  ASSERT_TRUE(reader.open(folder / "a.mcap").ok());
  ASSERT_EQ(reader.streams().size(), 2u);
  EXPECT_EQ(reader.streams()[0].name, "/a");
  EXPECT_EQ(reader.streams()[1].name, "/a#2");
}

TEST_F(Recordings, FramesComeInTheOrderOfTheirTimesAlsoAfterASeek)
{
  const std::vector<KnownStream> streams = threeStreams();
  open(streams);
  Time last{0};
  std::size_t count = 0;
  for (; reader.next(frame).ok(); ++count) {
    EXPECT_GE(frame.time, last);
    last = frame.time;
  }
  EXPECT_EQ(count, 83u);
  // It goes on with the first frame of a time or later.
  reader.seek(streams[1].frames[5].time);
  ASSERT_TRUE(reader.next(frame).ok());
  EXPECT_EQ(frame.stream, 1u);
  EXPECT_EQ(frame.number, 5u);
  reader.seek(streams[1].frames[5].time + Time(1));
  ASSERT_TRUE(reader.next(frame).ok());
  EXPECT_EQ(frame.stream, 2u);
  EXPECT_EQ(frame.number, 5u);
  reader.seek(streams[0].frames.back().time + Time(1));
  EXPECT_EQ(reader.next(frame).code(), RecordingCode::EndOfRecording);
  EXPECT_EQ(reader.frameAt(0, streams[0].frames[7].time), 7u);
  EXPECT_EQ(reader.frameAt(0, streams[0].frames[7].time - Time(1)), 6u);
  EXPECT_EQ(reader.frameAt(0, Time(0)), std::nullopt);
}

TEST_F(Recordings, AnyFrameIsDecodedByItself)
{
  const std::vector<KnownStream> streams = threeStreams();
  open(streams);
  std::mt19937_64 random(3);
  for (std::size_t stream = 0; stream < streams.size(); ++stream) {
    RecordedStreamDecoder decoder(reader, stream);
    const std::vector<KnownFrame>& frames = streams[stream].frames;
    for (int i = 0; i < 100; ++i) {
      const std::size_t number = io::test::below(random, frames.size());
      const io::CompressionStatus status = decoder.decode(number, voxels);
      ASSERT_TRUE(status.ok()) << status;
      EXPECT_TRUE(areSame(voxels, frames[number].voxels)) << number;
    }
    EXPECT_EQ(decoder.decode(frames.size(), voxels).code(),
              io::CompressionCode::InputFailed);
    EXPECT_TRUE(voxels.keys.empty());
    EXPECT_TRUE(decoder.decode(0, voxels).ok());
  }
}

TEST_F(Recordings, WhatIsDroppedForTheMemoryLimitIsDecodedAgain)
{
  const std::vector<KnownStream> streams = threeStreams();
  open(streams);
  io::DecoderLimits limits;
  limits.budget = std::make_shared<io::MemoryBudget>();
  RecordedStreamDecoder one(reader, 0, limits);
  ASSERT_TRUE(one.decode(5, voxels).ok());
  // Enough for one stream, not for three.
  limits.budget = std::make_shared<io::MemoryBudget>(limits.budget->used() * 3 / 2);
  std::vector<RecordedStreamDecoder> decoders;
  for (std::size_t stream = 0; stream < streams.size(); ++stream)
    decoders.emplace_back(reader, stream, limits);
  while (reader.next(frame).ok()) {
    const io::CompressionStatus status = decoders[frame.stream].decode(frame, voxels);
    ASSERT_TRUE(status.ok()) << frame.stream << ", " << frame.number << ": " << status;
    EXPECT_TRUE(areSame(voxels, streams[frame.stream].frames[frame.number].voxels));
  }
  EXPECT_GT(limits.budget->drops(), 10u);
}

TEST_F(Recordings, FramesOfAStreamStayInOrderIfTheClockIsSetBack)
{
  std::vector<KnownStream> streams = {knownStream(0, 20, 10), knownStream(1, 20, 10)};
  const Time set_back = std::chrono::milliseconds(400);
  for (std::size_t i = 13; i < 20; ++i)
    streams[0].frames[i].time -= set_back;
  open(streams);
  RecordedStreamDecoder decoder(reader, 0);
  for (std::size_t i = 0; i < 20; ++i) {
    ASSERT_TRUE(decoder.decode(i, voxels).ok()) << i;
    EXPECT_TRUE(areSame(voxels, streams[0].frames[i].voxels)) << i;
    ASSERT_TRUE(reader.read(0, i, frame).ok());
    EXPECT_EQ(reader.timeOf(0, i),
              streams[0].frames[std::min<std::size_t>(i, 12)].time);
    EXPECT_EQ(frame.time, streams[0].frames[i].time) << i;
    EXPECT_EQ(frame.stamp, streams[0].frames[i].time) << i;
  }
}

TEST_F(Recordings, ATimeThatIsOutOfLineDoesNotMoveTheOnesAfterIt)
{
  std::vector<KnownStream> streams = {knownStream(0, 20, 10)};
  std::vector<KnownFrame>& frames = streams.front().frames;
  const Time right = frames[7].time;
  frames[7].time += std::chrono::seconds(1);
  open(streams);
  for (std::size_t i = 0; i < 20; ++i)
    EXPECT_EQ(reader.timeOf(0, i), i == 7 ? frames[8].time : frames[i].time) << i;
  EXPECT_EQ(reader.frameAt(0, right), 6u);
}

TEST_F(Recordings, ALatePFrameDoesNotEndTheHistory)
{
  std::vector<KnownStream> streams = {knownStream(0, 20, 10)};
  std::vector<KnownFrame>& frames = streams.front().frames;
  frames.insert(frames.begin() + 15, frames[12]); // as a network repeats a packet
  open(streams);
  RecordedStreamDecoder decoder(reader, 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const io::CompressionStatus status = decoder.decode(i, voxels);
    if (i == 15) {
      EXPECT_EQ(status.code(), io::CompressionCode::OldFrame);
      continue;
    }
    ASSERT_TRUE(status.ok()) << i << ": " << status;
    EXPECT_TRUE(areSame(voxels, frames[i].voxels)) << i;
  }
}

TEST_F(Recordings, StampsAreNotGuessedBehindALostFrame)
{
  const KnownStream stream = knownStream(0, 12, 5);
  const std::vector<KnownFrame>& frames = stream.frames;
  // The second and the eighth one are lost.
  const std::vector<std::size_t> kept = {0, 2, 3, 4, 5, 6, 8, 9, 10, 11};
  writeBytes(folder / "sensor.pcxi", framesOf(stream, kept));
  ASSERT_TRUE(reader.open(folder / "sensor.pcxi").ok());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    // Frames without a known time have that of the frame before: of frame 0, and 6.
    const std::size_t known = kept[i] < 5    ? 0
                              : kept[i] < 8  ? kept[i]
                              : kept[i] < 10 ? 6
                                             : kept[i];
    EXPECT_EQ(reader.timeOf(0, i), frames[known].time) << kept[i];
  }
}

TEST_F(Recordings, FramesOfAFileOfFramesStayInOrderIfTheClockIsSetBack)
{
  const KnownStream stream = knownStream(0, 10, 5);
  const std::vector<std::size_t> order = {5, 6, 7, 8, 9, 0, 1, 2, 3, 4};
  writeBytes(folder / "sensor.pcxi", framesOf(stream, order));
  ASSERT_TRUE(reader.open(folder / "sensor.pcxi").ok());
  for (std::size_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(reader.timeOf(0, i), stream.frames[i < 5 ? order[i] : 9].time) << i;
    ASSERT_TRUE(reader.read(0, i, frame).ok());
    EXPECT_EQ(frame.time, stream.frames[order[i]].time) << i;
  }
}

TEST_F(Recordings, ChunksBeginAtIFrames)
{
  // Frames of some kilobytes, so that there are several chunks.
  const std::vector<KnownStream> streams = {knownStream(0, 300, 20, 60),
                                            knownStream(1, 300, 20, 60)};
  record(streams, folder / "cell.mcap");
  BagReader mcap;
  ASSERT_TRUE(mcap.open(folder / "cell.mcap").ok());
  std::set<std::size_t> chunks;
  PointCloudMessage cloud;
  McapMessage message;
  for (const BagEntry& entry : mcap.index()) {
    if (!chunks.insert(entry.chunk).second)
      continue;
    ASSERT_TRUE(mcap.read(entry, message).ok());
    ASSERT_TRUE(
        readPointCloud(message.bytes.data(), message.bytes.size(), true, cloud).ok());
    EXPECT_TRUE(io::describeFrame(cloud.bytes.data(), cloud.bytes.size()).is_i_frame);
  }
  EXPECT_GE(chunks.size(), 4u);
}

TEST_F(Recordings, DecompressedChunksAreKeptUpToABound)
{
  constexpr std::size_t chunk_bytes = std::size_t{1} << 24;
  McapWriter writer;
  McapMessage message;
  ASSERT_TRUE(writer.open(folder / "a.mcap", "ros2").ok());
  ASSERT_TRUE(
      writer.addChannel(pointCloudChannel("/a"), McapChunking::Shared, message.channel)
          .ok());
  message.bytes.resize(chunk_bytes);
  for (int i = 0; i < 8; ++i) {
    ASSERT_TRUE(writer.write(message).ok());
    ASSERT_TRUE(writer.flush().ok());
  }
  ASSERT_TRUE(writer.finish().ok());
  BagReader mcap;
  ASSERT_TRUE(mcap.open(folder / "a.mcap").ok());
  ASSERT_EQ(mcap.index().size(), 8u);
  const pcl_ext::test::MemoryUse use;
  for (const BagEntry& entry : mcap.index())
    ASSERT_TRUE(mcap.read(entry, message).ok());
  EXPECT_LT(use.live(), 6 * chunk_bytes);
}

TEST_F(Recordings, MessagesDescribeTheDecodedCloud)
{
  const std::vector<KnownStream> streams = {knownStream(0, 2, 10)};
  record(streams, folder / "cell.mcap");
  BagReader mcap;
  ASSERT_TRUE(mcap.open(folder / "cell.mcap").ok());
  ASSERT_EQ(mcap.channels().size(), 1u);
  EXPECT_TRUE(isCompressedPointCloud(mcap.channels().front()));
  EXPECT_EQ(mcap.channels().front().topic, "/sensor_0");
  EXPECT_EQ(mcap.profile(), "ros2");
  ASSERT_EQ(mcap.index().size(), 2u);
  McapMessage message;
  PointCloudMessage cloud;
  ASSERT_TRUE(mcap.read(mcap.index()[1], message).ok());
  EXPECT_EQ(message.sequence, 1u);
  EXPECT_EQ(message.publish_time, streams[0].frames[1].time);
  ASSERT_TRUE(
      readPointCloud(message.bytes.data(), message.bytes.size(), true, cloud).ok());
  EXPECT_EQ(cloud.stamp, streams[0].frames[1].time);
  EXPECT_EQ(cloud.frame_id, "world");
  EXPECT_EQ(cloud.format, "pcl_ext");
  EXPECT_EQ(cloud.height, 1u);
  EXPECT_EQ(cloud.width, streams[0].frames[1].voxels.size());
  EXPECT_EQ(cloud.point_step, 16u);
  EXPECT_EQ(cloud.row_step, 16 * cloud.width);
  ASSERT_EQ(cloud.fields.size(), 4u);
  EXPECT_EQ(cloud.fields[3].name, "intensity");
  EXPECT_EQ(cloud.fields[3].offset, 12u);
  EXPECT_EQ(cloud.bytes, streams[0].frames[1].bytes);
}

TEST_F(Recordings, FramesOfThePublishedLayoutAreRecorded)
{
  KnownStream room = knownStream(0, 12, 10);
  io::FrameEncoder encoder(io::StreamFormat::Published, 5);
  for (KnownFrame& known : room.frames)
    ASSERT_TRUE(encoder.encode(known.voxels, std::nullopt, known.bytes).ok());
  for (const char* name : {"published.pcxi", "published.mcap"}) {
    record({room}, folder / name);
    ASSERT_TRUE(reader.open(folder / name).ok());
    ASSERT_EQ(reader.streams().front().frames, room.frames.size());
    RecordedStreamDecoder decoder(reader, 0);
    for (const std::size_t number : {3u, 11u, 6u}) {
      ASSERT_TRUE(decoder.decode(number, voxels).ok());
      EXPECT_EQ(voxels.size(), room.frames[number].voxels.size());
      EXPECT_EQ(voxels.intensities, room.frames[number].voxels.intensities);
    }
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

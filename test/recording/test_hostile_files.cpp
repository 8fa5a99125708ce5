// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/bag_test.h"
#include "recording/mcap/chunk_compression.h"
#include "recording/mcap/records.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"
#include "support/test_memory.h"

#include <gtest/gtest.h>

#include <limits>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

McapChannel
channelWithSchema(const std::string& topic, const std::string& text)
{
  McapChannel channel = compressedPointCloudChannel(topic);
  channel.schema.text = text;
  return channel;
}

Bytes
beginning()
{
  Bytes file(mcap::magic.begin(), mcap::magic.end());
  mcap::append(mcap::Header{"ros2", "test"}, file);
  return file;
}

/** \brief Appends the end of a file to its data. */
void
appendEnd(const Bytes& summary, Bytes& file)
{
  mcap::appendDataEnd(0, file);
  const std::uint64_t start = file.size();
  file.insert(file.end(), summary.begin(), summary.end());
  mcap::appendFooter({start, 0, 0}, file);
  file.insert(file.end(), mcap::magic.begin(), mcap::magic.end());
}

} // namespace

using HostileFiles = BagTest;

TEST_F(HostileFiles, ManyChannelsOfALargeSchemaAreBounded)
{
  const McapSchema schema{"type", "ros2msg", std::string(std::size_t{1} << 20, 'x')};
  Bytes file = beginning();
  mcap::append(mcap::Schema{1, schema}, file);
  constexpr std::uint16_t channels = 200;
  for (std::uint16_t id = 0; id < channels; ++id)
    mcap::append(mcap::Channel{id, 1, channelWithSchema(std::to_string(id), "")}, file);
  ASSERT_TRUE(open("a.mcap", file).ok());
  EXPECT_GT(reader.channels().size(), 100u);
  EXPECT_LT(reader.channels().size(), 130u);
  EXPECT_EQ(reader.damage().size(), 1u);
}

TEST_F(HostileFiles, AMessageIndexBelongsToOneChunk)
{
  Bytes file = beginning();
  const McapChannel channel = compressedPointCloudChannel("/a");
  Bytes summary;
  mcap::append(mcap::Schema{1, channel.schema}, summary);
  mcap::append(mcap::Channel{0, 1, channel}, summary);
  file.insert(file.end(), summary.begin(), summary.end());
  mcap::ChunkIndex chunk;
  chunk.end_time = 100;
  chunk.uncompressed_size = 1000;
  chunk.chunk_offset = file.size();
  chunk.message_index_offsets[0] = file.size();
  mcap::MessageIndex index;
  for (std::uint64_t i = 0; i < 100; ++i)
    index.entries.emplace_back(i, i);
  mcap::append(index, file);
  chunk.message_index_length = file.size() - chunk.chunk_offset;
  constexpr std::uint32_t chunks = 50;
  for (std::uint32_t i = 0; i < chunks; ++i)
    mcap::append(chunk, summary);
  mcap::Statistics statistics;
  statistics.channels = 1;
  statistics.chunks = chunks;
  mcap::append(statistics, summary);
  appendEnd(summary, file);
  ASSERT_TRUE(open("a.mcap", file).ok());
  EXPECT_LE(reader.index().size(), 100u);
  EXPECT_FALSE(reader.damage().empty());
}

TEST_F(HostileFiles, AMetadataRecordIsReadOnce)
{
  Bytes file = beginning();
  const std::uint64_t offset = file.size();
  mcap::append(McapMetadata{"name", {{"key", "value"}}}, file);
  const std::uint64_t length = file.size() - offset;
  Bytes summary;
  for (int i = 0; i < 50; ++i)
    mcap::appendMetadataIndex({offset, length}, "name", summary);
  mcap::Statistics statistics;
  statistics.metadata = 50;
  mcap::append(statistics, summary);
  appendEnd(summary, file);
  ASSERT_TRUE(open("a.mcap", file).ok());
  std::vector<McapMetadata> metadata;
  EXPECT_TRUE(reader.readMetadata(metadata).ok());
  ASSERT_EQ(metadata.size(), 1u);
  EXPECT_EQ(metadata[0].values.at("key"), "value");
}

TEST_F(HostileFiles, SmallChunksTakeLittleMemory)
{
  const Bytes bytes(31, 7);
  Bytes compressed;
  ASSERT_TRUE(mcap::compress(bytes, compressed));
  Bytes records;
  EXPECT_EQ(mcap::decompress("zstd", compressed.data(), compressed.size(), 31, records),
            "");
  EXPECT_EQ(records, bytes);
  EXPECT_LT(records.capacity(), 1000u);
  EXPECT_NE(mcap::decompress("zstd", compressed.data(), compressed.size(), 30, records),
            "");
  EXPECT_EQ(records.size(), 30u);
}

TEST_F(HostileFiles, CompressedEmptyMessagesTakeMemoryByTheSizeOfTheFile)
{
  Bytes file = beginning();
  const McapChannel channel = compressedPointCloudChannel("/a");
  mcap::append(mcap::Schema{1, channel.schema}, file);
  mcap::append(mcap::Channel{0, 1, channel}, file);
  Bytes records;
  for (int i = 0; i < 400'000; ++i)
    mcap::append(mcap::MessagePrefix(), {}, records);
  mcap::Chunk chunk;
  chunk.uncompressed_size = records.size();
  chunk.compression = "zstd";
  Bytes compressed;
  ASSERT_TRUE(mcap::compress(records, compressed));
  chunk.records_size = compressed.size();
  for (int i = 0; i < 6; ++i) {
    mcap::appendChunkFields(chunk, file);
    file.insert(file.end(), compressed.begin(), compressed.end());
  }
  writeBytes(folder / "a.mcap", file);
  const pcl_ext::test::MemoryUse memory;
  RecordingReader recording;
  ASSERT_TRUE(recording.open(folder / "a.mcap").ok());
  EXPECT_LE(memory.peak(), 16 * file.size() + (std::size_t{1} << 27));
  EXPECT_GT(recording.streams()[0].frames, 1'000'000u);
  ASSERT_EQ(recording.damage().size(), 1u);
  EXPECT_TRUE(hasPart(recording.damage()[0].message, "more messages"));
}

TEST_F(HostileFiles, AMessageOfVeryManyFieldsIsRefused)
{
  PointCloudMessage cloud;
  cloud.fields.resize(5000);
  Bytes bytes;
  writePointCloud(cloud, false, bytes);
  PointCloudMessage read;
  EXPECT_EQ(readPointCloud(bytes.data(), bytes.size(), false, read).code(),
            RecordingCode::Damaged);
  cloud.fields.resize(4096);
  writePointCloud(cloud, false, bytes);
  EXPECT_TRUE(readPointCloud(bytes.data(), bytes.size(), false, read).ok());
  EXPECT_EQ(read.fields.size(), 4096u);
}

TEST_F(HostileFiles, ForgedBeginningsOfFramesAreOneDamage)
{
  const KnownStream stream = knownStream(0, 2, 1);
  Bytes file = stream.frames[0].bytes;
  for (int i = 0; i < 100'000; ++i)
    for (const char character : std::string("PCXI"))
      file.push_back(static_cast<std::uint8_t>(character));
  file.insert(file.end(), stream.frames[1].bytes.begin(), stream.frames[1].bytes.end());
  writeBytes(folder / "a.pcxi", file);
  const ReadRecording read = readAll(folder / "a.pcxi", {stream});
  EXPECT_EQ(read.decoded[0], 2u);
  EXPECT_EQ(read.wrong, 0u);
  EXPECT_LE(read.damages, 4u);
}

TEST_F(HostileFiles, TheFormatOfAChannelIsThatOfItsFirstMessageThatCanBeRead)
{
  PointCloudMessage cloud;
  cloud.format = "draco";
  std::vector<McapMessage> messages(4);
  for (int i = 0; i < 3; ++i)
    messages[static_cast<std::size_t>(i)].bytes = {1, 2, 3};
  messages[3].log_time = Time(1);
  writePointCloud(cloud, true, messages[3].bytes);
  writeMcap(folder / "a.mcap", {compressedPointCloudChannel("/a")}, messages);
  RecordingReader recording;
  const RecordingStatus status = recording.open(folder / "a.mcap");
  EXPECT_EQ(status.code(), RecordingCode::NotARecording);
  EXPECT_TRUE(hasPart(status.message(), "draco"));
}

TEST(WrongCalls, FramesBeyondTheEndAreRefusedAtOnce)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 5, 3)};
  record(streams, folder / "a.mcap");
  RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "a.mcap").ok());
  constexpr std::size_t huge = std::numeric_limits<std::size_t>::max();
  EXPECT_EQ(reader.iFrameBefore(0, huge), 3u);
  EXPECT_EQ(reader.iFrameBefore(7, huge), 0u);
  io::VoxelFrame voxels;
  RecordedStreamDecoder decoder(reader, 0);
  ASSERT_TRUE(decoder.decode(1, voxels).ok());
  EXPECT_EQ(decoder.decode(huge, voxels).code(), io::CompressionCode::InputFailed);
  EXPECT_EQ(voxels.size(), 0u);
  // It does not lose its place.
  EXPECT_TRUE(decoder.decode(2, voxels).ok());
  RecordedStreamDecoder other(reader, 7);
  EXPECT_EQ(other.decode(huge, voxels).code(), io::CompressionCode::InputFailed);
}

TEST(WrongCalls, FramesRecordedTwiceAreDecodedInAnyOrder)
{
  const TestFolder folder;
  const KnownStream stream = knownStream(0, 40, 10);
  const Bytes once = framesOf(stream, 0, 40);
  Bytes twice = once;
  twice.insert(twice.end(), once.begin(), once.end());
  writeBytes(folder / "a.pcxi", twice);
  RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "a.pcxi").ok());
  io::VoxelFrame voxels;
  RecordedStreamDecoder forwards(reader, 0);
  for (std::size_t i = 0; i < 80; ++i)
    EXPECT_TRUE(forwards.decode(i, voxels).ok()) << i;
  RecordedStreamDecoder backwards(reader, 0);
  for (std::size_t i = 80; i-- > 0;)
    EXPECT_TRUE(backwards.decode(i, voxels).ok()) << i;
  RecordedStreamDecoder all(reader, 0);
  RecordedFrame frame;
  while (reader.next(frame).ok())
    EXPECT_TRUE(all.decode(frame, voxels).ok()) << frame.number;
}

TEST(WrongCalls, OneFileHasOneWriter)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 5, 3)};
  for (const char* name : {"a.mcap", "a.pcxi"}) {
    RecordingWriter first;
    ASSERT_TRUE(first.open(folder / name).ok());
    std::size_t stream = 0;
    ASSERT_TRUE(first.addStream({"/a", "", {}}, stream).ok());
    RecordingWriter second;
    EXPECT_EQ(second.open(folder / name).code(), RecordingCode::OutputFailed);
    const KnownFrame& frame = streams[0].frames[0];
    ASSERT_TRUE(
        first.append(stream, frame.time, frame.bytes.data(), frame.bytes.size()).ok());
    ASSERT_TRUE(first.finish().ok());
    EXPECT_EQ(readAll(folder / name, streams).decoded[0], 1u);
    EXPECT_TRUE(second.open(folder / name).ok());
  }
}

TEST(WrongCalls, AFailureOfFinishIsKept)
{
  const TestFolder folder;
  RecordingWriter writer;
  std::filesystem::create_directories(folder / "gone");
  ASSERT_TRUE(writer.open(folder / "gone/a.mcap").ok());
  std::filesystem::remove_all(folder / "gone");
  const RecordingStatus status = writer.finish();
  EXPECT_EQ(status.code(), RecordingCode::OutputFailed);
  EXPECT_EQ(writer.finish().message(), status.message());
}

TEST(Rosbag2Folders, WithoutMetadataAreThoseOfARecorderThatDidNotEnd)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 5, 3)};
  record(streams, folder / "bag");
  std::filesystem::remove(folder / "bag/metadata.yaml");
  EXPECT_EQ(readAll(folder / "bag", streams).decoded[0], 5u);
  std::filesystem::rename(folder / "bag", folder / "bag.unfinished");
  EXPECT_EQ(readAll(folder / "bag.unfinished/", streams).decoded[0], 5u);
  std::filesystem::rename(folder / "bag.unfinished", folder / "bag");
  // The next file of the bag was begun and never written.
  writeBytes(folder / "bag/bag_1.mcap", {});
  const ReadRecording read = readAll(folder / "bag", streams);
  EXPECT_EQ(read.decoded[0], 5u);
  EXPECT_EQ(read.damages, 1u);
  EXPECT_TRUE(read.is_unfinished);
  std::filesystem::create_directories(folder / "empty");
  RecordingReader reader;
  EXPECT_EQ(reader.open(folder / "empty").code(), RecordingCode::InputFailed);
}

TEST(Rosbag2Folders, SeveralPublishersOfATopicStayApart)
{
  const TestFolder folder;
  std::filesystem::create_directories(folder / "bag");
  writeBytes(folder / "bag/metadata.yaml", {});
  std::vector<McapMessage> of_publishers(2);
  of_publishers[0].bytes = {0};
  of_publishers[1].bytes = {1};
  of_publishers[1].channel = 1;
  for (const char* const part : {"bag/b_0.mcap", "bag/b_1.mcap"})
    writeMcap(folder / part,
              {compressedPointCloudChannel("/a"), compressedPointCloudChannel("/a")},
              of_publishers);
  BagReader reader;
  ASSERT_TRUE(reader.open(folder / "bag").ok());
  ASSERT_EQ(reader.channels().size(), 2u);
  ASSERT_EQ(reader.index().size(), 4u);
  McapMessage message;
  for (const BagEntry& entry : reader.index()) {
    ASSERT_TRUE(reader.read(entry, message).ok());
    EXPECT_EQ(message.bytes.at(0), entry.channel);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/bag_test.h"
#include "recording/mcap/chunk_compression.h"
#include "recording/mcap/records.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <lz4frame.h>
#include <sys/resource.h>

#include <algorithm>
#include <random>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

McapChannel
channelOf(const std::string& topic)
{
  McapChannel channel;
  channel.topic = topic;
  channel.message_encoding = "cdr";
  channel.schema = {"std_msgs/msg/String", "ros2msg", "string data\n"};
  channel.metadata = {{"offered_qos_profiles", ""}, {"key", "a value"}};
  return channel;
}

McapMessage
messageOf(std::size_t channel, std::int64_t time, const Bytes& bytes)
{
  McapMessage message;
  message.channel = channel;
  message.sequence = 3;
  message.log_time = Time(time);
  message.publish_time = Time(time + 1);
  message.bytes = bytes;
  return message;
}

Bytes
randomBytes(std::mt19937_64& random, std::size_t size)
{
  Bytes bytes(size);
  for (std::uint8_t& byte : bytes)
    byte = static_cast<std::uint8_t>(random());
  return bytes;
}

/** \brief An MCAP file of one chunk whose records are compressed in a given way. */
Bytes
fileOfOneChunk(const std::string& compression,
               const Bytes& records,
               const Bytes& stored)
{
  Bytes file(mcap::magic.begin(), mcap::magic.end());
  mcap::append(mcap::Header{"ros2", "test"}, file);
  mcap::append(mcap::Schema{1, channelOf("/a").schema}, file);
  mcap::append(mcap::Channel{5, 1, channelOf("/a")}, file);
  mcap::Chunk chunk;
  chunk.start_time = 100;
  chunk.end_time = 300;
  chunk.uncompressed_size = records.size();
  chunk.uncompressed_checksum = mcap::checksumOf(records.data(), records.size());
  chunk.compression = compression;
  chunk.records_size = stored.size();
  mcap::appendChunkFields(chunk, file);
  file.insert(file.end(), stored.begin(), stored.end());
  mcap::appendDataEnd(0, file);
  mcap::appendFooter({}, file);
  file.insert(file.end(), mcap::magic.begin(), mcap::magic.end());
  return file;
}

Bytes
recordsOfThreeMessages()
{
  Bytes records;
  std::mt19937_64 random(1);
  for (std::uint64_t time : {200u, 100u, 300u})
    mcap::append(
        mcap::MessagePrefix{5, 0, time, time}, randomBytes(random, 1000), records);
  return records;
}

Bytes
compressedByLz4(const Bytes& bytes)
{
  Bytes compressed(LZ4F_compressFrameBound(bytes.size(), nullptr));
  compressed.resize(LZ4F_compressFrame(
      compressed.data(), compressed.size(), bytes.data(), bytes.size(), nullptr));
  return compressed;
}

/** \brief Bounds the number of files that this process may open. */
class FewDescriptors {
public:
  explicit FewDescriptors(rlim_t count)
  {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    rlimit few = before_;
    few.rlim_cur = count;
    ::setrlimit(RLIMIT_NOFILE, &few);
  }

  ~FewDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }

  FewDescriptors(const FewDescriptors&) = delete;
  FewDescriptors&
  operator=(const FewDescriptors&) = delete;

private:
  rlimit before_;
};

std::vector<std::int64_t>
timesOf(const BagReader& reader)
{
  std::vector<std::int64_t> times;
  for (const BagEntry& entry : reader.index())
    times.push_back(entry.log_time.count());
  return times;
}

} // namespace

using McapFiles = BagTest;

TEST_F(McapFiles, KeepMessagesMetadataAndAttachmentsByteForByte)
{
  std::mt19937_64 random(7);
  McapWriter writer;
  ASSERT_TRUE(writer.open(folder / "bag.mcap", "ros2").ok());
  std::size_t shared = 0;
  std::size_t own = 0;
  ASSERT_TRUE(writer.addChannel(channelOf("/a"), McapChunking::Shared, shared).ok());
  ASSERT_TRUE(writer.addChannel(channelOf("/b"), McapChunking::OwnStream, own).ok());
  std::vector<McapMessage> written;
  // Some are larger than a chunk, some are empty, and some can be compressed.
  for (std::int64_t i = 0; i < 60; ++i) {
    const std::size_t size = i % 20 == 0 ? 3'000'000 : io::test::below(random, 5000);
    written.push_back(messageOf(i % 3 == 0 ? own : shared,
                                1000 + i,
                                i % 2 == 0 ? randomBytes(random, i % 7 == 0 ? 0 : size)
                                           : Bytes(size, 7)));
    ASSERT_TRUE(writer.write(written.back()).ok());
  }
  const McapAttachment attachment{
      Time(1), Time(2), "a", "b/c", randomBytes(random, 99)};
  ASSERT_TRUE(writer.write(attachment).ok());
  ASSERT_TRUE(writer.write(McapMetadata{"m", {{"k", "v"}}}).ok());
  ASSERT_TRUE(writer.finish().ok());

  ASSERT_TRUE(reader.open(folder / "bag.mcap").ok());
  ASSERT_EQ(reader.channels().size(), 2u);
  EXPECT_EQ(reader.channels()[0].topic, "/a");
  EXPECT_EQ(reader.channels()[1].metadata, channelOf("/b").metadata);
  EXPECT_EQ(reader.channels()[1].schema.text, "string data\n");
  ASSERT_EQ(reader.index().size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    ASSERT_TRUE(reader.read(reader.index()[i], message).ok());
    EXPECT_EQ(message.channel, written[i].channel);
    EXPECT_EQ(message.sequence, 3u);
    EXPECT_EQ(message.log_time, written[i].log_time);
    EXPECT_EQ(message.publish_time, written[i].publish_time);
    EXPECT_TRUE(message.bytes == written[i].bytes) << i;
  }
  std::size_t attachments = 0;
  EXPECT_TRUE(reader
                  .readAttachments([&](const McapAttachment& read) {
                    EXPECT_EQ(read.bytes, attachment.bytes);
                    EXPECT_EQ(read.create_time, Time(2));
                    ++attachments;
                    return RecordingStatus();
                  })
                  .ok());
  EXPECT_EQ(attachments, 1u);
  EXPECT_TRUE(reader.damage().empty());
  // With an index of one channel alone.
  const auto wants = [](const McapChannel& channel) { return channel.topic == "/b"; };
  ASSERT_TRUE(reader.open(folder / "bag.mcap", wants).ok());
  EXPECT_EQ(reader.channels().size(), 2u);
  EXPECT_EQ(reader.index().size(), 20u);
  for (const BagEntry& entry : reader.index())
    EXPECT_EQ(entry.channel, own);
}

TEST_F(McapFiles, ChunksOfAllCompressionsAreRead)
{
  const Bytes records = recordsOfThreeMessages();
  Bytes zstd;
  mcap::compress(Bytes(records), zstd);
  const std::pair<std::string, Bytes> compressions[] = {
      {"", records}, {"lz4", compressedByLz4(records)}, {"zstd", zstd}};
  for (const auto& [compression, stored] : compressions) {
    ASSERT_TRUE(open("one.mcap", fileOfOneChunk(compression, records, stored)).ok());
    EXPECT_EQ(timesOf(reader), (std::vector<std::int64_t>{100, 200, 300}))
        << compression;
    EXPECT_TRUE(reader.damage().empty());
    for (const BagEntry& entry : reader.index())
      EXPECT_TRUE(reader.read(entry, message).ok());
    // Of a chunk that is cut off the messages that are whole.
    Bytes cut = fileOfOneChunk(compression, records, stored);
    cut.resize(cut.size() - 60 - 500);
    ASSERT_TRUE(open("cut.mcap", cut).ok());
    EXPECT_LT(reader.index().size(), 3u) << compression;
    EXPECT_EQ(reader.damage().size(), 1u);
    EXPECT_TRUE(reader.isUnfinished());
    for (const BagEntry& entry : reader.index())
      EXPECT_TRUE(reader.read(entry, message).ok());
  }
}

TEST_F(McapFiles, ChunksThatContradictThemselvesAreLeftOutAndReported)
{
  const Bytes records = recordsOfThreeMessages();
  Bytes damaged = records;
  damaged[500] ^= 1;
  Bytes longer = records;
  longer.resize(2 * longer.size());
  const auto lost = [&](const std::string& compression, const Bytes& stored) {
    EXPECT_TRUE(open("bag.mcap", fileOfOneChunk(compression, records, stored)).ok());
    EXPECT_TRUE(reader.index().empty());
    EXPECT_EQ(reader.damage().size(), 1u);
    return reader.damage().empty() ? std::string() : reader.damage().front().message;
  };
  EXPECT_TRUE(hasPart(lost("", damaged), "checksum"));
  EXPECT_TRUE(hasPart(lost("lz4", damaged), "invalid"));
  EXPECT_TRUE(hasPart(lost("zstd", damaged), "invalid"));
  EXPECT_TRUE(
      hasPart(lost("lz4", compressedByLz4(longer)), "more bytes than it declares"));
  EXPECT_TRUE(hasPart(lost("bz2", records), "'bz2' is unknown"));
}

TEST_F(McapFiles, MayHaveMessagesLargerThanCompressedOnesMayBe)
{
  const auto openOneMessage = [&](std::uint64_t size) {
    Bytes file(mcap::magic.begin(), mcap::magic.end());
    mcap::append(mcap::Schema{1, channelOf("/a").schema}, file);
    mcap::append(mcap::Channel{5, 1, channelOf("/a")}, file);
    const std::size_t begin = file.size();
    mcap::append(mcap::MessagePrefix{5, 0, 1, 1}, {}, file);
    std::uint64_t length = mcap::message_prefix_size - mcap::record_prefix_size + size;
    for (std::size_t i = 1; i < mcap::record_prefix_size; ++i, length >>= 8)
      file[begin + i] = static_cast<std::uint8_t>(length);
    writeBytes(folder / "bag.mcap", file);
    std::filesystem::resize_file(folder / "bag.mcap", file.size() + size); // sparse
    ASSERT_TRUE(reader.open(folder / "bag.mcap").ok());
  };
  openOneMessage(max_chunk_bytes + 1);
  const RecordingStatus status = reader.read(reader.index().at(0), message);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(message.bytes.size(), max_chunk_bytes + 1);
  // So may uncompressed chunks.
  EXPECT_GE(mostChunkBytes(max_chunk_bytes + 1), max_chunk_bytes + 1);
  EXPECT_GE(mostChunkBytes(max_record_bytes), max_record_bytes);
  openOneMessage(max_record_bytes + 1);
  EXPECT_TRUE(reader.index().empty());
  EXPECT_TRUE(hasPart(reader.damage().at(0).message,
                      "larger than the limit of 4294967295 bytes"));
}

TEST_F(McapFiles, AChunkThatHardlyTakesBytesIsWrittenAsItCanBeRead)
{
  constexpr std::size_t size = std::size_t{1} << 25;
  McapWriter writer;
  std::size_t channel = 0;
  ASSERT_TRUE(writer.open(folder / "bag.mcap", "ros2").ok());
  ASSERT_TRUE(writer.addChannel(channelOf("/a"), McapChunking::Shared, channel).ok());
  ASSERT_TRUE(writer.write(messageOf(channel, 5, Bytes(size)), true).ok());
  ASSERT_TRUE(writer.finish().ok());
  ASSERT_TRUE(reader.open(folder / "bag.mcap").ok());
  const RecordingStatus status = reader.read(reader.index().at(0), message);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(message.bytes.size(), size);
}

TEST_F(McapFiles, Rosbag2FoldersOfManyFilesAreOneBag)
{
  constexpr std::size_t parts = 200;
  std::filesystem::create_directories(folder / "bag/folder.mcap");
  // All of the same time, so that the order is that of the files.
  for (std::size_t part = 0; part < parts; ++part)
    writeMcap(folder / ("bag/bag_" + std::to_string(part) + ".mcap"),
              {channelOf("/a")},
              {messageOf(0, 5, {static_cast<std::uint8_t>(part)})});
  writeBytes(folder / "bag/metadata.yaml", {});
  const FewDescriptors fewer_than_parts(120);
  ASSERT_TRUE(reader.open(folder / "bag").ok());
  EXPECT_TRUE(reader.damage().empty());
  EXPECT_EQ(reader.channels().size(), 1u);
  ASSERT_EQ(reader.index().size(), parts);
  for (std::size_t i = 0; i < parts; ++i) {
    ASSERT_TRUE(reader.read(reader.index()[i], message).ok());
    EXPECT_EQ(message.bytes, Bytes{static_cast<std::uint8_t>(i)});
  }
}

TEST_F(McapFiles, TimesBeyondTheRangeAreTheLast)
{
  Bytes records;
  for (const std::uint64_t time : {std::uint64_t{1} << 63, std::uint64_t{7}})
    mcap::append(mcap::MessagePrefix{5, 0, time, time}, {}, records);
  ASSERT_TRUE(open("a.mcap", fileOfOneChunk("", records, records)).ok());
  ASSERT_EQ(reader.index().size(), 2u);
  EXPECT_EQ(reader.index()[0].log_time, Time(7));
  EXPECT_EQ(reader.index()[1].log_time, Time::max());
  EXPECT_TRUE(reader.read(reader.index()[1], message).ok());
}

TEST_F(McapFiles, BagsOfOtherStoragesAreRefused)
{
  std::filesystem::create_directories(folder / "bag");
  const std::pair<std::string, std::string> kinds[] = {
      {"compression_format: lz4", "its compression is 'lz4', and only zstd"},
      {"storage_identifier: own", "its storage is 'own', and only mcap and"}};
  for (const auto& [line, reason] : kinds) {
    writeText(folder / "bag/metadata.yaml",
              "rosbag2_bagfile_information:\n  " + line + "\n");
    const RecordingStatus status = reader.open(folder / "bag");
    EXPECT_EQ(status.code(), RecordingCode::NotARecording);
    EXPECT_TRUE(hasPart(status.message(), reason));
    EXPECT_TRUE(hasPart(status.message(), "ros2 bag convert"));
  }
}

TEST(RecordingWriter, RefusesWhatIsNotOneFrame)
{
  const TestFolder folder;
  const KnownStream stream = knownStream(0, 2, 10);
  for (const char* name : {"a.pcxi", "a.mcap"}) {
    RecordingWriter writer;
    std::size_t number = 0;
    std::size_t second = 0;
    ASSERT_TRUE(writer.open(folder / name).ok());
    ASSERT_TRUE(writer.addStream({"/a", "", {}}, number).ok());
    EXPECT_EQ(writer.addStream({"/a", "", {}}, second).code(),
              RecordingCode::InvalidArgument);
    EXPECT_EQ(writer.addStream({"", "", {}}, second).code(),
              RecordingCode::InvalidArgument);
    Bytes bytes = stream.frames[0].bytes;
    const auto append = [&](std::size_t to, Time time) {
      return writer.append(to, time, bytes.data(), bytes.size()).code();
    };
    EXPECT_EQ(append(number, Time(-1)), RecordingCode::InvalidArgument);
    EXPECT_EQ(append(number + 1, Time(1)), RecordingCode::InvalidArgument);
    bytes.push_back(0);
    EXPECT_EQ(append(number, Time(1)), RecordingCode::InvalidArgument);
    bytes.resize(bytes.size() - 2);
    EXPECT_EQ(append(number, Time(1)), RecordingCode::InvalidArgument);
    bytes.clear();
    EXPECT_EQ(append(number, Time(1)), RecordingCode::InvalidArgument);
    bytes = stream.frames[0].bytes;
    EXPECT_EQ(append(number, Time(1)), RecordingCode::Ok);
    EXPECT_TRUE(writer.finish().ok());
    EXPECT_EQ(append(number, Time(1)), RecordingCode::OutputFailed);
    RecordingReader reader;
    ASSERT_TRUE(reader.open(folder / name).ok());
    EXPECT_EQ(reader.streams().front().frames, 1u);
  }
}

TEST(RecordingWriter, AfterARefusedFrameOnlyThoseThatCanBeDecodedAreRecorded)
{
  const TestFolder folder;
  const KnownStream stream = knownStream(0, 30, 10);
  for (const char* name : {"a.pcxi", "a.mcap"}) {
    RecordingWriter writer;
    std::size_t number = 0;
    ASSERT_TRUE(writer.open(folder / name).ok());
    ASSERT_TRUE(writer.addStream({"/a", "", {}}, number).ok());
    std::size_t recorded = 0;
    for (std::size_t i = 0; i < stream.frames.size(); ++i) {
      const auto& frame = stream.frames[i];
      // What is not a frame of the stream leaves no gap, ...
      if (i == 4) {
        EXPECT_EQ(
            writer
                .append(number, frame.time, frame.bytes.data(), frame.bytes.size() - 1)
                .code(),
            RecordingCode::InvalidArgument);
      }
      // ... one that is missing does, until the next I-frame.
      const bool is_refused = i == 13;
      const RecordingStatus status = writer.append(number,
                                                   is_refused ? Time(-1) : frame.time,
                                                   frame.bytes.data(),
                                                   frame.bytes.size());
      EXPECT_EQ(status.code(),
                i >= 13 && i < 20 ? RecordingCode::InvalidArgument : RecordingCode::Ok)
          << i << ": " << status.message();
      recorded += status.ok() ? 1 : 0;
    }
    EXPECT_EQ(recorded, 23u);
    ASSERT_TRUE(writer.finish().ok());
    const ReadRecording read = readAll(folder / name, {stream});
    EXPECT_EQ(read.decoded[0], recorded);
    EXPECT_EQ(read.failed, 0u);
  }
}

TEST(RecordingReader, NamesTheCloudsOfABagWithoutCompressedOnes)
{
  const TestFolder folder;
  PointCloudMessage cloud;
  cloud.format = "draco";
  McapMessage message = messageOf(1, 5, {});
  writePointCloud(cloud, true, message.bytes);
  writeMcap(
      folder / "bag.mcap",
      {pointCloudChannel("/points"), compressedPointCloudChannel("/points/draco")},
      {message});
  RecordingReader reader;
  const RecordingStatus status = reader.open(folder / "bag.mcap");
  EXPECT_EQ(status.code(), RecordingCode::NotARecording);
  EXPECT_TRUE(hasPart(status.message(), "it has clouds on /points"));
  EXPECT_TRUE(hasPart(status.message(), "/points/draco (draco)"));
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

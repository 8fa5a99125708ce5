// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/byte_writer.h"
#include "recording/bag_reader.h"
#include "recording/mcap/records.h"
#include "recording/mcap_stream.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

std::size_t
sumOf(const std::vector<std::size_t>& numbers)
{
  return std::accumulate(numbers.begin(), numbers.end(), std::size_t{0});
}

std::size_t
framesOf(const std::vector<KnownStream>& streams)
{
  std::size_t frames = 0;
  for (const KnownStream& stream : streams)
    frames += stream.frames.size();
  return frames;
}

void
writeByte(const std::string& path, std::size_t offset, std::uint8_t byte)
{
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(offset));
  file.put(static_cast<char>(byte));
}

std::size_t
endOf(const Bytes& part, const Bytes& file)
{
  const auto at = std::search(file.begin(), file.end(), part.begin(), part.end());
  EXPECT_NE(at, file.end());
  return static_cast<std::size_t>(at - file.begin()) + part.size();
}

struct Container {
  const char* name; ///< of the recording
  const char* file; ///< that is damaged
  std::size_t streams;
  bool tells_its_end; ///< whether a reader knows that the end is missing
  std::size_t step;   ///< from one bit that is changed to the next
};

class DamagedRecording : public ::testing::TestWithParam<Container> {
protected:
  void
  recordStreams(std::size_t frames, unsigned int i_frame_rate)
  {
    for (std::size_t i = 0; i < GetParam().streams; ++i)
      streams.push_back(knownStream(i, frames, i_frame_rate));
    record(streams, recording);
  }

  /** \brief Where the frames, or the messages that have them, end in the file. */
  std::vector<std::size_t>
  endsOfFrames() const
  {
    const Bytes bytes = bytesOf(file);
    std::vector<std::size_t> ends;
    BagReader mcap;
    if (!mcap.open(recording).ok()) {
      for (const KnownFrame& frame : streams[0].frames)
        ends.push_back(endOf(frame.bytes, bytes));
      return ends;
    }
    McapMessage message;
    for (const BagEntry& entry : mcap.index()) {
      EXPECT_TRUE(mcap.read(entry, message).ok());
      ends.push_back(endOf(message.bytes, bytes));
    }
    return ends;
  }

  const TestFolder folder;
  const std::string recording = folder / GetParam().name;
  const std::string file = folder / GetParam().file;
  std::vector<KnownStream> streams;
};

/** \brief A file of three messages without a summary.
 * \param[in] first_opcode in place of that of the first message
 * \param[out] first_offset where it is
 */
Bytes
fileWithoutSummary(mcap::Opcode first_opcode, std::size_t& first_offset)
{
  const McapChannel channel = pointCloudChannel("/a");
  Bytes file(mcap::magic.begin(), mcap::magic.end());
  mcap::append(mcap::Schema{1, channel.schema}, file);
  mcap::append(mcap::Channel{5, 1, channel}, file);
  first_offset = file.size();
  for (std::uint64_t time = 1; time <= 3; ++time)
    mcap::append(mcap::MessagePrefix{5, 0, time, time}, Bytes(10), file);
  file[first_offset] = static_cast<std::uint8_t>(first_opcode);
  mcap::appendDataEnd(0, file);
  mcap::appendFooter({}, file);
  file.insert(file.end(), mcap::magic.begin(), mcap::magic.end());
  return file;
}

Bytes
fileWithSummary(const std::string& path)
{
  McapMessage message;
  McapWriter writer;
  EXPECT_TRUE(writer.open(path, "ros2").ok());
  EXPECT_TRUE(
      writer.addChannel(pointCloudChannel("/a"), McapChunking::Shared, message.channel)
          .ok());
  EXPECT_TRUE(writer.write(message, true).ok());
  EXPECT_TRUE(writer.finish().ok());
  return bytesOf(path);
}

/** \brief What is wrong with a file, read by its index and from its beginning on. */
std::vector<RecordingDamage>
damageOf(const std::string& path, std::size_t expected_messages)
{
  BagReader reader;
  EXPECT_TRUE(reader.open(path).ok());
  const Bytes file = bytesOf(path);
  std::size_t position = mcap::magic.size();
  // In pieces that divide what is looked for.
  const auto readSome = [&](std::uint8_t* bytes, std::size_t count) {
    count = std::min({count, std::size_t{7}, file.size() - position});
    std::copy_n(file.data() + position, count, bytes);
    position += count;
    return count;
  };
  McapStream stream(readSome, path);
  std::size_t messages = 0;
  while (stream.next() != McapStream::Found::End)
    ++messages;
  EXPECT_EQ(messages, expected_messages);
  EXPECT_EQ(reader.index().size(), expected_messages);
  EXPECT_EQ(stream.damage().size(), reader.damage().size());
  for (std::size_t i = 0; i < stream.damage().size(); ++i) {
    EXPECT_EQ(stream.damage()[i].offset, reader.damage().at(i).offset);
    EXPECT_EQ(stream.damage()[i].message, reader.damage().at(i).message);
  }
  return reader.damage();
}

} // namespace

TEST_P(DamagedRecording, WithAnyBitChangedHasNoWrongFrameAndLosesNoneWithoutAReport)
{
  recordStreams(3, 10);
  const Bytes original = bytesOf(file);
  const std::size_t frames = framesOf(streams);
  std::size_t fewest = frames;
  for (std::size_t bit = 0; bit < 8 * original.size(); bit += GetParam().step) {
    const auto changed = static_cast<std::uint8_t>(original[bit / 8] ^ 1 << bit % 8);
    writeByte(file, bit / 8, changed);
    const ReadRecording read = readAll(recording, streams);
    writeByte(file, bit / 8, original[bit / 8]);
    ASSERT_EQ(read.wrong, 0u) << "bit " << bit;
    ASSERT_TRUE(read.status.ok()) << "bit " << bit << ": " << read.status;
    const std::size_t decoded = sumOf(read.decoded);
    ASSERT_TRUE(decoded == frames || read.failed + read.damages > 0 ||
                read.is_unfinished)
        << "bit " << bit << ": " << decoded << " frames";
    fewest = std::min(fewest, decoded);
  }
  // A stream of its own chunk is not affected by the other's.
  EXPECT_GE(fewest, streams.size() > 1 ? frames / 2 : 0);
}

TEST_P(DamagedRecording, ThatIsCutAnywhereIsReadUpToTheLastWholeFrame)
{
  recordStreams(4, 2);
  const std::vector<std::size_t> ends = endsOfFrames();
  ASSERT_EQ(ends.size(), framesOf(streams));
  for (std::size_t size = std::filesystem::file_size(file); size-- > 0;) {
    std::filesystem::resize_file(file, size);
    const ReadRecording read = readAll(recording, streams);
    const auto whole = static_cast<std::size_t>(std::count_if(
        ends.begin(), ends.end(), [size](std::size_t end) { return end <= size; }));
    ASSERT_EQ(read.wrong, 0u) << size;
    ASSERT_EQ(read.failed, 0u) << size;
    ASSERT_EQ(sumOf(read.decoded), whole) << size << " bytes";
    const bool is_between_frames =
        std::find(ends.begin(), ends.end(), size) != ends.end();
    ASSERT_TRUE(!read.status.ok() ||
                read.is_unfinished == (GetParam().tells_its_end || !is_between_frames))
        << size;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of,
    DamagedRecording,
    ::testing::Values(Container{"cell.mcap", "cell.mcap", 2, true, 7},
                      Container{"cell", "cell/cell_0.mcap", 1, true, 13},
                      Container{"sensor.pcxi", "sensor.pcxi", 1, false, 1}));

TEST(DamagedRecordings, MessagesAreComparedWithTheirIndex)
{
  const TestFolder folder;
  const std::string path = folder / "cell.mcap";
  record({knownStream(0, 3, 10)}, path);
  BagReader reader;
  ASSERT_TRUE(reader.open(path).ok());
  // The places of two messages of a channel, each after its time, change.
  const BagEntry first = reader.index().at(0);
  const BagEntry second = reader.index().at(1);
  const auto indexed = [](const BagEntry& time, const BagEntry& place) {
    Bytes bytes;
    io::ByteWriter writer(bytes);
    writer.u64(static_cast<std::uint64_t>(time.log_time.count()));
    writer.u64(place.offset);
    return bytes;
  };
  Bytes file = bytesOf(path);
  for (const auto& [entry, other] : {std::pair(first, second), {second, first}}) {
    const Bytes forged = indexed(entry, other);
    std::copy(forged.begin(),
              forged.end(),
              file.begin() + static_cast<std::ptrdiff_t>(
                                 endOf(indexed(entry, entry), file) - forged.size()));
  }
  writeBytes(path, file);
  BagReader forged;
  ASSERT_TRUE(forged.open(path).ok());
  McapMessage message;
  for (const std::size_t i : {0u, 1u}) {
    const RecordingStatus status = forged.read(forged.index().at(i), message);
    EXPECT_TRUE(hasPart(status.message(), "not where the index says"));
  }
  EXPECT_TRUE(forged.read(forged.index().at(2), message).ok());
}

TEST(DamagedRecordings, BytesBetweenFramesAreSkippedAndReported)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 6, 3)};
  Bytes file = {'j', 'u', 'n', 'k'};
  for (std::size_t i = 0; i < 6; ++i) {
    const Bytes& frame = streams[0].frames[i].bytes;
    // The third frame lacks its end.
    file.insert(file.end(), frame.begin(), frame.end() - (i == 2 ? 5 : 0));
    if (i == 3)
      file.insert(file.end(), 1000, std::uint8_t{'P'});
  }
  writeBytes(folder / "sensor.pcxi", file);
  RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "sensor.pcxi").ok());
  EXPECT_EQ(reader.streams().front().frames, 5u);
  ASSERT_EQ(reader.damage().size(), 3u);
  EXPECT_EQ(reader.damage()[0].offset, 0u);
  const std::size_t third =
      4 + streams[0].frames[0].bytes.size() + streams[0].frames[1].bytes.size();
  EXPECT_EQ(reader.damage()[1].offset, third);
  EXPECT_EQ(reader.damage()[2].message, "1000 bytes that are no frame");
  EXPECT_EQ(readAll(folder / "sensor.pcxi", streams).decoded[0], 5u);
}

TEST(DamagedRecordings, FramesAreFoundAcrossTheBlocksThatAreSearched)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 2, 1)};
  const Bytes& first = streams[0].frames[0].bytes;
  const Bytes& second = streams[0].frames[1].bytes;
  // The search begins after the first byte, as the first frame is not followed by
  // another.
  constexpr std::size_t block_end = 1 + (std::size_t{1} << 16);
  for (std::size_t begin = block_end - 7; begin <= block_end + 1; ++begin) {
    Bytes file = first;
    file.resize(begin);
    file.insert(file.end(), second.begin(), second.end());
    writeBytes(folder / "sensor.pcxi", file);
    RecordingReader reader;
    ASSERT_TRUE(reader.open(folder / "sensor.pcxi").ok());
    EXPECT_EQ(reader.streams().front().frames, 2u) << begin;
    EXPECT_EQ(readAll(folder / "sensor.pcxi", streams).decoded[0], 2u) << begin;
  }
}

TEST(DamagedRecordings, WhatIsNoRecordingIsRefusedWithItsKind)
{
  const TestFolder folder;
  const auto refused = [&](const std::string& name, const Bytes& bytes) {
    writeBytes(folder / name, bytes);
    RecordingReader reader;
    const RecordingStatus status = reader.open(folder / name);
    EXPECT_EQ(status.code(), RecordingCode::NotARecording) << name;
    EXPECT_TRUE(hasPart(status.message(), name));
    EXPECT_TRUE(reader.streams().empty() || reader.streams().front().frames == 0);
    return status.message();
  };
  EXPECT_TRUE(hasPart(refused("empty", {}), "is empty"));
  const std::string pcd = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n";
  EXPECT_TRUE(hasPart(refused("cloud.pcd", Bytes(pcd.begin(), pcd.end())), "PCD"));
  refused("zeros", Bytes(100'000));
  refused("short.mcap", {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'});
  RecordingReader reader;
  EXPECT_EQ(reader.open(folder / "missing").code(), RecordingCode::InputFailed);
  EXPECT_EQ(reader.open(folder / "").code(), RecordingCode::InputFailed);
}

TEST(DamagedRecordings, OfMcapHaveBytesAfterTheirEnd)
{
  const TestFolder folder;
  std::size_t first = 0;
  const Bytes with_summary = fileWithSummary(folder / "one.mcap");
  const Bytes without = fileWithoutSummary(mcap::Opcode::Message, first);
  EXPECT_TRUE(damageOf(folder / "one.mcap", 1).empty());
  for (const Bytes& file : {with_summary, without})
    for (const Bytes& appended : {with_summary, without, Bytes(5000), Bytes(1)}) {
      Bytes both = file;
      both.insert(both.end(), appended.begin(), appended.end());
      writeBytes(folder / "two.mcap", both);
      const std::vector<RecordingDamage> damage =
          damageOf(folder / "two.mcap", file == with_summary ? 1 : 3);
      ASSERT_EQ(damage.size(), 1u);
      EXPECT_EQ(damage[0].offset, file.size());
      EXPECT_TRUE(hasPart(damage[0].message,
                          std::to_string(appended.size()) + " bytes follow the end"));
    }
}

TEST(DamagedRecordings, OfMcapDoNotEndAtAnEndOfAnotherLength)
{
  const TestFolder folder;
  for (const mcap::Opcode opcode : {mcap::Opcode::DataEnd, mcap::Opcode::Footer}) {
    std::size_t damaged = 0;
    writeBytes(folder / "bag.mcap", fileWithoutSummary(opcode, damaged));
    const std::vector<RecordingDamage> damage = damageOf(folder / "bag.mcap", 2);
    ASSERT_EQ(damage.size(), 1u);
    EXPECT_EQ(damage[0].offset, damaged);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/bag_contents.h"
#include "recording/bag_test.h"
#include "support/recorded_streams.h"
#include "support/ros1_bags.h"

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

constexpr std::size_t chunks = 5;
constexpr std::size_t chunk_messages = 30;
constexpr std::uint64_t epoch = 1'700'000'000'000'000'000;
constexpr std::size_t prefix_size = 46; // of a message: its header and two sizes

Bytes
bytesOfMessage(std::size_t i)
{
  Bytes bytes(i % 10 == 0 ? 3000 : 20 + i);
  for (std::size_t k = 0; k < bytes.size(); ++k)
    bytes[k] = static_cast<std::uint8_t>(i * 31 + k * k);
  return bytes;
}

/** \brief Adds messages of three connections in turn, i nanoseconds after the epoch. */
void
addMessages(Ros1Bag& bag, std::size_t begin, std::size_t end)
{
  for (std::size_t i = begin; i < end; ++i)
    bag.addMessage(
        static_cast<std::uint32_t>(10 + i % 3), epoch + i, bytesOfMessage(i));
}

Ros1Bag
bagOfChunks(const std::string& compression, std::size_t count = chunks)
{
  Ros1Bag bag(compression);
  bag.addConnection(10, "/points", "sensor_msgs/PointCloud2", "Header header");
  bag.addConnection(
      11, "/points", "sensor_msgs/PointCloud2", "Header header", "/other");
  bag.addConnection(12, "/note", "std_msgs/String", "string data");
  for (std::size_t chunk = 0; chunk < count; ++chunk) {
    addMessages(bag, chunk_messages * chunk, chunk_messages * (chunk + 1));
    bag.endChunk();
  }
  return bag;
}

/** \brief The numbers of the messages that can be read, whose content is checked. */
std::vector<std::size_t>
readNumbers(BagReader& reader)
{
  std::vector<std::size_t> numbers;
  McapMessage message;
  for (const BagEntry& entry : reader.index()) {
    if (!reader.read(entry, message).ok())
      continue;
    const auto i =
        static_cast<std::size_t>(entry.log_time.count() - Time(epoch).count());
    EXPECT_EQ(message.bytes, bytesOfMessage(i));
    EXPECT_EQ(message.publish_time, entry.log_time);
    EXPECT_EQ(reader.channels()[entry.channel].topic, i % 3 == 2 ? "/note" : "/points");
    EXPECT_EQ(message.channel, entry.channel);
    numbers.push_back(i);
  }
  return numbers;
}

std::vector<const char*>
compressions()
{
#ifdef PCL_EXT_HAS_BZIP2
  return {"none", "lz4", "bz2"};
#else
  return {"none", "lz4"};
#endif
}

/** \brief The numbers of all messages but those of the second chunk. */
std::vector<std::size_t>
numbersOfOtherChunks()
{
  std::vector<std::size_t> others = numbersFrom(0, chunks * chunk_messages);
  others.erase(others.begin() + chunk_messages, others.begin() + 2 * chunk_messages);
  return others;
}

Bytes
firstBytes(const Bytes& bytes, std::size_t size)
{
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

} // namespace

using Ros1Bags = BagTest;

TEST_F(Ros1Bags, HaveTheMessagesOfAllConnections)
{
  for (const char* const compression : compressions()) {
    SCOPED_TRACE(compression);
    ASSERT_TRUE(open("x.bag", bagOfChunks(compression).bytes()).ok());
    EXPECT_TRUE(BagReader::isBag(folder / "x.bag"));
    EXPECT_EQ(reader.profile(), "ros1");
    EXPECT_FALSE(reader.isUnfinished());
    EXPECT_EQ(readNumbers(reader), numbersFrom(0, chunks * chunk_messages));
    EXPECT_TRUE(reader.damage().empty());
    ASSERT_EQ(reader.channels().size(), 3u);
    const McapChannel& channel = reader.channels()[1];
    EXPECT_EQ(channel.topic, "/points");
    EXPECT_EQ(channel.message_encoding, "ros1");
    EXPECT_EQ(channel.schema.name, "sensor_msgs/PointCloud2");
    EXPECT_EQ(channel.schema.encoding, "ros1msg");
    EXPECT_EQ(channel.schema.text, "Header header");
    EXPECT_EQ(channel.metadata.at("callerid"), "/other");
    EXPECT_EQ(channel.metadata.at("md5sum"), "0123456789abcdef0123456789abcdef");
  }
  const auto wants = [](const McapChannel& channel) {
    return channel.topic == "/note";
  };
  ASSERT_TRUE(reader.open(folder / "x.bag", wants).ok());
  EXPECT_EQ(reader.channels().size(), 3u);
  EXPECT_EQ(reader.index().size(), chunks * chunk_messages / 3);
  // It may be empty.
  ASSERT_TRUE(open("x.bag", Ros1Bag().bytes()).ok());
  EXPECT_TRUE(reader.channels().empty());
  EXPECT_TRUE(reader.damage().empty());
  EXPECT_FALSE(reader.isUnfinished());
}

TEST_F(Ros1Bags, ConnectionsThatAgreeAreOneChannel)
{
  Ros1Bag bag;
  for (std::uint32_t connection : {3u, 70'000u, 5u})
    bag.addConnection(connection, "/points", "x/Y", "int8 a");
  bag.addConnection(9, "/points", "x/Y", "int8 b");
  std::size_t i = 0;
  for (std::uint32_t connection : {3u, 70'000u, 9u, 5u})
    bag.addMessage(connection, epoch + i++, {});
  bag.endChunk();
  ASSERT_TRUE(open("x.bag", bag.bytes()).ok());
  ASSERT_EQ(reader.channels().size(), 2u);
  ASSERT_EQ(reader.index().size(), 4u);
  for (std::size_t entry = 0; entry < 4; ++entry)
    EXPECT_EQ(reader.index()[entry].channel, entry == 2 ? 1u : 0u);
}

TEST_F(Ros1Bags, ThatAreCutOffHaveAllWholeMessages)
{
  const Bytes all = bagOfChunks("none").bytes();
  // Where each message ends, found by its bytes.
  std::vector<std::size_t> ends;
  for (std::size_t i = 0; i < chunks * chunk_messages; ++i) {
    const Bytes bytes = bytesOfMessage(i);
    const auto found = std::search(all.begin(), all.end(), bytes.begin(), bytes.end());
    ends.push_back(static_cast<std::size_t>(found - all.begin()) + bytes.size());
  }
  for (std::size_t size = Ros1Bag().begin(); size < all.size(); size += 97) {
    SCOPED_TRACE(size);
    ASSERT_TRUE(open("x.bag", firstBytes(all, size)).ok());
    std::size_t whole = 0;
    while (whole < ends.size() && ends[whole] <= size)
      ++whole;
    ASSERT_EQ(readNumbers(reader), numbersFrom(0, whole));
    EXPECT_TRUE(reader.isUnfinished());
    EXPECT_FALSE(reader.damage().empty());
  }
  for (std::size_t size = 0; size < 12; ++size)
    EXPECT_FALSE(open("x.bag", firstBytes(all, size)).ok());
}

TEST_F(Ros1Bags, ThatAreCutOffHaveAllWholeChunks)
{
  for (const char* const compression : compressions()) {
    const Bytes all = bagOfChunks(compression).bytes();
    std::vector<std::size_t> ends;
    for (std::size_t count = 0; count <= chunks; ++count)
      ends.push_back(bagOfChunks(compression, count).size());
    for (std::size_t size = Ros1Bag().begin(); size < ends.back(); size += 301) {
      ASSERT_TRUE(open("x.bag", firstBytes(all, size)).ok());
      std::size_t whole = 0;
      while (ends[whole + 1] <= size)
        ++whole;
      const std::vector<std::size_t> numbers = readNumbers(reader);
      EXPECT_EQ(numbers, numbersFrom(0, numbers.size()));
      EXPECT_GE(numbers.size(), whole * chunk_messages) << compression << " " << size;
    }
  }
}

TEST_F(Ros1Bags, ThatAreBeingRecordedHaveTheLastChunkToo)
{
  for (const char* const compression : compressions()) {
    SCOPED_TRACE(compression);
    Ros1Bag bag = bagOfChunks(compression, 2);
    addMessages(bag, 2 * chunk_messages, 3 * chunk_messages);
    ASSERT_TRUE(open("x.bag", bag.unfinishedBytes()).ok());
    EXPECT_TRUE(reader.isUnfinished());
    EXPECT_TRUE(reader.damage().empty());
    EXPECT_EQ(readNumbers(reader), numbersFrom(0, 3 * chunk_messages));
  }
}

TEST_F(Ros1Bags, WithoutIndexesAreReadInAll)
{
  for (const char* const compression : compressions())
    for (const bool has_connections : {true, false}) {
      Ros1Bag bag(compression);
      bag.has_indexes = false;
      bag.has_connections = has_connections;
      bag.addConnection(10, "/points", "sensor_msgs/PointCloud2");
      bag.addConnection(11, "/points", "sensor_msgs/PointCloud2");
      bag.addConnection(12, "/note", "std_msgs/String");
      for (std::size_t i = 0; i < 90; i += 30) {
        addMessages(bag, i, i + 30);
        bag.endChunk();
      }
      ASSERT_TRUE(open("x.bag", bag.bytes()).ok());
      EXPECT_EQ(readNumbers(reader), numbersFrom(0, 90));
      EXPECT_TRUE(reader.damage().empty());
    }
}

TEST_F(Ros1Bags, OfWhichAChunkIsDamagedHaveTheOthers)
{
  for (const char* const compression : compressions()) {
    if (std::string(compression) == "none")
      continue; // it has no checksum
    SCOPED_TRACE(compression);
    const std::size_t second = bagOfChunks(compression, 1).size();
    Bytes bytes = bagOfChunks(compression).bytes();
    for (std::size_t i = 0; i < 8; ++i)
      bytes[second + 1000 + i] ^= 0x5a;
    ASSERT_TRUE(open("x.bag", bytes).ok());
    EXPECT_EQ(readNumbers(reader), numbersOfOtherChunks());
    ASSERT_EQ(reader.damage().size(), 1u);
    EXPECT_EQ(reader.damage()[0].offset, second);
    EXPECT_TRUE(hasPart(reader.damage()[0].message, "a chunk: "));
  }
}

TEST_F(Ros1Bags, GoOnAtTheNextChunkAfterALengthThatIsWrong)
{
  const std::size_t second = bagOfChunks("none", 1).size();
  const Bytes all = bagOfChunks("none").bytes();
  // The size of the chunk's header, and that of its data behind the header.
  const std::size_t header = all[second] + 256u * all[second + 1];
  for (const std::size_t place : {second, second + 4 + header})
    for (const int value : {0x01, 0xff}) {
      Bytes bytes = all;
      bytes[place + 2] = static_cast<std::uint8_t>(value);
      ASSERT_TRUE(open("x.bag", bytes).ok());
      EXPECT_FALSE(reader.damage().empty());
      const std::vector<std::size_t> numbers = readNumbers(reader);
      const std::vector<std::size_t> others = numbersOfOtherChunks();
      EXPECT_TRUE(
          std::includes(numbers.begin(), numbers.end(), others.begin(), others.end()));
    }
}

TEST_F(Ros1Bags, MessagesOfUnknownConnectionsAreDamage)
{
  Ros1Bag bag;
  bag.addConnection(10, "/points", "sensor_msgs/PointCloud2");
  bag.addConnection(11, "/points", "sensor_msgs/PointCloud2");
  addMessages(bag, 0, 30); // those of connection 12, too
  bag.endChunk();
  ASSERT_TRUE(open("x.bag", bag.bytes()).ok());
  EXPECT_EQ(readNumbers(reader).size(), 20u);
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_TRUE(hasPart(reader.damage()[0].message, "10 messages are of connections"));
}

TEST_F(Ros1Bags, IndexesThatAreWrongAreNotBelieved)
{
  const auto entry = [](std::uint64_t i, std::uint64_t offset) {
    return ros1Time(epoch + i) + littleEndian(offset, 4);
  };
  Ros1Bag bag;
  bag.addConnection(12, "/note", "std_msgs/String");
  const std::size_t connection_size = [] {
    Ros1Bag only;
    only.addConnection(12, "/note", "std_msgs/String");
    const std::size_t empty = Ros1Bag().unfinishedBytes().size();
    return only.unfinishedBytes().size() - empty;
  }();
  // A message within the message.
  Bytes inner = bytesOfMessage(2);
  const std::string forged = ros1Record(
      2, {{"conn", littleEndian(12, 4)}, {"time", ros1Time(epoch + 5)}}, "y");
  inner.insert(inner.begin(), forged.begin(), forged.end());
  bag.addMessage(12, epoch + 2, inner);
  bag.has_indexes = false;
  bag.endChunk();
  const auto withIndex = [&bag](const std::string& entries) {
    Ros1Bag indexed = bag;
    indexed.add(ros1Record(4,
                           {{"ver", littleEndian(1, 4)},
                            {"conn", littleEndian(12, 4)},
                            {"count", littleEndian(entries.size() / 12, 4)}},
                           entries));
    return indexed.bytes();
  };
  const std::pair<std::string, bool> cases[] = {
      {entry(2, connection_size), true},
      {entry(5, connection_size + prefix_size), false},              // the one within
      {entry(3, connection_size), false},                            // another time
      {entry(2, connection_size) + entry(2, connection_size), true}, // twice
      {entry(2, connection_size) + entry(3, 4'000'000'000), true},   // outside
      {entry(2, 0), false}};
  for (const auto& [entries, is_readable] : cases) {
    ASSERT_TRUE(open("x.bag", withIndex(entries)).ok());
    ASSERT_EQ(reader.index().size(), 1u);
    EXPECT_EQ(reader.read(reader.index()[0], message).ok(), is_readable);
    EXPECT_EQ(reader.damage().empty(), is_readable);
    if (is_readable) {
      EXPECT_EQ(message.bytes, inner);
    }
  }
}

TEST_F(Ros1Bags, SizesAreNotBelieved)
{
  for (const char* const compression : compressions())
    for (const std::uint64_t size : {std::uint64_t{3}, std::uint64_t{0xffffffff}}) {
      Ros1Bag bag(compression);
      bag.addConnection(12, "/note", "std_msgs/String");
      bag.addMessage(12, epoch + 2, bytesOfMessage(2));
      bag.addChunk(compressedChunk(compression, std::string(100'000, 'x')), size);
      ASSERT_TRUE(open("x.bag", bag.bytes()).ok());
      EXPECT_TRUE(readNumbers(reader).empty());
      EXPECT_FALSE(reader.damage().empty());
    }
}

#ifdef PCL_EXT_HAS_BZIP2
TEST_F(Ros1Bags, ThatDecompressToVeryManyBytesHaveAnEnd)
{
  // Each chunk of 16 MiB takes some hundred bytes; they are searched for messages until
  // they are 256 MiB and 300 times the file.
  constexpr std::size_t size = std::size_t{1} << 24;
  const std::string bytes = compressedChunk("bz2", std::string(size, '\0'));
  ASSERT_LT(bytes.size(), 1000u);
  // What is damaged counts, too.
  for (const std::size_t declared : {size, size + 1}) {
    Ros1Bag bag("bz2");
    for (int i = 0; i < 30; ++i)
      bag.addChunk(bytes, declared);
    ASSERT_TRUE(open("x.bag", bag.bytes()).ok());
    EXPECT_TRUE(reader.index().empty());
    const auto isRefused = [](const RecordingDamage& place) {
      return hasPart(place.message, "larger than a file of this size may have");
    };
    const auto refused =
        std::count_if(reader.damage().begin(), reader.damage().end(), isRefused);
    EXPECT_GT(refused, 5);
    EXPECT_LT(refused, 20);
  }
  const std::string bomb = compressedChunk("bz2", std::string(2 * size, '\0'));
  Ros1Bag large("bz2");
  large.addChunk(bomb, 2 * size);
  ASSERT_TRUE(open("x.bag", large.bytes()).ok());
  EXPECT_TRUE(hasPart(reader.damage().at(0).message, "larger than the limit"));
}
#endif

TEST_F(Ros1Bags, WhoseMessagesComeFromLargeChunksInTurnHaveAnEnd)
{
  constexpr std::uint64_t chunks = 8; // of 12 MiB, of which the cache has five
  constexpr std::uint64_t rounds = 40;
  Ros1Bag bag("lz4");
  bag.addConnection(12, "/note", "std_msgs/String");
  for (std::uint64_t chunk = 0; chunk < chunks; ++chunk) {
    bag.addMessage(12, epoch + chunk, Bytes(std::size_t{12} << 20));
    for (std::uint64_t i = 1; i <= rounds; ++i)
      bag.addMessage(12, epoch + 100 * i + chunk, bytesOfMessage(3));
    bag.endChunk();
  }
  ASSERT_TRUE(open("x.bag", bag.bytes()).ok());
  ASSERT_EQ(reader.index().size(), chunks * (rounds + 1));
  std::size_t read = 0;
  for (const BagEntry& entry : reader.index())
    read += reader.read(entry, message).ok() ? 1 : 0;
  // Each message takes its chunk again, until these are 1 GiB and 1000 times the file.
  const std::size_t most =
      ((std::size_t{1} << 30) + 1000 * bag.bytes().size()) / (std::size_t{12} << 20) +
      1;
  // Afterwards only those of the five chunks that the cache has are read.
  ASSERT_LT(most, reader.index().size());
  const std::size_t cached = (reader.index().size() - most) * 5 / chunks;
  EXPECT_LE(read, most + cached + 5);
  EXPECT_GE(read, most + cached - 5);
  EXPECT_TRUE(hasPart(reader.damage().at(0).message, "come in turn, too often"));
  // Whoever goes back may read as much again.
  for (std::size_t i = chunks; i-- > 0;)
    EXPECT_TRUE(reader.read(reader.index()[i], message).ok());
}

TEST_F(Ros1Bags, OfOtherFormatsAreNamed)
{
  const std::string old = "#ROSBAG V1.2\nx";
  EXPECT_TRUE(hasPart(open("x.bag", {old.begin(), old.end()}).message(),
                      "no bag of ROS 1's format 2.0: 'rosbag filter'"));
  const std::string encrypted =
      "#ROSBAG V2.0\n" + ros1Record(3,
                                    {{"index_pos", littleEndian(0, 8)},
                                     {"encryptor", "rosbag/AesCbcEncryptor"}},
                                    "");
  EXPECT_TRUE(hasPart(open("x.bag", {encrypted.begin(), encrypted.end()}).message(),
                      "is encrypted (rosbag/AesCbcEncryptor)"));
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

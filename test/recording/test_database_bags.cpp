// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/bag_test.h"
#include "recording/point_cloud_messages.h"
#include "support/database_bags.h"

#include <algorithm>
#include <filesystem>
#include <map>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

namespace fs = std::filesystem;

constexpr char cloud_type[] = "sensor_msgs/msg/PointCloud2";
constexpr char qos[] = "- history: 3\n  depth: 0";

/** \brief Message i, which spans several pages where i is a multiple of 5. */
Bytes
bytesOfMessage(std::size_t i)
{
  Bytes bytes((i % 5 == 0 ? 5000 : 40) + i);
  for (std::size_t k = 0; k < bytes.size(); ++k)
    bytes[k] = static_cast<std::uint8_t>(k == 0 ? 0 : 7 * i + k);
  return bytes;
}

void
fill(DatabaseBag& bag, std::size_t begin, std::size_t end)
{
  bag.addTopic(7, "/points", cloud_type, qos);
  bag.addTopic(3, "/imu", "sensor_msgs/msg/Imu", "");
  for (std::size_t i = begin; i < end; ++i)
    bag.addMessage(i % 2 == 0 ? 7 : 3, static_cast<std::int64_t>(i), bytesOfMessage(i));
}

/** \brief Reads all messages, and expects each to be one of fill(). */
std::vector<std::size_t>
readNumbers(BagReader& reader)
{
  std::vector<std::size_t> numbers;
  for (const BagEntry& entry : reader.index()) {
    McapMessage message;
    if (!reader.read(entry, message).ok())
      continue;
    numbers.push_back(static_cast<std::size_t>(message.log_time.count()));
    EXPECT_EQ(message.bytes, bytesOfMessage(numbers.back()));
    EXPECT_EQ(reader.channels()[message.channel].topic,
              numbers.back() % 2 == 0 ? "/points" : "/imu");
    EXPECT_EQ(message.publish_time, message.log_time);
  }
  return numbers;
}

std::map<std::string, Bytes>
filesIn(const fs::path& folder)
{
  std::map<std::string, Bytes> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = bytesOf(entry.path().string());
  return files;
}

} // namespace

using DatabaseBags = BagTest;

TEST_F(DatabaseBags, HaveTopicsAndMessages)
{
  fs::create_directories(folder / "bag");
  {
    DatabaseBag bag(folder / "bag/x.db3");
    fill(bag, 0, 100);
  }
  const auto files = filesIn(folder / "bag");
  EXPECT_TRUE(BagReader::isBag(folder / "bag/x.db3"));
  ASSERT_TRUE(reader.open(folder / "bag/x.db3").ok());
  EXPECT_TRUE(reader.hasDatabases());
  EXPECT_FALSE(reader.isUnfinished());
  EXPECT_EQ(reader.profile(), "ros2");
  ASSERT_EQ(reader.channels().size(), 2u);
  const McapChannel& imu = reader.channels()[0];
  EXPECT_EQ(imu.topic, "/imu");
  EXPECT_EQ(imu.message_encoding, "cdr");
  EXPECT_EQ(imu.schema.name, "sensor_msgs/msg/Imu");
  EXPECT_TRUE(imu.metadata.empty());
  const McapChannel& points = reader.channels()[1];
  EXPECT_TRUE(isPointCloud(points));
  EXPECT_EQ(points.schema.text, pointCloudChannel("").schema.text);
  EXPECT_EQ(points.metadata.at("offered_qos_profiles"), qos);
  EXPECT_EQ(readNumbers(reader), numbersFrom(0, 100));
  EXPECT_TRUE(reader.damage().empty());
  EXPECT_EQ(filesIn(folder / "bag"), files);

  ASSERT_TRUE(reader.open(folder / "bag/x.db3", isPointCloud).ok());
  EXPECT_EQ(readNumbers(reader).size(), 50u);
}

TEST_F(DatabaseBags, HaveDefinitionsSinceIron)
{
  {
    DatabaseBag bag(folder / "x.db3");
    bag.execute("ALTER TABLE topics ADD COLUMN type_description_hash TEXT");
    fill(bag, 0, 1);
    bag.execute("UPDATE topics SET type_description_hash = 'RIHS01_2' WHERE id = 3");
    bag.execute(
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT, "
        "encoding TEXT, encoded_message_definition TEXT, type_description_hash "
        "TEXT); INSERT INTO message_definitions VALUES(1, 'sensor_msgs/msg/Imu', "
        "'ros2msg', 'float64 x', '')");
  }
  ASSERT_TRUE(reader.open(folder / "x.db3").ok());
  EXPECT_EQ(reader.channels()[0].schema.encoding, "ros2msg");
  EXPECT_EQ(reader.channels()[0].schema.text, "float64 x");
  EXPECT_EQ(reader.channels()[0].metadata.at("topic_type_hash"), "RIHS01_2");
}

TEST_F(DatabaseBags, MayHaveTheFramesOfARecording)
{
  const KnownStream stream = knownStream(0, 12, 5);
  {
    DatabaseBag bag(folder / "x.db3");
    bag.addTopic(
        1, stream.name, "point_cloud_interfaces/msg/CompressedPointCloud2", qos);
    PointCloudMessage cloud;
    Bytes bytes;
    for (const KnownFrame& frame : stream.frames) {
      cloud.stamp = frame.time;
      cloud.bytes = frame.bytes;
      writePointCloud(cloud, true, bytes);
      bag.addMessage(1, frame.time.count(), bytes);
    }
  }
  RecordingReader recording;
  ASSERT_TRUE(recording.open(folder / "x.db3").ok());
  ASSERT_EQ(recording.streams().size(), 1u);
  EXPECT_EQ(recording.streams()[0].name, stream.name);
  EXPECT_EQ(recording.streams()[0].frames, 12u);
  RecordedFrame frame;
  for (const KnownFrame& known : stream.frames) {
    ASSERT_TRUE(recording.next(frame).ok());
    EXPECT_EQ(frame.time, known.time);
    EXPECT_EQ(frame.stamp, known.time);
    EXPECT_EQ(frame.bytes, known.bytes);
  }
}

TEST_F(DatabaseBags, MayHaveMessagesLargerThanCompressedOnesMayBe)
{
  constexpr std::size_t size = max_chunk_bytes + 1;
  {
    DatabaseBag bag(folder / "x.db3");
    bag.addTopic(1, "/x", "std_msgs/msg/String", "");
    bag.addMessage(1, 0, Bytes(size));
  }
  ASSERT_TRUE(reader.open(folder / "x.db3").ok());
  const RecordingStatus status = reader.read(reader.index().at(0), message);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(message.bytes.size(), size);
}

TEST_F(DatabaseBags, OfSeveralFilesAreOne)
{
  for (const std::string name : {"bag", "renamed", "rosbag2_2024_05_01-10_00_00"}) {
    const std::string path = folder / (name == "renamed" ? name : "a" + name);
    const std::string stem = path + '/' + (name == "bag" ? "x" : "rosbag2_2024");
    fs::create_directories(path);
    for (std::size_t part = 0; part < 12; ++part) { // 10 comes after 9
      DatabaseBag bag(stem + '_' + std::to_string(part) + ".db3");
      fill(bag, 10 * part, 10 * part + 10);
    }
    if (name == "bag")
      writeBytes(path + "/metadata.yaml", {});
    EXPECT_TRUE(BagReader::isBag(path));
    ASSERT_TRUE(reader.open(path).ok());
    EXPECT_EQ(reader.channels().size(), 2u);
    EXPECT_EQ(readNumbers(reader), numbersFrom(0, 120));
  }
}

TEST_F(DatabaseBags, AreReadWithTheLogThatARecorderLeft)
{
  fs::create_directories(folder / "left");
  {
    DatabaseBag bag(folder / "x.db3", true);
    fill(bag, 0, 60);
    bag.commit();
    bag.execute("BEGIN");
    for (const std::string suffix : {"", "-wal"})
      fs::copy_file((folder / "x.db3") + suffix, (folder / "left/x.db3") + suffix);
  }
  const auto files = filesIn(folder / "left");
  ASSERT_EQ(files.size(), 2u);
  ASSERT_TRUE(reader.open(folder / "left/x.db3").ok());
  EXPECT_TRUE(reader.isUnfinished());
  EXPECT_EQ(readNumbers(reader), numbersFrom(0, 60));
  reader = BagReader();
  EXPECT_EQ(filesIn(folder / "left"), files);
  // A journal of a write that was not completed is no reason to refuse the rest.
  fs::remove(folder / "left/x.db3-wal");
  fs::copy_file(folder / "x.db3", folder / "left/y.db3");
  writeBytes(folder / "left/y.db3-journal", Bytes(600, 1));
  ASSERT_TRUE(reader.open(folder / "left/y.db3").ok());
  EXPECT_EQ(readNumbers(reader), numbersFrom(0, 60));
  EXPECT_EQ(reader.damage().size(), 1u);
}

TEST_F(DatabaseBags, ThatAreCutOffAreReadAsFarAsTheyGo)
{
  {
    DatabaseBag bag(folder / "x.db3");
    fill(bag, 0, 300);
  }
  const Bytes all = bytesOf(folder / "x.db3");
  std::size_t most = 0;
  for (std::size_t size = all.size(); size > 1024;
       size -= std::min<std::size_t>(size, 7777)) {
    writeBytes(folder / "cut.db3",
               Bytes(all.begin(), all.begin() + static_cast<long>(size)));
    if (!reader.open(folder / "cut.db3").ok())
      continue;
    const std::vector<std::size_t> numbers = readNumbers(reader);
    EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
    EXPECT_TRUE(numbers.size() == 300 || !reader.damage().empty());
    if (size < all.size() * 3 / 4)
      most = std::max(most, numbers.size());
  }
  EXPECT_GT(most, 150u);
}

TEST_F(DatabaseBags, OfWhichAPageIsLostAreReadBeforeAndAfterIt)
{
  {
    DatabaseBag bag(folder / "x.db3");
    bag.addTopic(7, "/points", cloud_type, qos);
    bag.addTopic(3, "/imu", "sensor_msgs/msg/Imu", "");
    for (std::size_t i = 1; i < 800; i += i % 5 == 4 ? 2 : 1) // all within their pages
      bag.addMessage(
          i % 2 == 0 ? 7 : 3, static_cast<std::int64_t>(i), bytesOfMessage(i));
  }
  const Bytes all = bytesOf(folder / "x.db3");
  ASSERT_TRUE(reader.open(folder / "x.db3").ok());
  const std::size_t count = readNumbers(reader).size();
  ASSERT_EQ(count, 640u);
  std::size_t skipped = 0;
  for (std::size_t page = 1; page < all.size() / 1024; ++page) {
    Bytes damaged = all;
    std::fill_n(damaged.begin() + static_cast<long>(1024 * page), 1024, 0xa5);
    writeBytes(folder / "y.db3", damaged);
    if (!reader.open(folder / "y.db3").ok())
      continue;
    const std::size_t left = readNumbers(reader).size();
    EXPECT_TRUE(left == count || !reader.damage().empty());
    skipped += left < count && left > count - 20 ? 1 : 0;
  }
  EXPECT_GT(skipped, 60u); // those with messages
}

TEST_F(DatabaseBags, ThatAreNoneAreRefused)
{
  const std::pair<const char*, const char*> changes[] = {
      {"none", "DROP TABLE messages"},
      {"view",
       "DROP TABLE messages; CREATE VIEW messages AS WITH RECURSIVE endless(id) AS "
       "(SELECT 1 UNION ALL SELECT id + 1 FROM endless) SELECT id, 7 AS topic_id, 5 AS "
       "timestamp, zeroblob(1000) AS data FROM endless"},
      {"virtual",
       "DROP TABLE messages; CREATE VIRTUAL TABLE messages USING fts5(topic_id, "
       "data)"}};
  for (const auto& [name, change] : changes) {
    const std::string path = folder / (std::string(name) + ".db3");
    {
      DatabaseBag bag(path);
      fill(bag, 0, 3);
      bag.commit();
      bag.execute(change);
      bag.execute("BEGIN");
    }
    const RecordingStatus status = reader.open(path);
    EXPECT_EQ(status.code(), RecordingCode::NotARecording) << name;
    EXPECT_TRUE(hasPart(status.message(), "no bag of rosbag2")) << status;
  }
}

TEST_F(DatabaseBags, MayHaveNumbersInPlaceOfBytes)
{
  {
    DatabaseBag bag(folder / "x.db3");
    fill(bag, 0, 4);
    bag.execute("UPDATE messages SET data = 5 WHERE id = 2");
    bag.execute("UPDATE messages SET topic_id = 99 WHERE id = 3");
    bag.execute("UPDATE messages SET timestamp = -5 WHERE id = 4");
  }
  ASSERT_TRUE(reader.open(folder / "x.db3").ok());
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_TRUE(hasPart(reader.damage()[0].message, "1 messages are of no topic"));
  ASSERT_EQ(reader.index().size(), 3u);
  std::size_t read = 0;
  for (const BagEntry& entry : reader.index()) {
    read += reader.read(entry, message).ok() ? 1 : 0;
    EXPECT_GE(message.log_time, Time(0));
  }
  EXPECT_EQ(read, 2u);
  EXPECT_EQ(reader.damage().size(), 2u);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

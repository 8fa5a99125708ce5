// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"
#include "support/ros1_bags.h"
#include "support/text_parts.h"
#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <filesystem>

namespace pcl_ext::tools::test {

namespace {

using pcl_ext::test::hasPart;
using recording::test::littleEndian;
using recording::test::Ros1Bag;
using recording::test::sized;

constexpr std::uint64_t second = 1'000'000'000;

/** \brief Bytes of sensor_msgs/PointCloud2: little-endian and without padding. */
Bytes
cloudMessage(const pcl::PointCloud<pcl::PointXYZI>& cloud, std::uint32_t seconds)
{
  std::string bytes = littleEndian(9, 4) + littleEndian(seconds, 4) +
                      littleEndian(250'000'000, 4) + sized("lidar") +
                      littleEndian(1, 4) + littleEndian(cloud.size(), 4) +
                      littleEndian(4, 4);
  std::uint32_t offset = 0;
  for (const char* field : {"x", "y", "z", "intensity"}) {
    bytes += sized(field) + littleEndian(offset, 4) + '\7' + littleEndian(1, 4);
    offset += 4;
  }
  std::string points;
  for (const pcl::PointXYZI& point : cloud)
    for (const float number : {point.x, point.y, point.z, point.intensity}) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &number, sizeof(bits));
      points += littleEndian(bits, 4);
    }
  bytes += '\0' + littleEndian(16, 4) + littleEndian(points.size(), 4) + sized(points) +
           '\1';
  return {bytes.begin(), bytes.end()};
}

Ros1Bag
bagOf(const std::vector<pcl::PointCloud<pcl::PointXYZI>>& clouds,
      const std::string& compression = "none")
{
  Ros1Bag bag(compression);
  for (const std::uint32_t publisher : {0u, 1u})
    bag.addConnection(publisher,
                      "/points",
                      "sensor_msgs/PointCloud2",
                      "Header header",
                      "/node_" + std::to_string(publisher));
  bag.addConnection(2, "/note", "std_msgs/String", "string data");
  for (std::uint32_t i = 0; i < clouds.size(); ++i) {
    bag.addMessage(i % 2, (100 + i) * second + 7, cloudMessage(clouds[i], 90 + i));
    bag.addMessage(2, (100 + i) * second + 500, {1, 0, 0, 0, 'a'});
    if (i % 2 == 1)
      bag.endChunk();
  }
  return bag;
}

} // namespace

class ProgramRos1Bags : public ProgramTest {
protected:
  void
  expectNotes(const std::string& path, std::size_t count)
  {
    recording::BagReader reader;
    ASSERT_TRUE(reader.open(path).ok());
    EXPECT_EQ(reader.profile(), "");
    std::size_t notes = 0;
    for (const recording::BagEntry& entry : reader.index()) {
      const recording::McapChannel& channel = reader.channels()[entry.channel];
      if (channel.topic != "/note")
        continue;
      EXPECT_EQ(channel.message_encoding, "ros1");
      EXPECT_EQ(channel.schema.name, "std_msgs/String");
      EXPECT_EQ(channel.schema.encoding, "ros1msg");
      EXPECT_EQ(channel.schema.text, "string data");
      EXPECT_EQ(channel.metadata.at("callerid"), "/node");
      recording::McapMessage message;
      ASSERT_TRUE(reader.read(entry, message).ok());
      EXPECT_EQ(message.bytes, (Bytes{1, 0, 0, 0, 'a'}));
      EXPECT_EQ(message.log_time,
                std::chrono::seconds(100 + notes) + recording::Time(500));
      ++notes;
    }
    EXPECT_EQ(notes, count);
  }
};

TEST_F(ProgramRos1Bags, CloudsBecomeAStreamAndOtherMessagesKeepTheirEncoding)
{
  const auto clouds = roomClouds(4);
  writeClouds("room", clouds);
  expectRun("encode room -o room.pcxi -r 0.05 --no-header");
  const std::vector<DecodedStream> of_files = decode(folder / "room.pcxi");
  writeBytes(folder / "x.bag", bagOf(clouds, "lz4").bytes());
  expectRemark(
      "encode x.bag -o x.mcap -r 0.05 --no-header",
      "'x.bag' is of ROS 1; bags are written as MCAP, with other topics as they "
      "are, which ROS 2 does not play");
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_EQ(streams[0].name, "/points/pcl_ext");
  ASSERT_EQ(streams[0].frames.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) { // besides, frames of bags have a layout
    EXPECT_EQ(streams[0].voxels[i].keys, of_files[0].voxels[i].keys);
    EXPECT_EQ(streams[0].voxels[i].intensities, of_files[0].voxels[i].intensities);
    EXPECT_EQ(streams[0].frames[i].time,
              std::chrono::seconds(100 + i) + recording::Time(7));
    EXPECT_EQ(streams[0].frames[i].stamp, std::chrono::milliseconds(90'250 + 1000 * i));
    EXPECT_EQ(streams[0].frames[i].frame_id, "lidar");
  }
  expectNotes(folder / "x.mcap", 4);
  // In parts, each read from the bag by a job of its own.
  EXPECT_EQ(run("encode x.bag -o jobs.mcap -r 0.05 --no-header --jobs 2").status, 0);
  EXPECT_EQ(bytesOf(folder / "jobs.mcap"), bytesOf(folder / "x.mcap"));
  expectFailure("info x.bag", 1, "it has clouds on /points");
  // Messages that somebody has copied into an MCAP file, and through a pipe.
  std::vector<recording::McapMessage> messages(2);
  for (std::uint32_t i = 0; i < 2; ++i) {
    messages[i].log_time = std::chrono::seconds(100 + i);
    messages[i].bytes = cloudMessage(clouds[i], 90 + i);
  }
  const recording::McapChannel channel = {
      "/points", "ros1", {"sensor_msgs/PointCloud2", "ros1msg", "Header header\n"}, {}};
  writeMcap(folder / "copied.mcap", {channel}, messages, "ros1");
  for (const std::string command :
       {"$P encode copied.mcap", "cat copied.mcap | $P encode -"}) {
    const ProgramRun encoded =
        runShell(command + " -o y.mcap -r 0.05 --no-header --overwrite");
    EXPECT_EQ(encoded.status, 0) << encoded.errors;
    const DecodedStream copied = decode(folder / "y.mcap").at(0);
    ASSERT_EQ(copied.frames.size(), 2u);
    EXPECT_EQ(copied.voxels[1].keys, of_files[0].voxels[1].keys);
    EXPECT_EQ(copied.voxels[1].intensities, of_files[0].voxels[1].intensities);
    EXPECT_EQ(copied.frames[1].stamp, std::chrono::milliseconds(91'250));
    EXPECT_EQ(copied.frames[1].frame_id, "lidar");
  }
}

TEST_F(ProgramRos1Bags, OfTheCompressorAreRecordings)
{
  // Its frames, and what they are decoded to, from a recording.
  writeClouds("room", roomClouds(4));
  expectRun("encode room -o room.pcxi -r 0.05 --i-frame-rate 3");
  const std::vector<DecodedStream> of_file = decode(folder / "room.pcxi");
  recording::RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "room.pcxi").ok());
  Ros1Bag bag("lz4");
  bag.addConnection(0, "/points/pcl_ext", "pcl_ext_ros1/CompressedPointCloud2");
  bag.addConnection(1, "/note", "std_msgs/String", "string data");
  recording::RecordedFrame frame;
  for (std::uint32_t i = 0; reader.next(frame).ok(); ++i) {
    const std::string message =
        littleEndian(i, 4) + littleEndian(1'700'000'000 + i, 4) + littleEndian(250, 4) +
        sized("lidar") + littleEndian(1, 4) + littleEndian(7, 4) + littleEndian(1, 4) +
        sized("x") + littleEndian(0, 4) + '\7' + littleEndian(1, 4) + '\0' +
        littleEndian(4, 4) + littleEndian(28, 4) +
        sized({frame.bytes.begin(), frame.bytes.end()}) + '\1' +
        sized("pcl_ext/version1");
    bag.addMessage(0, (100 + i) * second + 7, {message.begin(), message.end()});
    bag.addMessage(1, (100 + i) * second + 500, {1, 0, 0, 0, 'a'});
  }
  bag.endChunk();
  writeBytes(folder / "x.bag", bag.bytes());
  expectRun("cut x.bag -o cut.mcap");
  for (const char* const name : {"x.bag", "cut.mcap"}) {
    const std::vector<DecodedStream> streams = decode(folder / name);
    ASSERT_EQ(streams.size(), 1u);
    EXPECT_EQ(streams[0].name, "/points/pcl_ext");
    ASSERT_EQ(streams[0].frames.size(), 4u);
    expectSameFrames(of_file[0], 0, streams[0]);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(streams[0].frames[i].time,
                std::chrono::seconds(100 + i) + recording::Time(7));
      EXPECT_EQ(streams[0].frames[i].stamp,
                std::chrono::seconds(1'700'000'000 + i) + recording::Time(250));
      EXPECT_EQ(streams[0].frames[i].frame_id, "lidar");
    }
  }
  writeText(folder / "page.html", view_page);
  expectFailure(
      "view x.bag --no-browser --page page.html", 1, "copy it with 'pcl_ext cut x.bag");
  expectRun("info x.bag");
  expectRun("verify x.bag");
  expectRun("decode x.bag -o clouds.mcap");
  for (const char* const name : {"cut.mcap", "clouds.mcap"})
    expectNotes(folder / name, 4);
  recording::BagReader clouds;
  ASSERT_TRUE(clouds.open(folder / "clouds.mcap", recording::isPointCloud).ok());
  EXPECT_EQ(clouds.index().size(), 4u);
}

TEST_F(ProgramRos1Bags, ThatARecorderLeftAreReadAlsoFromTheirFolder)
{
  const auto clouds = roomClouds(5);
  std::filesystem::create_directories(folder / "left");
  writeBytes(folder / "left/x.bag.active", bagOf(clouds, "lz4").unfinishedBytes());
  for (const std::string input : {"left/x.bag.active", "left"}) {
    expectFailure("encode " + input + " -q -o x.mcap -r 0.05 --overwrite",
                  1,
                  "' did not complete it; all that is in it was read");
    EXPECT_EQ(decode(folder / "x.mcap").at(0).frames.size(), 5u);
    expectNotes(folder / "x.mcap", 5);
  }
  // One that ends before its first topic is not said to have none.
  const Bytes bytes = bagOf(roomClouds(2)).bytes();
  writeBytes(folder / "cut.bag", {bytes.begin(), bytes.begin() + 4200});
  expectFailure("encode cut.bag -o y.mcap", 1, "no topic of 'cut.bag' can be read; ");
}

TEST_F(ProgramRos1Bags, MessageThatIsCutOffIsReportedAndTheOthersGoOn)
{
  const auto clouds = roomClouds(3);
  Ros1Bag bag;
  bag.addConnection(0, "/points", "sensor_msgs/PointCloud2");
  for (std::uint32_t i = 0; i < 3; ++i) {
    Bytes message = cloudMessage(clouds[i], i + 1);
    if (i == 1)
      message.resize(message.size() / 2);
    bag.addMessage(0, (1 + i) * second, message);
  }
  bag.endChunk();
  writeBytes(folder / "x.bag", bag.bytes());
  expectFailure("encode x.bag -o x.mcap",
                1,
                "pcl_ext encode: /points, frame 1: the bytes are not a message of "
                "sensor_msgs/msg/PointCloud2");
  EXPECT_EQ(decode(folder / "x.mcap")[0].frames.size(), 2u);
  writeBytes(folder / "cut.bag", {'#', 'R', 'O', 'S', 'B', 'A', 'G', ' ', 'V', '2'});
  expectFailure("encode cut.bag -o y.mcap", 1, "'cut.bag' is no bag of ROS 1's format");
}

TEST_F(ProgramRos1Bags, TimesAfter2038KeepTheirBits)
{
  Ros1Bag bag;
  bag.addConnection(0, "/points", "sensor_msgs/PointCloud2", "Header header", "/node");
  constexpr std::uint32_t seconds = 3'000'000'000;
  bag.addMessage(0, 100 * second, cloudMessage(roomClouds(1)[0], seconds));
  bag.endChunk();
  writeBytes(folder / "x.bag", bag.bytes());
  expectRemark("encode x.bag -o x.mcap -r 0.05",
               "/points, frame 0: its time is after 2038");
  expectRun("decode x.mcap -o y.mcap");
  const auto clouds = cloudsOf(folder / "y.mcap");
  ASSERT_EQ(clouds.size(), 1u);
  EXPECT_EQ(clouds[0].stamp,
            std::chrono::seconds(static_cast<std::int32_t>(seconds)) +
                std::chrono::milliseconds(250));
}

} // namespace pcl_ext::tools::test

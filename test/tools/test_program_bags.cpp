// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"
#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>

namespace pcl_ext::tools::test {

namespace {

using recording::BagEntry;
using recording::McapChannel;
using recording::McapMessage;
using recording::Time;

struct Bag {
  std::string profile;
  std::map<std::string, McapChannel> channels;
  std::map<std::string, std::vector<McapMessage>> messages; // by topic
  std::vector<recording::McapMetadata> metadata;
  std::vector<recording::McapAttachment> attachments;
};

Bag
readBag(const std::string& path)
{
  recording::BagReader reader;
  const recording::RecordingStatus status = reader.open(path);
  EXPECT_TRUE(status.ok()) << status;
  Bag bag;
  bag.profile = reader.profile();
  for (const McapChannel& channel : reader.channels())
    bag.channels[channel.topic] = channel;
  for (const BagEntry& entry : reader.index()) {
    McapMessage message;
    EXPECT_TRUE(reader.read(entry, message).ok());
    bag.messages[reader.channels()[message.channel].topic].push_back(message);
  }
  EXPECT_TRUE(reader.readMetadata(bag.metadata).ok());
  EXPECT_TRUE(reader
                  .readAttachments([&bag](const auto& attachment) {
                    bag.attachments.push_back(attachment);
                    return recording::RecordingStatus();
                  })
                  .ok());
  return bag;
}

void
expectSameMessages(const std::vector<McapMessage>& first,
                   const std::vector<McapMessage>& second)
{
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].bytes, second[i].bytes) << "message " << i;
    EXPECT_EQ(first[i].log_time, second[i].log_time);
    EXPECT_EQ(first[i].publish_time, second[i].publish_time);
    EXPECT_EQ(first[i].sequence, second[i].sequence);
  }
}

void
expectSameRest(const Bag& first, const Bag& second)
{
  EXPECT_EQ(first.profile, second.profile);
  ASSERT_EQ(second.channels.count("/imu"), 1u);
  const McapChannel& channel = second.channels.at("/imu");
  EXPECT_EQ(channel.message_encoding, "cdr");
  EXPECT_EQ(channel.schema.name, "sensor_msgs/msg/Imu");
  EXPECT_EQ(channel.schema.encoding, "ros2msg");
  EXPECT_EQ(channel.schema.text, "float64 x");
  EXPECT_EQ(channel.metadata, imuChannel().metadata);
  expectSameMessages(first.messages.at("/imu"), second.messages.at("/imu"));
  ASSERT_EQ(second.metadata.size(), 1u);
  EXPECT_EQ(second.metadata[0].name, "robot");
  EXPECT_EQ(second.metadata[0].values, first.metadata[0].values);
  ASSERT_EQ(second.attachments.size(), 1u);
  EXPECT_EQ(second.attachments[0].name, "notes.txt");
  EXPECT_EQ(second.attachments[0].media_type, "text/plain");
  EXPECT_EQ(second.attachments[0].create_time, Time(3));
  EXPECT_EQ(second.attachments[0].bytes, first.attachments[0].bytes);
}

recording::PointCloudMessage
cloudOf(const McapMessage& message, bool is_compressed)
{
  recording::PointCloudMessage cloud;
  EXPECT_TRUE(recording::readPointCloud(
                  message.bytes.data(), message.bytes.size(), is_compressed, cloud)
                  .ok());
  return cloud;
}

/** \brief Adds a message of another topic. */
void
addMessage(std::vector<McapMessage>& messages, std::size_t channel, Time time)
{
  McapMessage& message = messages.emplace_back();
  message.channel = channel;
  message.sequence = static_cast<std::uint32_t>(messages.size());
  message.log_time = message.publish_time = time;
  message.bytes.assign(3, static_cast<std::uint8_t>(messages.size()));
}

} // namespace

using ProgramBags = ProgramTest;

TEST_F(ProgramBags, CloudsAreReplacedAndComeBackAndAllElsePassesThrough)
{
  writeBag(folder / "bag.mcap", 5);
  expectRun("encode bag.mcap -o small.mcap -r 0.05");
  expectRun("decode small.mcap -o again.mcap");
  const Bag before = readBag(folder / "bag.mcap");
  const Bag small = readBag(folder / "small.mcap");
  const Bag again = readBag(folder / "again.mcap");
  for (const Bag* const after : {&small, &again}) {
    expectSameRest(before, *after);
    EXPECT_EQ(after->channels.size(), 3u);
  }
  using Metadata = std::map<std::string, std::string>;
  EXPECT_EQ(small.channels.at("/front/points/pcl_ext").metadata,
            (Metadata{{"intensity_law", "native"},
                      {"offered_qos_profiles", "- durability: 1"}}));
  EXPECT_EQ(again.channels.at("/front/points").metadata,
            (Metadata{{"offered_qos_profiles", "- durability: 1"}}));
  EXPECT_EQ(again.channels.at("/rear/points").metadata, Metadata());
  const std::vector<DecodedStream> streams = decode(folder / "small.mcap");
  ASSERT_EQ(streams.size(), 2u);
  for (const DecodedStream& stream : streams) {
    const std::string topic = stream.name.substr(0, stream.name.rfind("/pcl_ext"));
    SCOPED_TRACE(topic);
    EXPECT_TRUE(recording::isCompressedPointCloud(small.channels.at(stream.name)));
    EXPECT_TRUE(recording::isPointCloud(again.channels.at(topic)));
    for (const bool is_compressed : {true, false}) {
      const auto& messages =
          is_compressed ? small.messages.at(stream.name) : again.messages.at(topic);
      ASSERT_EQ(messages.size(), 5u);
      for (std::size_t i = 0; i < 5; ++i) {
        const McapMessage& original = before.messages.at(topic)[i];
        EXPECT_EQ(messages[i].log_time, original.log_time);
        EXPECT_EQ(messages[i].publish_time, original.publish_time);
        EXPECT_EQ(messages[i].sequence, original.sequence);
        const auto cloud = cloudOf(messages[i], is_compressed);
        EXPECT_EQ(cloud.stamp, stampOf(i));
        EXPECT_EQ(cloud.frame_id, "lidar");
        if (is_compressed) {
          EXPECT_EQ(cloud.width, cloudOf(original, false).width);
          EXPECT_EQ(cloud.format, "pcl_ext");
          EXPECT_LT(messages[i].bytes.size(), original.bytes.size() / 4);
        }
        else {
          EXPECT_EQ(cloud.width, stream.voxels[i].size());
          ASSERT_EQ(cloud.fields.size(), 4u);
          EXPECT_EQ(cloud.fields[3].name, "intensity");
        }
      }
    }
  }
  const auto json = nlohmann::json::parse(expectRun("info small.mcap --json").output);
  ASSERT_EQ(json["other_topics"].size(), 1u);
  EXPECT_EQ(json["other_topics"][0]["topic"], "/imu");
  EXPECT_EQ(json["other_topics"][0]["type"], "sensor_msgs/msg/Imu");
  EXPECT_TRUE(hasPart(expectRun("info small.mcap").output,
                      "other topics: /imu (sensor_msgs/msg/Imu)\n"));
}

TEST_F(ProgramBags, FoldersOfRosbag2AreReadAndWritten)
{
  writeBag(folder / "bag", 3);
  expectRun("encode bag -o small -r 0.05");
  EXPECT_TRUE(std::filesystem::exists(folder / "small/metadata.yaml"));
  expectRun("decode small -o again --bag");
  expectSameRest(readBag(folder / "bag"), readBag(folder / "again"));
  expectFailure("encode bag -o small", 2, "exists");
}

TEST_F(ProgramBags, ChosenTopicsAreEncodedAndOthersStayAsTheyAre)
{
  writeBag(folder / "bag.mcap", 3);
  expectRun("encode bag.mcap -o one.mcap --topics /rear/points");
  const Bag before = readBag(folder / "bag.mcap");
  const Bag after = readBag(folder / "one.mcap");
  expectSameRest(before, after);
  ASSERT_EQ(after.messages.count("/front/points"), 1u);
  expectSameMessages(before.messages.at("/front/points"),
                     after.messages.at("/front/points"));
  EXPECT_EQ(after.messages.count("/rear/points"), 0u);
  EXPECT_EQ(after.messages.count("/rear/points/pcl_ext"), 1u);
  EXPECT_EQ(run("encode --topics /rear/points bag.mcap -o x.pcxi -q").errors, "");
  expectSameFrames(decode(folder / "one.mcap")[0], 0, decode(folder / "x.pcxi")[0]);
}

TEST_F(ProgramBags, FramesDoNotGetTheTopicOfOtherMessages)
{
  const McapChannel topics[] = {
      recording::pointCloudChannel("/points"),
      recording::compressedPointCloudChannel("/points/pcl_ext")};
  recording::McapWriter writer;
  ASSERT_TRUE(writer.open(folder / "bag.mcap", "ros2").ok());
  McapMessage message = cloudMessage(roomClouds(1)[0], 0);
  for (const McapChannel& topic : topics) {
    ASSERT_TRUE(
        writer.addChannel(topic, recording::McapChunking::Shared, message.channel)
            .ok());
    for (std::size_t i = 0; i < 2; ++i)
      ASSERT_TRUE(writer.write(message).ok());
    ASSERT_TRUE(writer.flush().ok());
    message.bytes = {1, 2, 3};
  }
  ASSERT_TRUE(writer.finish().ok());
  expectRemark("encode bag.mcap -o x.mcap",
               "/points: its frames are under /points/encoded/pcl_ext, as "
               "/points/pcl_ext is another topic of the bag");
  const Bag after = readBag(folder / "x.mcap");
  expectSameMessages(readBag(folder / "bag.mcap").messages.at("/points/pcl_ext"),
                     after.messages.at("/points/pcl_ext"));
  EXPECT_EQ(after.messages.at("/points/encoded/pcl_ext").size(), 2u);
  // From a pipe the name is given before the other topic is met.
  const ProgramRun piped = runShell("cat bag.mcap | \"$P\" encode - -o y.mcap");
  EXPECT_EQ(piped.status, 1);
  EXPECT_TRUE(hasPart(piped.errors, "/points/pcl_ext: its messages are left out"));
  EXPECT_EQ(readBag(folder / "y.mcap").messages.at("/points/pcl_ext").size(), 2u);
  EXPECT_EQ(decode(folder / "y.mcap")[0].frames.size(), 2u);
}

TEST_F(ProgramBags, MessagesThatAFileOfFramesCannotHaveAreToldOf)
{
  writeBag(folder / "bag.mcap", 3);
  const std::string times = "left out: the log times, which are not the stamps of the "
                            "clouds, as a file of frames has one stream and stamps";
  EXPECT_TRUE(
      hasPart(run("encode bag.mcap -o x.pcxi --topics /rear/points").errors, times));
  expectRun("encode bag.mcap -o one.mcap --topics /rear/points");
  for (const std::string command : {"cut", "merge"})
    for (const std::string& output : {std::string("-"), command + ".pcxi"})
      EXPECT_EQ(
          runShell("\"$P\" " + command + " one.mcap -o " + output +
                   " 2>&1 > x | "
                   "grep -c 'left out: 6 messages of other topics, and the log times'")
              .output,
          "1\n")
          << command << output;
}

TEST_F(ProgramBags, CloudsOfAnotherCoordinateFrameAreTold)
{
  const auto clouds = roomClouds(3);
  std::vector<McapMessage> messages;
  for (std::size_t i = 0; i < clouds.size(); ++i)
    messages.push_back(cloudMessage(clouds[i], i, i < 2 ? "lidar" : "map"));
  writeMcap(folder / "bag.mcap", {recording::pointCloudChannel("/points")}, messages);
  expectRemark("encode bag.mcap -o x.mcap",
               "/points, frame 2: its frame_id is 'map', that of the "
               "clouds before 'lidar'",
               1);
  // The user may name the frame of all.
  EXPECT_EQ(run("encode bag.mcap -o y.mcap --frame-id map").status, 0);
}

TEST_F(ProgramBags, AFrameIdThatIsTooLongForFramesNamesWhatHelps)
{
  writeMcap(folder / "bag.mcap",
            {recording::pointCloudChannel("/points")},
            {cloudMessage(roomClouds(1)[0], 0, std::string(1025, 'f'))});
  expectFailure("encode bag.mcap -o x.mcap",
                2,
                "the frame_id of its clouds has 1025 bytes, and frames carry 1024 at "
                "most: name a shorter one with --frame-id, or encode with --no-header");
  expectRun("encode bag.mcap -o x.mcap --frame-id short");
  expectRun("encode bag.mcap -o y.mcap --no-header");
}

TEST_F(ProgramBags, WithoutMessagesOfACloudLeaveNoFile)
{
  McapMessage imu;
  imu.channel = 1;
  writeMcap(folder / "bag.mcap",
            {recording::pointCloudChannel("/points"), imuChannel()},
            {imu});
  for (const char* const input : {"bag.mcap", "- < bag.mcap"})
    expectFailure(std::string("encode -o x.mcap ") + input,
                  1,
                  "no cloud could be encoded: there are no messages of /points; "
                  "'x.mcap' was not written\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "x.mcap.unfinished"));
}

TEST_F(ProgramBags, AdjacentPartsHaveEachOtherMessage)
{
  const auto clouds = roomClouds(9);
  std::vector<McapMessage> messages;
  addMessage(messages, 1, logTime(0) - Time(500'000'000)); // as /tf_static is
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    messages.push_back(cloudMessage(clouds[i], i));
    addMessage(messages, 1, logTime(i));
    addMessage(messages, 1, logTime(i) + Time(50'000'000));
  }
  addMessage(messages, 1, logTime(20));
  messages.push_back(messages.back()); // a second one that is the same
  writeMcap(folder / "bag.mcap",
            {recording::pointCloudChannel("/points"), imuChannel()},
            messages);
  expectRun("encode bag.mcap -o all.mcap --i-frame-rate 3");
  const Bag all = readBag(folder / "all.mcap");
  const std::vector<McapMessage>& imu = all.messages.at("/imu");
  const std::vector<McapMessage>& frames = all.messages.at("/points/pcl_ext");
  ASSERT_EQ(imu.size(), 21u);
  const std::string divisions[][3] = {
      {"--frames :3", "--frames 3:6", "--frames 6:9"},
      {"--from 0 --to 0.3", "--from 0.3 --to 0.62", "--from 0.62 --to 9"}};
  for (const auto& parts : divisions) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string path = std::to_string(i) + ".mcap";
      EXPECT_EQ(run("cut all.mcap --overwrite -q -o " + path + ' ' + parts[i]).status,
                0);
      count += readBag(folder / path).messages.at("/imu").size();
    }
    EXPECT_EQ(count, imu.size()) << parts[0];
    expectSameMessages(
        {frames.begin() + 3, frames.begin() + (&parts == divisions ? 6 : 7)},
        readBag(folder / "1.mcap").messages.at("/points/pcl_ext"));
    expectSameMessages({imu.begin(), imu.begin() + 7},
                       readBag(folder / "0.mcap").messages.at("/imu"));
    EXPECT_EQ(run("merge 2.mcap 0.mcap 1.mcap -q -o joined.mcap --overwrite").status,
              0);
    expectSameMessages(imu, readBag(folder / "joined.mcap").messages.at("/imu"));
  }
  expectRun("cut all.mcap -o whole.mcap --frames 0:9");
  expectSameMessages(imu, readBag(folder / "whole.mcap").messages.at("/imu"));
  expectRun("decode all.mcap -o decoded.mcap --frames 0:9");
  expectSameMessages(imu, readBag(folder / "decoded.mcap").messages.at("/imu"));
}

TEST_F(ProgramBags, PartsHaveTheLatchedMessagesOfTheirBeginning)
{
  McapChannel static_channel = imuChannel();
  static_channel.topic = "/tf_static";
  McapChannel map = imuChannel(); // of two publishers
  map.topic = "/map";
  map.metadata = {{"offered_qos_profiles",
                   "- depth: 1\n  durability: 1\n- depth: 1\n  durability: 2\n"
                   "- depth: 1\n  durability: transient_local\n"}};
  std::vector<McapMessage> messages;
  const Time shortly(1'000'000);
  for (int i = 0; i < 2; ++i) // of two nodes
    addMessage(messages, 2, logTime(0) - shortly);
  const auto clouds = roomClouds(6);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    messages.push_back(cloudMessage(clouds[i], i));
    addMessage(messages, 1, logTime(i) + shortly);
    if (i != 3)
      addMessage(messages, 3, logTime(i) + shortly);
  }
  writeMcap(
      folder / "bag.mcap",
      {recording::pointCloudChannel("/points"), imuChannel(), static_channel, map},
      messages);
  expectRun("encode bag.mcap -o all.mcap");
  const Bag all = readBag(folder / "all.mcap");
  const auto at = [&all](const std::string& topic, std::vector<std::size_t> numbers) {
    std::vector<McapMessage> chosen;
    for (const std::size_t number : numbers)
      chosen.push_back(all.messages.at(topic)[number]);
    for (McapMessage& message : chosen)
      message.log_time = std::max(message.log_time, logTime(4));
    return chosen;
  };
  for (const std::string command : {"cut all.mcap -o part.mcap --from 0.4",
                                    "decode all.mcap -o part.mcap --frames 4:",
                                    "encode bag.mcap -o part.mcap --frames 4:",
                                    "encode bag.mcap -o part.mcap --frames 4: --jobs 2",
                                    "encode - -o part.mcap --frames 4: < bag.mcap"}) {
    SCOPED_TRACE(command);
    runShell("\"$P\" " + command + " --overwrite -q");
    const Bag part = readBag(folder / "part.mcap");
    expectSameMessages(at("/tf_static", {0, 1}), part.messages.at("/tf_static"));
    expectSameMessages(at("/imu", {4, 5}), part.messages.at("/imu"));
    EXPECT_EQ(part.messages.at("/map").size(), 4u);
    EXPECT_EQ(part.messages.at("/map")[0].bytes, all.messages.at("/map")[1].bytes);
  }
  // Parts that become one again.
  expectRun("cut all.mcap -o 0.mcap --frames :2 -q");
  expectRun("cut all.mcap -o 1.mcap --frames 2:4 -q");
  expectRun("cut all.mcap -o 2.mcap --frames 4: -q");
  EXPECT_EQ(run("merge 2.mcap 0.mcap 1.mcap -q -o joined.mcap").status, 0);
  const Bag joined = readBag(folder / "joined.mcap");
  for (const std::string topic : {"/tf_static", "/map", "/imu"})
    expectSameMessages(all.messages.at(topic), joined.messages.at(topic));
}

TEST_F(ProgramBags, OtherMessagesThatTwoPartsHaveAreCopiedOnce)
{
  writeBag(folder / "bag.mcap", 10);
  expectRun("encode bag.mcap -o all.mcap --i-frame-rate 2");
  expectRun("cut all.mcap -o a.mcap --frames :6");
  expectRun("cut all.mcap -o b.mcap --frames 4:");
  const ProgramRun merged = expectRemark(
      "merge a.mcap b.mcap -o joined.mcap",
      "pcl_ext merge: the recordings have 2 other messages in common, copied "
      "once\n");
  EXPECT_TRUE(hasPart(merged.output, ", 10 other messages"));
  const Bag all = readBag(folder / "all.mcap");
  const Bag joined = readBag(folder / "joined.mcap");
  const Bag part = readBag(folder / "a.mcap");
  EXPECT_EQ(part.metadata.size(), 1u);
  EXPECT_EQ(part.attachments.size(), 1u);
  for (const std::string topic : {"/imu", "/front/points/pcl_ext"})
    expectSameMessages(all.messages.at(topic), joined.messages.at(topic));
}

} // namespace pcl_ext::tools::test

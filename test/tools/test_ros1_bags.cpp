// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap_reader.h"
#include "recording/point_cloud_messages.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <ros/serialization.h>
#include <rosbag/bag.h>

#include <cstring>

namespace {

/** \brief A message whose bytes are written as they are. */
struct RawMessage {
  std::string type;
  std::string definition;
  std::vector<std::uint8_t> bytes;
};

} // namespace

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<RawMessage> {
  static const char*
  value()
  {
    return "*";
  }
  static const char*
  value(const RawMessage& /* message */)
  {
    return "0123456789abcdef0123456789abcdef";
  }
};

template <>
struct DataType<RawMessage> {
  static const char*
  value(const RawMessage& message)
  {
    return message.type.c_str();
  }
};

template <>
struct Definition<RawMessage> {
  static const char*
  value(const RawMessage& message)
  {
    return message.definition.c_str();
  }
};

} // namespace message_traits

namespace serialization {

template <>
struct Serializer<RawMessage> {
  template <typename StreamT>
  static void
  write(StreamT& stream, const RawMessage& message)
  {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(message.bytes.size())),
                message.bytes.data(),
                message.bytes.size());
  }
  static std::uint32_t
  serializedLength(const RawMessage& message)
  {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};

} // namespace serialization
} // namespace ros

namespace pcl_ext {
namespace tools {
namespace test {

namespace {

/** \brief Bytes of a message of ROS 1. */
class Ros1Writer {
public:
  Ros1Writer&
  number(std::uint32_t number)
  {
    for (int i = 0; i < 4; ++i)
      bytes_.push_back(static_cast<std::uint8_t>(number >> 8 * i));
    return *this;
  }

  Ros1Writer&
  byte(std::uint8_t byte)
  {
    bytes_.push_back(byte);
    return *this;
  }

  Ros1Writer&
  text(const std::string& text)
  {
    number(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }

  Ros1Writer&
  real(float number)
  {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &number, sizeof(bits));
    return this->number(bits);
  }

  const Bytes&
  bytes() const
  {
    return bytes_;
  }

private:
  Bytes bytes_;
};

RawMessage
cloudMessage(const pcl::PointCloud<pcl::PointXYZI>& cloud, std::uint32_t seconds)
{
  Ros1Writer writer;
  writer.number(9).number(seconds).number(250'000'000).text("lidar");
  writer.number(1).number(static_cast<std::uint32_t>(cloud.size())).number(4);
  std::uint32_t offset = 0;
  for (const char* field : {"x", "y", "z", "intensity"}) {
    writer.text(field).number(offset).byte(7).number(1);
    offset += 4;
  }
  const auto bytes = static_cast<std::uint32_t>(16 * cloud.size());
  writer.byte(0).number(16).number(bytes).number(bytes);
  for (const pcl::PointXYZI& point : cloud)
    writer.real(point.x).real(point.y).real(point.z).real(point.intensity);
  writer.byte(1);
  return {"sensor_msgs/PointCloud2", "Header header", writer.bytes()};
}

void
writeBag(const std::string& path,
         const std::vector<pcl::PointCloud<pcl::PointXYZI>>& clouds)
{
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  for (std::uint32_t i = 0; i < clouds.size(); ++i) {
    bag.write("/points", ros::Time(100 + i, 7), cloudMessage(clouds[i], 90 + i));
    bag.write("/note",
              ros::Time(100 + i, 500),
              RawMessage{"std_msgs/String", "string data", {1, 0, 0, 0, 'a'}});
  }
}

} // namespace

using Ros1Bags = ProgramTest;

TEST_F(Ros1Bags, CloudsBecomeAStreamAndOtherMessagesKeepTheirEncoding)
{
  const auto clouds = roomClouds(4);
  writeBag(folder / "x.bag", clouds);
  expectRun("encode x.bag -o x.mcap -r 0.05 --no-header");
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_EQ(streams[0].name, "/points/pcl_ext");
  writeClouds("room", clouds);
  expectRun("encode room -o room.pcxi -r 0.05 --no-header");
  const std::vector<DecodedStream> of_files = decode(folder / "room.pcxi");
  ASSERT_EQ(streams[0].frames.size(), 4u);
  expectSameFrames(of_files[0], 0, streams[0]);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(streams[0].frames[i].time,
              std::chrono::seconds(100 + i) + recording::Time(7));
    EXPECT_EQ(streams[0].frames[i].stamp, std::chrono::milliseconds(90'250 + 1000 * i));
    EXPECT_EQ(streams[0].frames[i].frame_id, "lidar");
  }
  recording::McapReader reader;
  ASSERT_TRUE(reader.open(folder / "x.mcap").ok());
  ASSERT_EQ(reader.channels().size(), 2u);
  std::size_t notes = 0;
  for (const recording::McapEntry& entry : reader.index()) {
    const recording::McapChannel& channel = reader.channels()[entry.channel];
    if (channel.topic != "/note")
      continue;
    EXPECT_EQ(channel.message_encoding, "ros1");
    EXPECT_EQ(channel.schema.name, "std_msgs/String");
    EXPECT_EQ(channel.schema.encoding, "ros1msg");
    EXPECT_EQ(channel.schema.text, "string data");
    recording::McapMessage message;
    ASSERT_TRUE(reader.read(entry, message).ok());
    EXPECT_EQ(message.bytes, (Bytes{1, 0, 0, 0, 'a'}));
    EXPECT_EQ(message.log_time,
              std::chrono::seconds(100 + notes) + recording::Time(500));
    ++notes;
  }
  EXPECT_EQ(notes, 4u);
}

TEST_F(Ros1Bags, MessageThatIsCutOffIsReportedAndTheOthersGoOn)
{
  const auto clouds = roomClouds(3);
  {
    rosbag::Bag bag(folder / "x.bag", rosbag::bagmode::Write);
    for (std::uint32_t i = 0; i < 3; ++i) {
      RawMessage message = cloudMessage(clouds[i], i + 1);
      if (i == 1)
        message.bytes.resize(message.bytes.size() / 2);
      bag.write("/points", ros::Time(1 + i, 0), message);
    }
  }
  expectFailure("encode x.bag -o x.mcap",
                1,
                "pcl_ext encode: /points, frame 1: the message ends within its fields");
  EXPECT_EQ(decode(folder / "x.mcap")[0].frames.size(), 2u);
  writeBytes(folder / "cut.bag", {'#', 'R', 'O', 'S', 'B', 'A', 'G', ' ', 'V', '2'});
  expectFailure("encode cut.bag -o y.mcap", 1, "cannot read the bag 'cut.bag'");
}

} // namespace test
} // namespace tools
} // namespace pcl_ext

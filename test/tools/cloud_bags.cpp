// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "tools/cloud_bags.h"

#include "recording/bag_reader.h"
#include "recording/mcap_writer.h"
#include "tools/program.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace pcl_ext::tools::test {

using recording::McapChannel;
using recording::McapMessage;
using recording::Time;

Time
logTime(std::size_t i)
{
  return Time(5'000'000'000'000 + 100'000'000 * static_cast<std::int64_t>(i));
}

Time
stampOf(std::size_t i)
{
  return logTime(i) - Time(30'000'001);
}

McapChannel
imuChannel()
{
  return {"/imu", "cdr", {"sensor_msgs/msg/Imu", "ros2msg", "float64 x"}, {{"a", "b"}}};
}

McapMessage
cloudMessage(const pcl::PointCloud<pcl::PointXYZI>& points,
             std::size_t i,
             const std::string& frame_id)
{
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(points, cloud);
  recording::PointCloudMessage message;
  message.stamp = stampOf(i);
  message.frame_id = frame_id;
  message.height = cloud.height;
  message.width = cloud.width;
  for (const auto& field : cloud.fields)
    message.fields.push_back({field.name, field.offset, field.datatype, field.count});
  message.point_step = cloud.point_step;
  message.row_step = cloud.row_step;
  message.bytes = cloud.data;
  McapMessage written;
  written.sequence = static_cast<std::uint32_t>(70 + i);
  written.log_time = logTime(i);
  written.publish_time = logTime(i) - Time(7);
  recording::writePointCloud(message, false, written.bytes);
  return written;
}

std::vector<recording::PointCloudMessage>
cloudsOf(const std::string& path)
{
  recording::BagReader reader;
  EXPECT_TRUE(reader.open(path).ok());
  std::vector<recording::PointCloudMessage> clouds;
  for (const recording::BagEntry& entry : reader.index()) {
    McapMessage message;
    EXPECT_TRUE(reader.read(entry, message).ok());
    if (!isPointCloud(reader.channels()[message.channel]))
      continue;
    EXPECT_TRUE(
        recording::readPointCloud(
            message.bytes.data(), message.bytes.size(), false, clouds.emplace_back())
            .ok());
  }
  return clouds;
}

void
writeBag(const std::string& path, std::size_t frames)
{
  recording::McapWriter writer;
  ASSERT_TRUE(writer.open(path, "ros2").ok());
  McapChannel front = recording::pointCloudChannel("/front/points");
  front.metadata = {{"offered_qos_profiles", "- durability: 1"},
                    {"topic_type_hash", "RIHS01_1"}};
  std::vector<std::size_t> channels;
  for (const McapChannel& channel :
       {front, imuChannel(), recording::pointCloudChannel("/rear/points")})
    ASSERT_TRUE(writer
                    .addChannel(channel,
                                recording::McapChunking::Shared,
                                channels.emplace_back())
                    .ok());
  const auto front_clouds = roomClouds(frames, 1);
  const auto rear_clouds = roomClouds(frames, 2);
  for (std::size_t i = 0; i < frames; ++i) {
    McapMessage message = cloudMessage(front_clouds[i], i);
    message.channel = channels[0];
    ASSERT_TRUE(writer.write(message).ok());
    message = cloudMessage(rear_clouds[i], i);
    message.channel = channels[2];
    ASSERT_TRUE(writer.write(message).ok());
    message.channel = channels[1];
    message.log_time += Time(50'000'000);
    message.bytes.assign(i + 1, static_cast<std::uint8_t>(i));
    ASSERT_TRUE(writer.write(message).ok());
  }
  ASSERT_TRUE(writer.write(recording::McapMetadata{"robot", {{"serial", "17"}}}).ok());
  ASSERT_TRUE(writer
                  .write(recording::McapAttachment{
                      Time(3), Time(3), "notes.txt", "text/plain", {1, 2, 3}})
                  .ok());
  ASSERT_TRUE(writer.finish().ok());
}

void
writeUnevenBag(const std::string& path, std::size_t frames)
{
  std::vector<McapMessage> messages;
  const auto clouds = roomClouds(16, 3);
  const auto write = [&](std::size_t channel, std::size_t i, Time later) {
    McapMessage message;
    if (channel == 2)
      message.bytes.assign(i % 100 + 1, static_cast<std::uint8_t>(i));
    else {
      pcl::PointCloud<pcl::PointXYZI> cloud = clouds[i % clouds.size()];
      cloud.resize(i % 50 == 49 ? 0 : 200 + 20 * (i % 9));
      message = cloudMessage(cloud, i);
      if (i % 40 == 28 || (channel == 1 && i == 0))
        message.bytes.resize(message.bytes.size() / 2);
    }
    message.channel = channel;
    message.log_time = logTime(i) + later;
    messages.push_back(message);
  };
  for (std::size_t i = 0; i < frames; ++i) {
    write(0, i, Time(0));
    if (i % 7 == 0)
      write(1, i, Time(1));
    write(2, i, Time(2));
  }
  writeMcap(path,
            {recording::pointCloudChannel("/fast"),
             recording::pointCloudChannel("/slow"),
             imuChannel()},
            messages);
}

} // namespace pcl_ext::tools::test

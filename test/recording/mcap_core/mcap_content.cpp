// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Writes an MCAP file, or reads one, and prints its content as lines of JSON; for
 * exchange_files.mjs.
 */

#include "recording/bag_reader.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"

#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

std::string
hexOf(const Bytes& bytes)
{
  std::string text;
  char digits[3];
  for (const std::uint8_t byte : bytes) {
    std::snprintf(digits, sizeof(digits), "%02x", byte);
    text += digits;
  }
  return text;
}

/** \brief The beginning of a line about a message; names and topics have no quotes
 * here. */
void
printMessage(const McapChannel& channel, const McapMessage& message)
{
  std::cout << R"({"kind":"message","topic":")" << channel.topic << R"(","schema":")"
            << channel.schema.name << R"(","sequence":)" << message.sequence
            << R"(,"log_time":")" << message.log_time.count() << R"(","publish_time":")"
            << message.publish_time.count() << R"(","bytes":")" << hexOf(message.bytes)
            << '"';
}

void
require(const RecordingStatus& status)
{
  if (status.ok())
    return;
  std::cerr << status << '\n';
  std::exit(1);
}

void
writeFrame(std::size_t channel_number,
           const McapChannel& channel,
           const KnownFrame& frame,
           std::uint32_t sequence,
           McapWriter& writer)
{
  PointCloudMessage cloud;
  cloud.stamp = frame.time;
  cloud.frame_id = "world";
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(frame.voxels.size());
  for (const char* name : {"x", "y", "z", "intensity"})
    cloud.fields.push_back(
        {name, static_cast<std::uint32_t>(4 * cloud.fields.size()), 7, 1});
  cloud.point_step = 16;
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.bytes = frame.bytes;
  cloud.is_dense = true;
  cloud.format = "pcl_ext";
  McapMessage message;
  message.channel = channel_number;
  message.sequence = sequence;
  message.log_time = message.publish_time = frame.time;
  writePointCloud(cloud, true, message.bytes);
  require(writer.write(message, sequence % 10 == 0));
  printMessage(channel, message);
  std::cout << R"(,"cloud":{"width":)" << cloud.width << R"(,"frame":")"
            << hexOf(cloud.bytes) << "\"}}\n";
}

void
write(const std::string& path)
{
  McapWriter writer;
  require(writer.open(path, "ros2"));
  std::vector<McapChannel> channels;
  std::vector<std::size_t> numbers(3);
  for (std::size_t i = 0; i < 2; ++i) {
    channels.push_back(compressedPointCloudChannel("/sensor_" + std::to_string(i)));
    require(writer.addChannel(channels[i], McapChunking::OwnStream, numbers[i]));
  }
  McapChannel text;
  text.topic = "/text";
  text.message_encoding = "json";
  channels.push_back(text);
  require(writer.addChannel(text, McapChunking::Shared, numbers[2]));
  require(writer.write(McapMetadata{"calibration", {{"board", "7x5"}, {"note", ""}}}));
  const std::string pose = "1 2 3";
  require(writer.write(McapAttachment{
      Time(7), Time(8), "pose.txt", "text/plain", {pose.begin(), pose.end()}}));
  const KnownStream streams[] = {knownStream(0, 40, 10, 40), knownStream(1, 30, 10)};
  McapMessage message;
  for (std::uint32_t i = 0; i < 40; ++i) {
    for (std::size_t stream = 0; stream < 2; ++stream)
      if (i < streams[stream].frames.size())
        writeFrame(
            numbers[stream], channels[stream], streams[stream].frames[i], i, writer);
    message.channel = numbers[2];
    message.sequence = i;
    message.log_time = streams[0].frames[i].time + Time(10);
    message.publish_time = streams[0].frames[i].time;
    const std::string words = "\"" + std::string(100, 'a') + std::to_string(i) + "\"";
    message.bytes.assign(words.begin(), words.end());
    require(writer.write(message));
    printMessage(text, message);
    std::cout << "}\n";
  }
  require(writer.finish());
}

void
printCloud(const PointCloudMessage& cloud)
{
  std::cout << R"(,"cloud":{"stamp":")" << cloud.stamp.count() << R"(","frame_id":")"
            << cloud.frame_id << R"(","width":)" << cloud.width << R"(,"fields":")";
  const char* separator = "";
  for (const PointFieldMessage& field : cloud.fields) {
    std::cout << separator << field.name << ':' << field.offset << ':'
              << int{field.datatype} << ':' << field.count;
    separator = " ";
  }
  std::cout << R"(","is_dense":)" << (cloud.is_dense ? "true" : "false")
            << R"(,"points":")" << hexOf(cloud.bytes) << "\"}";
}

void
read(const std::string& path)
{
  BagReader reader;
  require(reader.open(path));
  McapMessage message;
  PointCloudMessage cloud;
  for (const BagEntry& entry : reader.index()) {
    require(reader.read(entry, message));
    const McapChannel& channel = reader.channels()[message.channel];
    printMessage(channel, message);
    if (isPointCloud(channel)) {
      require(readPointCloud(message.bytes.data(), message.bytes.size(), false, cloud));
      printCloud(cloud);
    }
    std::cout << "}\n";
  }
  std::vector<McapMetadata> metadata;
  require(reader.readMetadata(metadata));
  for (const McapMetadata& record : metadata) {
    std::cout << R"({"kind":"metadata","name":")" << record.name << R"(","values":{)";
    for (const auto& [key, value] : record.values)
      std::cout << '"' << key << R"(":")" << value << '"';
    std::cout << "}}\n";
  }
  require(reader.readAttachments([](const McapAttachment& attachment) {
    std::cout << R"({"kind":"attachment","name":")" << attachment.name
              << R"(","log_time":")" << attachment.log_time.count()
              << R"(","create_time":")" << attachment.create_time.count()
              << R"(","bytes":")" << hexOf(attachment.bytes) << "\"}\n";
    return RecordingStatus();
  }));
  for (const RecordingDamage& damage : reader.damage())
    std::cout << R"({"kind":"damage","message":")" << damage.message << "\"}\n";
}

} // namespace

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

int
main(int argc, char** argv)
{
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 2 && arguments[0] == "write")
    pcl_ext::recording::test::write(arguments[1]);
  else if (arguments.size() == 2 && arguments[0] == "read")
    pcl_ext::recording::test::read(arguments[1]);
  else
    return 2;
  return 0;
}

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Writes inputs for the fuzz targets to begin with, a folder for each target.
 *
 *     write_seeds TEST_DATA FOLDER
 *
 * Targets that read streams get the golden and the invalid ones of TEST_DATA, cut into
 * parts that targets can hold, and short streams of all kinds. Of what other targets
 * read, a few inputs are made that get far into them.
 */

#include "frame_row.h"
#include "recording/mcap/chunk_compression.h"
#include "recording/mcap_writer.h"
#include "recording/point_cloud_messages.h"
#ifdef PCL_EXT_HAS_SQLITE
#include <sqlite3.h>
#endif
#include "small_streams.h"
#include "support/ros1_bags.h"
#include "support/scan_frames.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::fuzz;
using pcl_ext::io::test::append;

class SeedWriter {
public:
  explicit SeedWriter(const std::filesystem::path& folder) : folder_(folder) {}

  void
  write(const std::string& target, const std::string& name, const Bytes& bytes)
  {
    std::filesystem::create_directories(folder_ / target);
    std::ofstream file(folder_ / target / name, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    is_good_ = is_good_ && file.flush().good();
  }

  std::string
  pathOf(const std::string& name) const
  {
    return (folder_ / name).string();
  }

  bool
  isGood() const
  {
    return is_good_;
  }

private:
  std::filesystem::path folder_;
  bool is_good_ = true;
};

/** \brief An MCAP file of the frames of a stream. It has no checksums, which no fuzzer
 * guesses, and the schema has no text, so that it is small.
 * \param[in] compresses whether the chunk is compressed
 */
Bytes
mcapFileOf(const FrameRow& row, bool compresses, const std::string& path)
{
  using namespace pcl_ext::recording;
  McapChannel channel = compressedPointCloudChannel("/a");
  channel.schema.text.clear();
  McapWriter mcap;
  std::size_t number = 0;
  mcap.open(path, "ros2");
  mcap.addChannel(
      channel, compresses ? McapChunking::Shared : McapChunking::OwnStream, number);
  McapMessage message;
  PointCloudMessage cloud;
  cloud.fields = {{"x", 0, 7, 1}};
  cloud.format = "pcl_ext";
  for (const RowFrame& frame : row.frames) {
    cloud.bytes = frame.bytes;
    message.log_time += Time(1);
    writePointCloud(cloud, true, message.bytes);
    mcap.write(message);
  }
  mcap.write(McapMetadata{"m", {{"k", "v"}}});
  mcap.write(McapAttachment{Time(1), Time(2), "a", "b", {1, 2, 3}});
  mcap.finish();
  std::ifstream file(path, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  file.close();
  std::filesystem::remove(path);
  // The checksum of the chunk, after the header, the schema, the channel and the first
  // fields of the chunk, and that of the summary, before the magic bytes at the end.
  constexpr std::uint8_t chunk_opcode = 6;
  constexpr std::size_t prefix_size = 9;
  std::size_t at = 8;
  while (bytes[at] != chunk_opcode)
    at += prefix_size + bytes[at + 1] + std::size_t{256} * bytes[at + 2];
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at + prefix_size + 24), 4, 0);
  std::fill_n(bytes.end() - 12, 4, 0);
  return bytes;
}

#ifdef PCL_EXT_HAS_SQLITE
/** \brief A database of rosbag2 with the frames of a stream, in small pages. */
Bytes
databaseOf(const FrameRow& row, const std::string& path)
{
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  sqlite3_exec(
      database,
      "PRAGMA page_size = 512; CREATE TABLE topics(id INTEGER PRIMARY KEY, name, "
      "type, serialization_format, offered_qos_profiles); CREATE TABLE "
      "messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data); INSERT INTO "
      "topics VALUES(1, '/a', "
      "'point_cloud_interfaces/msg/CompressedPointCloud2', 'cdr', 'q')",
      nullptr,
      nullptr,
      nullptr);
  pcl_ext::recording::PointCloudMessage cloud;
  cloud.fields = {{"x", 0, 7, 1}};
  cloud.format = "pcl_ext";
  Bytes message;
  for (const RowFrame& frame : row.frames) {
    cloud.bytes = frame.bytes;
    writePointCloud(cloud, true, message);
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(
        database,
        "INSERT INTO messages(topic_id, timestamp, data) VALUES(1, 5, ?)",
        -1,
        &statement,
        nullptr);
    sqlite3_bind_blob(statement,
                      1,
                      message.data(),
                      static_cast<int>(message.size()),
                      SQLITE_TRANSIENT);
    sqlite3_step(statement);
    sqlite3_finalize(statement);
  }
  sqlite3_close(database);
  std::ifstream file(path, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  file.close();
  std::filesystem::remove(path);
  return bytes;
}
#endif

/** \brief A bag of ROS 1 with the frames of a stream in two chunks. */
Bytes
ros1BagOf(const FrameRow& row, const char* compression)
{
  pcl_ext::recording::test::Ros1Bag bag(compression);
  bag.padding = 0;
  bag.addConnection(0, "/a", "sensor_msgs/PointCloud2");
  bag.addConnection(1, "/b", "x/Y");
  for (std::size_t i = 0; i < row.frames.size(); ++i) {
    bag.addMessage(i % 2, 5, row.frames[i].bytes);
    if (i == 1)
      bag.endChunk();
  }
  bag.endChunk();
  return bag.bytes();
}

/** \brief Recordings of a stream: a file of frames, and bags. The first byte
 * chooses how the target reads them. */
void
writeRecordings(const std::string& name, const Bytes& stream, SeedWriter& writer)
{
  const FrameRow row(stream.data(), stream.size());
  std::vector<Bytes> files = {stream};
  for (const bool compresses : {false, true})
    files.push_back(mcapFileOf(row, compresses, writer.pathOf("recording.mcap")));
  std::vector<const char*> compressions = {"none", "lz4"};
#ifdef PCL_EXT_HAS_BZIP2
  compressions.push_back("bz2");
#endif
  for (const char* const compression : compressions)
    files.push_back(ros1BagOf(row, compression));
#ifdef PCL_EXT_HAS_SQLITE
  files.push_back(databaseOf(row, writer.pathOf("recording.db3")));
#endif
  // Files as rosbag2 compresses them: MCAP, and the last one.
  for (const std::size_t whole : {std::size_t{1}, files.size() - 1})
    if (Bytes part; pcl_ext::recording::mcap::compress(files[whole], part))
      files.push_back(part);
  for (std::size_t file = 0; file < files.size(); ++file)
    for (std::uint8_t way = 0; way < 3; ++way) {
      Bytes input = {way};
      append(files[file], input);
      writer.write("recordings",
                   name + '_' + std::to_string(file) + '_' + std::to_string(way),
                   input);
    }
}

/** \brief A stream in parts, of which each begins with an I-frame and none is larger
 * than what mutates well. */
void
writeParts(const std::string& name,
           const Bytes& stream,
           std::size_t most_parts,
           SeedWriter& writer)
{
  constexpr std::size_t most_bytes = 1000;
  const FrameRow row(stream.data(), stream.size());
  Bytes part;
  std::size_t parts = 0;
  const auto end_part = [&] {
    if (part.empty() || parts == most_parts)
      return;
    const std::string part_name = name + '_' + std::to_string(parts++);
    writer.write("frames", part_name, part);
    writer.write("decode_any_bytes", part_name, part);
    if (parts == 1)
      writeRecordings(part_name, part, writer);
    part.clear();
  };
  for (const RowFrame& frame : row.frames) {
    const bool stands_alone = !frame.isVersion1() || frame.isIFrame();
    if (stands_alone && part.size() + frame.bytes.size() > most_bytes)
      end_part();
    // P-frames that have no room any more are left out, and so are those after them.
    if (stands_alone || part.size() + frame.bytes.size() <= most_bytes)
      append(frame.bytes, part);
  }
  end_part();
}

void
writeFiles(const std::filesystem::path& folder, SeedWriter& writer)
{
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".pcxi")
      continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> content{std::istreambuf_iterator<char>(file), {}};
    const std::string name = entry.path().stem().string();
    // Effort Small takes most time, and differs little from Balanced.
    writeParts(name,
               {content.begin(), content.end()},
               name.compare(0, 5, "small") == 0 ? 1 : 100,
               writer);
  }
}

void
writeSmallStreams(SeedWriter& writer)
{
  for (std::uint8_t kind = 0; kind < stream_choices; ++kind) {
    SentStream stream;
    sendAll(streamKind(kind),
            sensorFrames(streamKind(kind), kind + 1u, 10, 0.04),
            4,
            1,
            stream);
    Bytes bytes;
    for (const SentFrame& frame : stream.frames)
      append(frame.bytes, bytes);
    writeParts("small_stream_" + std::to_string(kind), bytes, 100, writer);
  }
}

/** \brief Scans of a camera and of a lidar of a few points, as of the golden ones
 * I-frames alone are small enough. The sensor moves. */
void
writeSmallScans(SeedWriter& writer)
{
  using namespace pcl_ext::io;
  auto layout = std::make_shared<MessageLayout>();
  layout->fields.resize(2);
  layout->fields[0].name = "x";
  layout->fields[1].name = "ring";
  layout->fields[1].offset = 8;
  layout->point_step = 13;
  const auto write = [&](const std::string& name, const scan::ScanFrame& sensor) {
    FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Fast);
    Bytes stream;
    Bytes frame;
    for (unsigned int i = 0; i < 4; ++i) {
      scan::ScanFrame scan = sensor;
      scan.rays.pose.origin[0] += 1000 * (i / 2);
      test::addPoints(scan, i, sensor.rays.shape == scan::RayShape::Spinning);
      test::addFields(scan, i);
      scan.layout = layout;
      require(encoder.encode(scan, std::nullopt, frame).ok());
      append(frame, stream);
    }
    writeParts("small_scans_" + name, stream, 100, writer);
  };
  scan::ScanFrame camera = test::makeCamera();
  camera.width = 5;
  camera.height = 4;
  write("camera", camera);
  scan::ScanFrame lidar = test::makeLidar();
  test::fireOddRowsFirst(lidar);
  lidar.width = 3;
  lidar.rays.columns.resize(lidar.width);
  write("lidar", lidar);
}

/** \brief Inputs of targets whose bytes are choices. */
void
writeChoices(SeedWriter& writer)
{
  std::mt19937 random(1);
  for (std::uint8_t kind = 0; kind < stream_choices; ++kind) {
    const std::string name = "kind_" + std::to_string(kind);
    // Frames in order; one lost, a copy; two senders in turn.
    writer.write("sequences", name + "_in_order", {kind, 0, 0, 0, 0, 0, 0, 0});
    writer.write("sequences", name + "_loss", {kind, 0, 0, 2, 0, 0, 3, 1, 0, 0, 0});
    writer.write("sequences", name + "_turns", {kind, 0, 0, 8, 0, 8, 7, 0, 0, 8, 0});
    writer.write(
        "sequences", name + "_damage", {kind, 0, 0, 5, 99, 0, 0, 6, 20, 0, 4, 3, 0, 0});
  }
  for (unsigned int kind = 0; kind < 64; ++kind) {
    // Choices, settings, size and kind of a layout, and numbers for what these ask for.
    Bytes bytes{static_cast<std::uint8_t>(kind % 16),
                static_cast<std::uint8_t>(kind / 4),
                static_cast<std::uint8_t>(0x24 + 8 * (kind % 3)),
                static_cast<std::uint8_t>(kind + kind / 16 * 64)};
    for (std::size_t i = 0; i < 40; ++i)
      bytes.push_back(static_cast<std::uint8_t>(random() % 200));
    writer.write("cloud_layouts", "layout_" + std::to_string(kind), bytes);
    Bytes points{static_cast<std::uint8_t>(4 * kind + 1),
                 static_cast<std::uint8_t>(5 * kind),
                 static_cast<std::uint8_t>(kind)};
    for (std::size_t i = 0; i < 40; ++i) {
      const float number = 0.05f * static_cast<float>(random() % 100);
      const auto* const begin = reinterpret_cast<const std::uint8_t*>(&number);
      points.insert(points.end(), begin, begin + sizeof(number));
    }
    writer.write("round_trip", "points_" + std::to_string(kind), points);
  }
}

} // namespace

int
main(int argc, char** argv)
{
  if (argc != 3) {
    std::cerr << "write_seeds TEST_DATA FOLDER\n";
    return 1;
  }
  const std::filesystem::path data(argv[1]);
  SeedWriter writer(argv[2]);
  for (const char* const folder : {"golden", "invalid"})
    writeFiles(data / folder, writer);
  writeSmallStreams(writer);
  writeSmallScans(writer);
  writeChoices(writer);
  return writer.isGood() ? 0 : 1;
}

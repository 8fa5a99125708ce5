// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>

#include "recording/mcap_writer.h"
#include "stream/frame_encoder.h"
#include "support/test_folder.h"
#include "support/text_parts.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

using pcl_ext::test::hasPart;

using Bytes = std::vector<std::uint8_t>;

inline Bytes
bytesOf(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline std::string
textOf(const std::string& path)
{
  const Bytes bytes = bytesOf(path);
  return {bytes.begin(), bytes.end()};
}

inline void
writeBytes(const std::string& path, const Bytes& bytes)
{
  // Some file systems write a file to the disk at once if it replaces another's content.
  std::filesystem::remove(path);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

inline void
writeText(const std::string& path, const std::string& text)
{
  writeBytes(path, {text.begin(), text.end()});
}

struct KnownFrame {
  io::VoxelFrame voxels;
  Bytes bytes;
  Time time{0};
};

/** \brief The frames of one sensor. */
struct KnownStream {
  std::string name;
  std::vector<KnownFrame> frames;
};

/** \brief All numbers from begin to end, without it. */
inline std::vector<std::size_t>
numbersFrom(std::size_t begin, std::size_t end)
{
  std::vector<std::size_t> numbers(end - begin);
  std::iota(numbers.begin(), numbers.end(), begin);
  return numbers;
}

/** \brief The bytes of some frames of a stream, one after the other. */
inline Bytes
framesOf(const KnownStream& stream, const std::vector<std::size_t>& numbers)
{
  Bytes bytes;
  for (const std::size_t number : numbers)
    bytes.insert(bytes.end(),
                 stream.frames[number].bytes.begin(),
                 stream.frames[number].bytes.end());
  return bytes;
}

/** \brief The same of frames that follow each other. */
inline Bytes
framesOf(const KnownStream& stream, std::size_t begin, std::size_t end)
{
  return framesOf(stream, numbersFrom(begin, end));
}

/** \brief Encodes a stream of a room. Frames are 50 ms apart and have stamps.
 * \param[in] number of the stream, which differs from others; its times are number + 1 ms
 * later than those of a stream 0
 * \param[in] frames their number
 * \param[in] i_frame_rate of the encoder
 * \param[in] width of the room, voxels
 */
inline KnownStream
knownStream(std::size_t number,
            std::size_t frames,
            unsigned int i_frame_rate,
            std::uint32_t width = 5)
{
  io::test::RoomStream::Settings settings;
  settings.seed = 1 + number;
  settings.depth = 6;
  settings.width = width;
  settings.noise = 2;
  io::test::RoomStream room(settings);
  io::FrameEncoder encoder(
      io::StreamFormat::Version1, i_frame_rate, io::Effort::Balanced);
  KnownStream stream;
  stream.name = "/sensor_" + std::to_string(number);
  for (std::size_t i = 0; i < frames; ++i) {
    KnownFrame frame;
    frame.voxels = room.next();
    frame.time = std::chrono::milliseconds(1'000'000 + 50 * i) +
                 std::chrono::milliseconds(number);
    const io::FrameStamp stamp{static_cast<std::uint64_t>(frame.time.count() / 1000),
                               "world"};
    EXPECT_TRUE(encoder.encode(frame.voxels, stamp, frame.bytes).ok());
    stream.frames.push_back(std::move(frame));
  }
  return stream;
}

inline void
record(const std::vector<KnownStream>& streams, const std::string& path)
{
  RecordingWriter writer;
  ASSERT_TRUE(writer.open(path).ok());
  std::vector<std::size_t> numbers(streams.size());
  for (std::size_t i = 0; i < streams.size(); ++i)
    ASSERT_TRUE(writer.addStream({streams[i].name, "world", {}}, numbers[i]).ok());
  std::size_t most_frames = 0;
  for (const KnownStream& stream : streams)
    most_frames = std::max(most_frames, stream.frames.size());
  for (std::size_t frame = 0; frame < most_frames; ++frame)
    for (std::size_t i = 0; i < streams.size(); ++i)
      if (frame < streams[i].frames.size()) {
        const KnownFrame& known = streams[i].frames[frame];
        ASSERT_TRUE(
            writer
                .append(numbers[i], known.time, known.bytes.data(), known.bytes.size())
                .ok());
      }
  const RecordingStatus status = writer.finish();
  ASSERT_TRUE(status.ok()) << status;
}

/** \brief Writes an MCAP file or a rosbag2 folder.
 * \param[in] messages whose channels are indices of `channels`
 */
inline void
writeMcap(const std::string& path,
          const std::vector<McapChannel>& channels,
          std::vector<McapMessage> messages = {},
          const std::string& profile = "ros2")
{
  McapWriter writer;
  ASSERT_TRUE(writer.open(path, profile).ok());
  std::vector<std::size_t> numbers(channels.size());
  for (std::size_t i = 0; i < channels.size(); ++i)
    ASSERT_TRUE(writer.addChannel(channels[i], McapChunking::Shared, numbers[i]).ok());
  for (McapMessage& message : messages) {
    message.channel = numbers[message.channel];
    ASSERT_TRUE(writer.write(message).ok());
  }
  ASSERT_TRUE(writer.finish().ok());
}

inline bool
areSame(const io::VoxelFrame& first, const io::VoxelFrame& second)
{
  return first.grid == second.grid && first.keys == second.keys &&
         first.intensities == second.intensities;
}

/** \brief What a reader made of a recording, compared with what was recorded. */
struct ReadRecording {
  RecordingStatus status;           // of open()
  std::vector<std::size_t> decoded; // frames of each known stream
  std::size_t failed = 0;           // frames that were not read or not decoded
  std::size_t wrong = 0;            // decoded frames that nobody recorded
  std::size_t damages = 0;
  bool is_unfinished = false;
};

inline ReadRecording
readAll(const std::string& path, const std::vector<KnownStream>& known)
{
  ReadRecording result;
  result.decoded.resize(known.size());
  RecordingReader reader;
  result.status = reader.open(path);
  if (!result.status.ok())
    return result;
  std::vector<RecordedStreamDecoder> decoders;
  for (std::size_t i = 0; i < reader.streams().size(); ++i)
    decoders.emplace_back(reader, i);
  RecordedFrame frame;
  io::VoxelFrame voxels;
  for (;;) {
    const RecordingStatus status = reader.next(frame);
    if (status.code() == RecordingCode::EndOfRecording)
      break;
    if (!status.ok() || !decoders[frame.stream].decode(frame, voxels).ok()) {
      ++result.failed;
      continue;
    }
    bool is_known = false;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const std::size_t number = frame.description.frame_number - std::size_t{1};
      if (known.size() > 1 && known[i].name != reader.streams()[frame.stream].name)
        continue;
      if (number >= known[i].frames.size())
        continue;
      const KnownFrame& recorded = known[i].frames[number];
      is_known = areSame(recorded.voxels, voxels) && recorded.time == frame.time &&
                 recorded.time == frame.stamp && frame.frame_id == "world";
      result.decoded[i] += is_known ? 1 : 0;
      break;
    }
    result.wrong += is_known ? 0 : 1;
  }
  result.damages = reader.damage().size();
  result.is_unfinished = reader.isUnfinished();
  return result;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/golden_streams.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <sstream>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <utility>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr CompressionCode truncated = CompressionCode::Truncated;

/** \brief Receives a stream as the documentation of frameSize() says, and returns the
 * frames' sizes. */
std::vector<std::size_t>
receive(const Bytes& stream)
{
  std::vector<std::size_t> sizes;
  Bytes buffer;
  std::size_t received = 0;
  std::size_t reads = 0;
  while (received < stream.size() || !buffer.empty()) {
    const FrameSize size = frameSize(buffer.data(), buffer.size());
    if (size.needed > buffer.size()) {
      // Never more than belongs to the frame.
      for (std::size_t i = buffer.size(); i < size.needed; ++i)
        buffer.push_back(stream.at(received++));
      ++reads;
    }
    else {
      EXPECT_EQ(size.status.ok(), size.drop == 0);
      EXPECT_LE(size.drop, buffer.size());
      EXPECT_GT(size.known + size.drop, 0u);
      if (size.drop == 0)
        sizes.push_back(size.known);
      buffer.erase(buffer.begin(),
                   buffer.begin() +
                       static_cast<std::ptrdiff_t>(size.known + size.drop));
    }
    if (reads > 2 * stream.size()) {
      ADD_FAILURE() << "no progress";
      break;
    }
  }
  return sizes;
}

TEST(FrameSizes, AreKnownOfAllGoldenStreams)
{
  for (const GoldenStream& golden : goldenStreams()) {
    SCOPED_TRACE(golden.name);
    FrameEncoder encoder(StreamFormat::Version1, golden.i_frame_rate, golden.effort);
    Bytes stream;
    std::vector<std::size_t> sizes;
    for (const GoldenFrame& golden_frame : golden.frames) {
      const Bytes frame =
          golden_frame.scan ? encoded(encoder, *golden_frame.scan, golden_frame.stamp)
                            : encoded(encoder, golden_frame.frame, golden_frame.stamp);
      append(frame, stream);
      sizes.push_back(frame.size());
    }
    EXPECT_EQ(receive(stream), sizes);
  }
}

TEST(FrameSizes, OfThePublishedLayoutAreKnownWhenTheFrameIsComplete)
{
  std::mt19937_64 random(3);
  FrameEncoder encoder(StreamFormat::Published, 3);
  const EncodedFrames sent =
      encodedWalk(encoder, random, randomFrame(random, 4, 12), 4, 5);
  for (const Bytes& frame : sent.bytes) {
    for (std::size_t count = 0; count < frame.size(); ++count) {
      const FrameSize size = frameSize(frame.data(), count);
      EXPECT_EQ(size.status.code(), truncated);
      EXPECT_GT(size.needed, count);
      EXPECT_LE(size.needed, frame.size());
    }
    Bytes more = frame;
    more.push_back('<');
    EXPECT_TRUE(frameSize(more.data(), more.size()).status.ok());
    EXPECT_EQ(frameSize(more.data(), more.size()).known, frame.size());
  }
}

TEST(FrameSizes, BytesInFrontOfAFrameAreToBeDropped)
{
  std::mt19937_64 random(5);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    const Bytes frame = encoded(encoder, randomFrame(random, 4, 20));
    for (const std::string& text : {std::string("x"),
                                    std::string("PCX"),
                                    std::string("<HEAPCX<"),
                                    std::string(300, '\0')}) {
      Bytes stream(text.begin(), text.end());
      append(frame, stream);
      EXPECT_EQ(receive(stream), std::vector<std::size_t>{frame.size()});
    }
  }
}

TEST(FrameSizes, OfVersion1AreThoseOfTheHeaderUnlessDecodersRefuseIt)
{
  std::mt19937_64 random(6);
  FrameEncoder encoder(StreamFormat::Version1, 3, Effort::Balanced);
  const Bytes frame = encoded(encoder, randomFrame(random, 8, 3000));
  DecoderLimits few_bytes;
  few_bytes.max_frame_bytes = frame.size() / 2;
  DecoderLimits few_voxels;
  few_voxels.max_voxels = 2000;
  for (const DecoderLimits& limits : {few_bytes, few_voxels}) {
    const FrameSize size = frameSize(frame.data(), frame.size(), limits);
    EXPECT_EQ(size.status.code(), CompressionCode::LimitExceeded);
    EXPECT_LE(size.drop, frame.size());
  }
  // The size is known from the header.
  ASSERT_GT(frame.size(), 500u);
  EXPECT_TRUE(frameSize(frame.data(), 100).status.ok());
  EXPECT_EQ(frameSize(frame.data(), 100).known, frame.size());
  Bytes other_version = frame;
  other_version[4] = 2;
  EXPECT_EQ(frameSize(other_version.data(), other_version.size()).status.code(),
            CompressionCode::UnsupportedVersion);
}

/** \brief Appends a stream to a buffer byte by byte and decodes after each. */
void
expectFramesWhenComplete(const EncodedFrames& sent, IncompleteFrame incomplete_frame)
{
  const bool keeps = incomplete_frame == IncompleteFrame::Keep;
  FrameDecoder decoder(DecoderLimits(), incomplete_frame);
  std::stringbuf buffer;
  VoxelFrame back;
  std::size_t decoded_frames = 0;
  for (std::size_t i = 0; i < sent.bytes.size(); ++i)
    for (std::size_t j = 0; j < sent.bytes[i].size(); ++j) {
      buffer.sputc(static_cast<char>(sent.bytes[i][j]));
      const CompressionStatus status = decoder.decode(buffer, back);
      decoded_frames += status.ok() ? 1 : 0;
      if (!keeps)
        continue;
      const bool is_complete = j + 1 == sent.bytes[i].size();
      ASSERT_EQ(status.code(), is_complete ? CompressionCode::Ok : truncated) << status;
      EXPECT_EQ(back.size(), is_complete ? sent.frames[i].size() : 0u);
    }
  EXPECT_EQ(decoded_frames, keeps ? sent.bytes.size() : 0u);
}

TEST(IncompleteFrames, WaitForTheirRestIfToldTo)
{
  std::mt19937_64 random(7);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    const EncodedFrames sent =
        encodedWalk(encoder, random, randomFrame(random, 4, 30), 5, 5);
    expectFramesWhenComplete(sent, IncompleteFrame::Keep);
    expectFramesWhenComplete(sent, IncompleteFrame::Skip);
  }
}

TEST(IncompleteFrames, WaitBehindOtherBytes)
{
  std::mt19937_64 random(8);
  FrameEncoder encoder(StreamFormat::Version1, 3, Effort::Balanced);
  const Bytes frame = encoded(encoder, randomFrame(random, 4, 30));
  FrameDecoder decoder(DecoderLimits(), IncompleteFrame::Keep);
  VoxelFrame back;
  std::stringbuf buffer;
  const std::string garbage = "<HEAVY>";
  buffer.sputn(garbage.data(), static_cast<std::streamsize>(garbage.size()));
  EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::NoFrame);
  for (const std::uint8_t byte : frame)
    buffer.sputc(static_cast<char>(byte));
  EXPECT_TRUE(decoder.decode(buffer, back).ok());
}

// ---------------------------------------------------------------- other formats

TEST(ForeignBytes, AreNamedWithWhatReadsThem)
{
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"<PCL-OCT-COMPRESSED>\x01\x02", "pcl::io::OctreePointCloudCompression"},
      {"<PCL-ORG-COMPRESSED>\x01", "pcl::io::OrganizedPointCloudCompression"},
      {"# .PCD v0.7 - Point Cloud Data file format\n", "loadPCDFile"},
      {"VERSION 0.7\nFIELDS x y z\n", "loadPCDFile"},
      {"ply\nformat binary_little_endian 1.0\n", "loadPLYFile"},
      {"#ROSBAG V2.0\n", "ROS bag"},
      {"\x89MCAP\x30\r\n", "MCAP"},
      {"a letter to the reader", "text"}};
  for (const auto& [bytes, name] : cases) {
    std::stringbuf buffer(bytes);
    FrameDecoder decoder;
    VoxelFrame back;
    const CompressionStatus status = decoder.decode(buffer, back);
    EXPECT_EQ(status.code(), CompressionCode::NoFrame);
    EXPECT_NE(status.message().find(", which begin as "), std::string::npos) << status;
    EXPECT_NE(status.message().find(name), std::string::npos) << status;
  }
  for (const std::string& bytes : {std::string("short"), std::string(40, '\0')}) {
    std::stringbuf buffer(bytes);
    VoxelFrame back;
    const CompressionStatus status = FrameDecoder().decode(buffer, back);
    EXPECT_EQ(status.message().find("begin as"), std::string::npos) << status;
  }
}

EncodedFrames
shortStream(StreamFormat format)
{
  std::mt19937_64 random(7);
  FrameEncoder encoder(format, 10, Effort::Balanced);
  return encodedWalk(encoder, random, randomFrame(random, 3, 7), 2, 2);
}

/** \brief Gives its bytes in small pieces and cannot seek; may throw on the way. */
class Pipe : public std::streambuf {
public:
  explicit Pipe(
      const Bytes& bytes,
      std::size_t throw_at = SIZE_MAX,
      std::function<void()> failure = [] { throw std::runtime_error("read error"); })
  : bytes_(bytes.begin(), bytes.end())
  , throw_at_(throw_at)
  , failure_(std::move(failure))
  {}

private:
  int_type
  underflow() override
  {
    if (next_ >= throw_at_)
      failure_();
    if (next_ == bytes_.size())
      return traits_type::eof();
    const std::size_t size = std::min<std::size_t>(bytes_.size() - next_, 5);
    setg(&bytes_[next_], &bytes_[next_], &bytes_[next_] + size);
    next_ += size;
    return traits_type::to_int_type(*gptr());
  }

  std::string bytes_;
  std::size_t throw_at_;
  std::function<void()> failure_;
  std::size_t next_ = 0;
};

TEST(StreamBuffers, BuffersThatCannotSeekWorkLikeThoseThatCan)
{
  for (const StreamFormat format : all_formats) {
    const EncodedFrames stream = shortStream(format);
    Bytes bytes{'x', 'P', 'C'};
    append(stream.bytes[0], bytes);
    append(stream.bytes[1], bytes);
    Pipe pipe(bytes);
    FrameDecoder decoder;
    VoxelFrame back;
    ASSERT_TRUE(decoder.decode(pipe, back).ok());
    EXPECT_EQ(decoder.statistics().skipped_bytes, 3u);
    expectSameVoxels(back, stream.frames[0]);
    ASSERT_TRUE(decoder.decode(pipe, back).ok());
    expectSameVoxels(back, stream.frames[1]);
    EXPECT_EQ(decoder.decode(pipe, back).code(), CompressionCode::EndOfStream);
  }
}

TEST(StreamBuffers, ABufferThatThrowsIsAnInputThatFailed)
{
  for (const StreamFormat format : all_formats) {
    const Bytes i_frame = shortStream(format).bytes[0];
    for (std::size_t at = 0; at < i_frame.size(); at += 5) {
      Pipe pipe(i_frame, at);
      FrameDecoder decoder;
      VoxelFrame back;
      back.keys = {1};
      ASSERT_EQ(decoder.decode(pipe, back).code(), CompressionCode::InputFailed) << at;
      ASSERT_TRUE(back.keys.empty());
      ASSERT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
    }
  }
}

/** \brief Throws when it is asked where it stands, as Boost's buffers over a device
 * without random access do. */
class Unseekable : public std::stringbuf {
public:
  using std::stringbuf::stringbuf;

private:
  pos_type
  seekoff(off_type, std::ios_base::seekdir, std::ios_base::openmode) override
  {
    throw std::runtime_error("no seeking here");
  }

  pos_type
  seekpos(pos_type, std::ios_base::openmode) override
  {
    throw std::runtime_error("no seeking here");
  }
};

TEST(StreamBuffers, ABufferThatThrowsOnSeekingIsOneThatCannotSeek)
{
  const std::vector<Bytes> stream = shortStream(StreamFormat::Version1).bytes;
  const auto code = [](const Bytes& bytes) {
    Unseekable buffer(std::string(bytes.begin(), bytes.end()));
    FrameDecoder decoder;
    VoxelFrame back;
    CompressionStatus status;
    EXPECT_NO_THROW(status = decoder.decode(buffer, back));
    EXPECT_EQ(back.keys.empty(), !status.ok());
    return status.code();
  };
  EXPECT_EQ(code(stream[0]), CompressionCode::Ok);
  EXPECT_EQ(code(stream[1]), CompressionCode::MissingReference);
  EXPECT_EQ(code(flipped(stream[0], 100)), CompressionCode::Corrupt);
  EXPECT_EQ(code({1, 2, 3}), CompressionCode::NoFrame);
}

TEST(StreamBuffers, ExceptionsOfAnyTypeBecomeInputFailed)
{
  Pipe pipe({}, 0, [] { throw 42; }); // as some libraries' cancellations do
  FrameDecoder decoder;
  VoxelFrame back;
  CompressionStatus status;
  EXPECT_NO_THROW(status = decoder.decode(pipe, back));
  EXPECT_EQ(status.code(), CompressionCode::InputFailed);
}

TEST(StreamBuffers, DamagedStreamsEndWithoutSeeking)
{
  // With seeking: the fuzz target decode_any_bytes.
  std::mt19937_64 random(2);
  for (const StreamFormat format : all_formats)
    for (int round = 0; round < 60; ++round) {
      FrameEncoder encoder(format, 3, Effort::Balanced);
      Bytes bytes;
      for (int i = 0; i < 6; ++i)
        append(encoded(encoder, randomFrame(random, 3, 20)), bytes);
      for (std::uint64_t i = below(random, 30); i > 0; --i)
        bytes = flipped(bytes, below(random, 8 * bytes.size()));
      if (round % 3 == 0)
        bytes.resize(below(random, bytes.size()));
      DecoderLimits limits;
      limits.max_frame_bytes = round % 2 == 0 ? limits.max_frame_bytes : 100;
      FrameDecoder decoder(limits);
      VoxelFrame back;
      Pipe pipe(bytes);
      std::size_t calls = 0;
      while (decoder.decode(pipe, back).code() != CompressionCode::EndOfStream)
        ASSERT_LE(++calls, bytes.size());
    }
}

} // namespace

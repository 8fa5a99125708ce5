// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Decoding from stream buffers that cannot seek, fail or throw; any bytes come
 * to their end.
 */
#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <sstream>
#include <stdexcept>
#include <streambuf>
#include <string>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

/** \brief An I-frame and a P-frame. */
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
  explicit Pipe(const Bytes& bytes, std::size_t throw_at = SIZE_MAX)
  : bytes_(bytes.begin(), bytes.end()), throw_at_(throw_at)
  {}

private:
  int_type
  underflow() override
  {
    if (next_ >= throw_at_)
      throw std::runtime_error("read error");
    if (next_ == bytes_.size())
      return traits_type::eof();
    const std::size_t size = std::min<std::size_t>(bytes_.size() - next_, 5);
    setg(&bytes_[next_], &bytes_[next_], &bytes_[next_] + size);
    next_ += size;
    return traits_type::to_int_type(*gptr());
  }

  std::string bytes_;
  std::size_t throw_at_;
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

/** \brief Throws what is no std::exception, as some libraries' cancellations do. */
class Oddity : public std::streambuf {
  int_type
  underflow() override
  {
    throw 42;
  }
};

TEST(StreamBuffers, ExceptionsOfAnyTypeBecomeInputFailed)
{
  Oddity buffer;
  FrameDecoder decoder;
  VoxelFrame back;
  CompressionStatus status;
  EXPECT_NO_THROW(status = decoder.decode(buffer, back));
  EXPECT_EQ(status.code(), CompressionCode::InputFailed);
}

TEST(StreamBuffers, DecodingInALoopAlwaysEnds)
{
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
      std::stringbuf buffer = bufferOf(bytes);
      Pipe pipe(bytes);
      for (std::streambuf* source : {static_cast<std::streambuf*>(&buffer),
                                     static_cast<std::streambuf*>(&pipe)}) {
        std::size_t calls = 0;
        while (decoder.decode(*source, back).code() != CompressionCode::EndOfStream)
          ASSERT_LE(++calls, bytes.size());
      }
    }
}

} // namespace

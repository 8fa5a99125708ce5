#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

/** \brief A stream of an I-frame and a P-frame. */
struct ShortStream {
  StreamFormat format;
  VoxelFrame first;
  VoxelFrame second;
  Bytes i_frame;
  Bytes p_frame;
};

ShortStream
shortStream(StreamFormat format, std::size_t voxels, unsigned int bits)
{
  std::mt19937_64 random(voxels + bits);
  ShortStream stream;
  stream.format = format;
  stream.first = randomFrame(random, voxels < 50 ? 4 : 3, voxels, bits);
  stream.second = stream.first;
  walk(random, static_cast<unsigned int>(voxels / 4 + 1), stream.second);
  FrameEncoder encoder(format, 10);
  std::optional<FrameStamp> stamp;
  if (format == StreamFormat::Version1 && voxels == 7)
    stamp = FrameStamp{voxels, "lidar"};
  stream.i_frame = encoded(encoder, stream.first, stamp);
  stream.p_frame = encoded(encoder, stream.second, stamp);
  return stream;
}

/** \brief Decodes a copy of exactly that size, so that a sanitizer sees every read
 * after it. */
CompressionCode
decodedExact(FrameDecoder& decoder, const Bytes& bytes, VoxelFrame& frame)
{
  const std::unique_ptr<std::uint8_t[]> copy(new std::uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), copy.get());
  frame.keys = {1, 2, 3};
  frame.intensities = {1, 2};
  const CompressionStatus status = decoder.decode(copy.get(), bytes.size(), frame);
  EXPECT_TRUE(status.ok() || (frame.keys.empty() && frame.intensities.empty()));
  EXPECT_EQ(status.ok(), status.message().empty());
  return status.code();
}

/** \brief Fields of a frame of the published layout in which a flip may go unseen: the
 * number of an I-frame, and the last bits of its octree's box. */
std::string
publishedField(std::size_t byte, bool is_i_frame)
{
  if (byte >= 6 && byte < 10)
    return "frame number";
  if (is_i_frame && byte >= 19 && byte < 27)
    return "resolution";
  if (is_i_frame && byte >= 27 && byte < 75)
    return "box";
  return "byte " + std::to_string(byte);
}

/** \brief Same voxels, at the same places except for a micrometre. */
bool
looksLike(const VoxelFrame& frame, const VoxelFrame& expected)
{
  if (frame.keys != expected.keys || frame.intensities != expected.intensities ||
      frame.grid.depth != expected.grid.depth)
    return false;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::uint32_t position : {0u, (1u << expected.grid.depth) - 1})
      if (!(std::abs(frame.grid.centre(axis, position) -
                     expected.grid.centre(axis, position)) < 1e-6))
        return false;
  return true;
}

class InvalidStreams : public testing::Test {
protected:
  static std::vector<ShortStream>
  streams()
  {
    std::vector<ShortStream> streams;
    for (const std::size_t voxels : {1u, 7u, 60u})
      for (const unsigned int bits : {8u, 16u})
        streams.push_back(shortStream(StreamFormat::Version1, voxels, bits));
    for (const std::size_t voxels : {1u, 40u})
      streams.push_back(shortStream(StreamFormat::Published, voxels, 8));
    return streams;
  }
};

TEST_F(InvalidStreams, EveryTruncationIsRefused)
{
  for (const ShortStream& stream : streams()) {
    FrameDecoder decoder;
    VoxelFrame back;
    for (const bool is_i_frame : {true, false}) {
      const Bytes& whole = is_i_frame ? stream.i_frame : stream.p_frame;
      for (std::size_t size = 0; size < whole.size(); ++size) {
        const Bytes bytes = prefixOf(whole, size);
        const std::size_t magic = stream.format == StreamFormat::Version1 ? 4 : 6;
        ASSERT_EQ(decodedExact(decoder, bytes, back),
                  size == 0      ? CompressionCode::EndOfStream
                  : size < magic ? CompressionCode::NoFrame
                                 : CompressionCode::Truncated)
            << size;
      }
      ASSERT_EQ(decodedExact(decoder, whole, back), CompressionCode::Ok);
      expectSameVoxels(back, is_i_frame ? stream.first : stream.second);
    }
  }
}

TEST_F(InvalidStreams, EveryFlipIsRefusedOrHarmless)
{
  std::map<std::string, std::size_t> harmless;
  for (const ShortStream& stream : streams()) {
    for (const bool is_i_frame : {true, false}) {
      const Bytes& whole = is_i_frame ? stream.i_frame : stream.p_frame;
      const VoxelFrame& expected = is_i_frame ? stream.first : stream.second;
      FrameDecoder decoder;
      VoxelFrame back;
      ASSERT_EQ(decodedExact(decoder, stream.i_frame, back), CompressionCode::Ok);
      for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        if (decodedExact(decoder, flipped(whole, bit), back) != CompressionCode::Ok)
          continue;
        ASSERT_EQ(stream.format, StreamFormat::Published) << "bit " << bit;
        ASSERT_TRUE(looksLike(back, expected)) << "bit " << bit;
        ++harmless[publishedField(bit / 8, is_i_frame)];
        decoder = FrameDecoder();
        ASSERT_EQ(decodedExact(decoder, stream.i_frame, back), CompressionCode::Ok);
      }
      // No flip has touched the history.
      ASSERT_EQ(decodedExact(decoder, stream.p_frame, back), CompressionCode::Ok);
      expectSameVoxels(back, stream.second);
    }
  }
  for (const auto& field : harmless) {
    std::cout << field.second << " harmless flips in: " << field.first << '\n';
    EXPECT_TRUE(field.first == "frame number" || field.first == "resolution" ||
                field.first == "box")
        << field.first;
  }
}

TEST_F(InvalidStreams, AGoodIFrameBehindABadFrameIsFound)
{
  for (const ShortStream& stream : streams()) {
    const std::size_t step = stream.format == StreamFormat::Version1 ? 1 : 11;
    for (std::size_t bit = 0; bit < 8 * stream.i_frame.size(); bit += step) {
      Bytes bytes = flipped(stream.i_frame, bit);
      append(stream.i_frame, bytes);
      append(stream.p_frame, bytes);
      std::stringbuf buffer = bufferOf(bytes);
      FrameDecoder decoder;
      VoxelFrame back;
      std::vector<VoxelFrame> frames;
      CompressionCode code = CompressionCode::Ok;
      for (int i = 0; i < 8 && code != CompressionCode::EndOfStream &&
                      code != CompressionCode::NoFrame;
           ++i) {
        code = decoder.decode(buffer, back).code();
        if (code == CompressionCode::Ok)
          frames.push_back(back);
      }
      ASSERT_GE(frames.size(), 2u) << "bit " << bit;
      expectSameVoxels(frames[frames.size() - 2], stream.first);
      expectSameVoxels(frames[frames.size() - 1], stream.second);
    }
  }
}

// ---------------------------------------------------------------- stream buffers

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

Bytes
randomInput(std::mt19937_64& random, std::size_t number)
{
  Bytes bytes;
  const std::string version1("PCXI\x01", 5);
  const std::string published = "<HEAD>";
  if (number % 4 == 0)
    bytes.assign(version1.begin(), version1.end());
  if (number % 4 == 2)
    bytes.assign(published.begin(), published.end());
  for (std::size_t rest = below(random, 200); rest > 0; --rest)
    bytes.push_back(static_cast<std::uint8_t>(
        number % 3 == 0 ? random() & random() & random() : random()));
  return bytes;
}

TEST_F(InvalidStreams, RandomInputsAreRefused)
{
  std::mt19937_64 random(1);
  const ShortStream good = shortStream(StreamFormat::Version1, 7, 8);
  FrameDecoder decoder; // one for all: invalid input leaves it unchanged
  VoxelFrame back;
  for (std::size_t number = 0; number < 10000; ++number) {
    const Bytes bytes = randomInput(random, number);
    const MemoryUse memory_use;
    ASSERT_NE(decodedExact(decoder, bytes, back), CompressionCode::Ok);
    Pipe pipe(bytes);
    ASSERT_FALSE(decoder.decode(pipe, back).ok());
    Pipe broken(bytes, below(random, 150));
    ASSERT_FALSE(decoder.decode(broken, back).ok());
    std::stringbuf seekable = bufferOf(bytes);
    ASSERT_FALSE(decoder.decode(seekable, back).ok());
    ASSERT_LT(memory_use.largest(), std::size_t{1} << 17);
    ASSERT_EQ(decodedExact(decoder, good.i_frame, back), CompressionCode::Ok);
  }
}

TEST_F(InvalidStreams, BuffersThatCannotSeekWorkLikeThoseThatCan)
{
  for (const ShortStream& stream : streams()) {
    Bytes bytes{'x', 'P', 'C'};
    append(stream.i_frame, bytes);
    append(stream.p_frame, bytes);
    Pipe pipe(bytes);
    FrameDecoder decoder;
    VoxelFrame back;
    ASSERT_TRUE(decoder.decode(pipe, back).ok());
    EXPECT_EQ(decoder.statistics().skipped_bytes, 3u);
    expectSameVoxels(back, stream.first);
    ASSERT_TRUE(decoder.decode(pipe, back).ok());
    expectSameVoxels(back, stream.second);
    EXPECT_EQ(decoder.decode(pipe, back).code(), CompressionCode::EndOfStream);
  }
}

TEST_F(InvalidStreams, ABufferThatThrowsIsAnInputThatFailed)
{
  for (const ShortStream& stream : streams())
    for (std::size_t at = 0; at < stream.i_frame.size(); at += 5) {
      Pipe pipe(stream.i_frame, at);
      FrameDecoder decoder;
      VoxelFrame back;
      back.keys = {1};
      ASSERT_EQ(decoder.decode(pipe, back).code(), CompressionCode::InputFailed) << at;
      ASSERT_TRUE(back.keys.empty());
      ASSERT_EQ(decodedExact(decoder, stream.i_frame, back), CompressionCode::Ok);
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

TEST_F(InvalidStreams, ABufferThatThrowsOnSeekingIsOneThatCannotSeek)
{
  const ShortStream stream = shortStream(StreamFormat::Version1, 7, 8);
  const auto code = [](const Bytes& bytes) {
    Unseekable buffer(std::string(bytes.begin(), bytes.end()));
    FrameDecoder decoder;
    VoxelFrame back;
    CompressionStatus status;
    EXPECT_NO_THROW(status = decoder.decode(buffer, back));
    EXPECT_EQ(back.keys.empty(), !status.ok());
    return status.code();
  };
  EXPECT_EQ(code(stream.i_frame), CompressionCode::Ok);
  EXPECT_EQ(code(stream.p_frame), CompressionCode::MissingReference);
  EXPECT_EQ(code(flipped(stream.i_frame, 100)), CompressionCode::Corrupt);
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

TEST_F(InvalidStreams, ExceptionsOfAnyTypeBecomeInputFailed)
{
  Oddity buffer;
  FrameDecoder decoder;
  VoxelFrame back;
  CompressionStatus status;
  EXPECT_NO_THROW(status = decoder.decode(buffer, back));
  EXPECT_EQ(status.code(), CompressionCode::InputFailed);
}

// ---------------------------------------------------------------- progress

TEST_F(InvalidStreams, DecodingInALoopAlwaysEnds)
{
  std::mt19937_64 random(2);
  for (const StreamFormat format : all_formats)
    for (int round = 0; round < 60; ++round) {
      FrameEncoder encoder(format, 3);
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

/** \file
 * \brief Which frame of the published layout a P-frame may follow, and that only a frame
 * that was coded whole is one.
 */
#include "bytes/byte_source.h"
#include "codec/published/frame.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>
#include <streambuf>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::published;
using namespace pcl_ext::io::test;
using pcl_ext::test::failEachAllocation;

/** \brief A stream of the published layout: an I-frame and P-frames. */
EncodedFrames
stream(std::size_t count)
{
  std::mt19937_64 random(count);
  FrameEncoder encoder(StreamFormat::Published, static_cast<unsigned int>(count));
  return encodedWalk(encoder, random, randomFrame(random, 4, 50), count, 5);
}

void
setNumber(std::uint32_t number, Bytes& frame)
{
  std::memcpy(frame.data() + published::magic_size, &number, sizeof(number));
}

TEST(PublishedHistory, APFrameFollowsOnlyTheFrameBeforeIt)
{
  const EncodedFrames sent = stream(5);
  FrameDecoder decoder;
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, sent.bytes[1], back), CompressionCode::MissingReference);
  for (std::size_t last = 0; last < sent.bytes.size(); ++last) {
    ASSERT_EQ(decoded(decoder, sent.bytes[last], back), CompressionCode::Ok);
    expectSameVoxels(back, sent.frames[last]);
    for (std::size_t next = 1; next < sent.bytes.size(); ++next)
      if (next != last + 1) {
        EXPECT_EQ(decoded(decoder, sent.bytes[next], back),
                  next <= last ? CompressionCode::OldFrame
                               : CompressionCode::MissingReference)
            << "frame " << next + 1 << " behind frame " << last + 1;
      }
  }
}

TEST(PublishedHistory, FrameNumbersWrapRound)
{
  EncodedFrames sent = stream(3);
  const std::uint32_t last = std::numeric_limits<std::uint32_t>::max();
  setNumber(last - 1, sent.bytes[0]);
  setNumber(last, sent.bytes[1]);
  setNumber(0, sent.bytes[2]);
  FrameDecoder decoder;
  VoxelFrame back;
  for (std::size_t i = 0; i < sent.bytes.size(); ++i) {
    ASSERT_EQ(decoded(decoder, sent.bytes[i], back), CompressionCode::Ok);
    EXPECT_EQ(decoder.statistics().frame_number,
              static_cast<std::uint32_t>(last - 1 + i));
    expectSameVoxels(back, sent.frames[i]);
  }
}

TEST(PublishedHistory, AFrameIsAppendedAndCountedAlone)
{
  const EncodedFrames sent = stream(2);
  published::History history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    Bytes bytes(5, 0xaa);
    CodedFrameStatistics statistics;
    published::encodeFrame(sent.frames[i], i == 0, history, bytes, statistics);
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 5), Bytes(5, 0xaa));
    EXPECT_EQ(Bytes(bytes.begin() + 5, bytes.end()), sent.bytes[i]);
    EXPECT_EQ(statistics.frame_number, i + 1);
    EXPECT_EQ(statistics.bytes, sent.bytes[i].size());
    EXPECT_EQ(statistics.header_bytes, i == 0 ? 75u : 11u);
    EXPECT_EQ(statistics.header_bytes + statistics.occupancy_bytes +
                  statistics.intensity_bytes,
              statistics.bytes);
    FrameDecoder decoder;
    VoxelFrame back;
    for (std::size_t j = 0; j <= i; ++j)
      ASSERT_EQ(decoded(decoder, sent.bytes[j], back), CompressionCode::Ok);
    EXPECT_EQ(decoder.statistics().bytes, statistics.bytes);
    EXPECT_EQ(decoder.statistics().header_bytes, statistics.header_bytes);
    EXPECT_EQ(decoder.statistics().occupancy_bytes, statistics.occupancy_bytes);
    EXPECT_EQ(decoder.statistics().intensity_bytes, statistics.intensity_bytes);
    // Each row of symbols has its count and table.
    EXPECT_GT(statistics.occupancy_bytes, 1036u);
    EXPECT_GT(statistics.intensity_bytes, 1036u + sent.frames[i].size() / 4);
  }
}

// ------------------------------------------------- frames that fail

void
expectSameHistory(const published::History& history, const published::History& expected)
{
  EXPECT_EQ(history.has_frame, expected.has_frame);
  EXPECT_EQ(history.frame_number, expected.frame_number);
  EXPECT_TRUE(history.grid == expected.grid);
  ASSERT_EQ(history.tree.depth(), expected.tree.depth());
  for (unsigned int level = 0; level < expected.tree.depth(); ++level) {
    EXPECT_EQ(history.tree.level(level).nodes, expected.tree.level(level).nodes);
    EXPECT_EQ(history.tree.level(level).occupancy,
              expected.tree.level(level).occupancy);
  }
}

TEST(PublishedHistory, IsUnchangedWhenEncodingRunsOutOfMemory)
{
  const EncodedFrames sent = stream(3);
  published::History history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    const published::History before = history;
    Bytes bytes;
    const auto encode = [&] {
      bytes = Bytes(); // without memory of its own
      CodedFrameStatistics statistics;
      published::encodeFrame(sent.frames[i], i == 0, history, bytes, statistics);
    };
    EXPECT_GT(failEachAllocation(encode, [&] { expectSameHistory(history, before); }),
              10u);
    EXPECT_EQ(bytes, sent.bytes[i]);
  }
}

TEST(PublishedHistory, IsUnchangedWhenDecodingRunsOutOfMemory)
{
  const EncodedFrames sent = stream(3);
  published::History history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    const published::History before = history;
    VoxelFrame back;
    CompressionStatus status;
    const auto decode = [&] {
      FrameOrder order(false);
      MemoryBuffer buffer(sent.bytes[i].data() + published::magic_size,
                          sent.bytes[i].size() - published::magic_size);
      ByteSource source(buffer, sent.bytes[i].size());
      back = VoxelFrame();
      CodedFrameStatistics statistics;
      status = published::decodeFrame(
          source, DecoderLimits(), history, order, back, statistics);
    };
    EXPECT_GT(failEachAllocation(decode, [&] { expectSameHistory(history, before); }),
              10u);
    EXPECT_TRUE(status.ok()) << status.message();
    expectSameVoxels(back, sent.frames[i]);
  }
}

/** \brief Throws when it has given a number of bytes. */
class BrokenBuffer : public std::streambuf {
public:
  BrokenBuffer(Bytes& bytes, std::size_t size)
  {
    char* const begin = reinterpret_cast<char*>(bytes.data());
    setg(begin, begin, begin + size);
  }

private:
  int_type
  underflow() override
  {
    throw std::runtime_error("read error");
  }
};

TEST(PublishedHistory, IsUnchangedWhenTheSourceThrows)
{
  EncodedFrames sent = stream(3);
  published::History history;
  for (Bytes& bytes : sent.bytes) {
    Bytes frame(bytes.begin() + published::magic_size, bytes.end());
    const published::History before = history;
    FrameOrder order(false);
    VoxelFrame back;
    CodedFrameStatistics statistics;
    for (std::size_t size = 0; size < frame.size(); ++size) {
      BrokenBuffer broken(frame, size);
      ByteSource source(broken, frame.size());
      EXPECT_THROW(published::decodeFrame(
                       source, DecoderLimits(), history, order, back, statistics),
                   std::runtime_error);
      expectSameHistory(history, before);
    }
    BrokenBuffer whole(frame, frame.size());
    ByteSource source(whole, frame.size());
    ASSERT_TRUE(published::decodeFrame(
                    source, DecoderLimits(), history, order, back, statistics)
                    .ok());
  }
}

} // namespace

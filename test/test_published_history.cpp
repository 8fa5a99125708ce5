/** \file
 * \brief Which frame of the published layout a P-frame may follow, and that only a frame
 * that was coded whole is one.
 */
#include "compression/byte_source.h"
#include "compression/memory_buffer.h"
#include "compression/published_frame.h"
#include "voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <stdexcept>
#include <streambuf>
#include <vector>

namespace {

constexpr std::size_t never = std::numeric_limits<std::size_t>::max();
std::size_t allocations_left = never;

} // namespace

// Not inline: GCC would see malloc and delete, or new and free, as a pair.
[[gnu::noinline]] void*
operator new(std::size_t size)
{
  if (allocations_left == 0)
    throw std::bad_alloc();
  if (allocations_left != never)
    --allocations_left;
  if (void* const memory = std::malloc(size))
    return memory;
  throw std::bad_alloc();
}

[[gnu::noinline]] void
operator delete(void* memory) noexcept
{
  std::free(memory);
}

[[gnu::noinline]] void
operator delete(void* memory, std::size_t /*size*/) noexcept
{
  std::free(memory);
}

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief Frames of a stream of the published layout: an I-frame and P-frames. */
struct Stream {
  std::vector<VoxelFrame> frames;
  std::vector<Bytes> bytes;
};

Stream
stream(std::size_t count)
{
  std::mt19937_64 random(count);
  Stream stream;
  FrameEncoder encoder(StreamFormat::Published, static_cast<unsigned int>(count));
  VoxelFrame frame = randomFrame(random, 4, 50);
  for (std::size_t i = 0; i < count; ++i) {
    stream.frames.push_back(frame);
    stream.bytes.push_back(encoded(encoder, frame));
    EXPECT_EQ(encoder.statistics().is_i_frame, i == 0);
    EXPECT_EQ(encoder.statistics().frame_number, i + 1);
    walk(random, 5, frame);
  }
  return stream;
}

void
setNumber(std::uint32_t number, Bytes& frame)
{
  std::memcpy(frame.data() + published_magic_size, &number, sizeof(number));
}

TEST(PublishedHistory, APFrameFollowsOnlyTheFrameBeforeIt)
{
  const Stream sent = stream(5);
  FrameDecoder decoder;
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, sent.bytes[1], back), CompressionCode::MissingReference);
  for (std::size_t last = 0; last < sent.bytes.size(); ++last) {
    ASSERT_EQ(decoded(decoder, sent.bytes[last], back), CompressionCode::Ok);
    expectSameVoxels(back, sent.frames[last]);
    for (std::size_t next = 1; next < sent.bytes.size(); ++next)
      if (next != last + 1) {
        EXPECT_EQ(decoded(decoder, sent.bytes[next], back),
                  CompressionCode::MissingReference)
            << "frame " << next + 1 << " behind frame " << last + 1;
      }
  }
}

TEST(PublishedHistory, FrameNumbersWrapRound)
{
  Stream sent = stream(3);
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
  const Stream sent = stream(2);
  PublishedHistory history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    Bytes bytes(5, 0xaa);
    CodedFrameStatistics statistics;
    encodePublished(sent.frames[i], i == 0, history, bytes, statistics);
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 5), Bytes(5, 0xaa));
    EXPECT_EQ(Bytes(bytes.begin() + 5, bytes.end()), sent.bytes[i]);
    EXPECT_EQ(statistics.frame_number, i + 1);
    EXPECT_EQ(statistics.bytes, sent.bytes[i].size());
    EXPECT_EQ(statistics.header_bytes, i == 0 ? 75u : 11u);
    EXPECT_EQ(statistics.header_bytes + statistics.occupancy_bytes +
                  statistics.intensity_bytes,
              statistics.bytes);
    // Each row of symbols has its count and table.
    EXPECT_GT(statistics.occupancy_bytes, 1036u);
    EXPECT_GT(statistics.intensity_bytes, 1036u + sent.frames[i].size() / 4);
  }
}

// ------------------------------------------------- frames that fail

void
expectSameHistory(const PublishedHistory& history, const PublishedHistory& expected)
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

TEST(PublishedHistory, IsLeftAloneByAFrameThatMemoryIsTooSmallToEncode)
{
  const Stream sent = stream(3);
  PublishedHistory history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    const PublishedHistory before = history;
    Bytes bytes;
    std::size_t failures = 0;
    for (bool is_done = false; !is_done;) {
      bytes = Bytes(); // without memory of its own
      CodedFrameStatistics statistics;
      try {
        allocations_left = failures;
        encodePublished(sent.frames[i], i == 0, history, bytes, statistics);
        is_done = true;
      }
      catch (const std::bad_alloc&) {
        ++failures;
      }
      allocations_left = never;
      if (!is_done)
        expectSameHistory(history, before);
    }
    EXPECT_GT(failures, 10u);
    EXPECT_EQ(bytes, sent.bytes[i]);
  }
}

TEST(PublishedHistory, IsLeftAloneByAFrameThatMemoryIsTooSmallToDecode)
{
  const Stream sent = stream(3);
  PublishedHistory history;
  for (std::size_t i = 0; i < sent.frames.size(); ++i) {
    const PublishedHistory before = history;
    VoxelFrame back;
    std::size_t failures = 0;
    for (bool is_done = false; !is_done;) {
      MemoryBuffer buffer(sent.bytes[i].data() + published_magic_size,
                          sent.bytes[i].size() - published_magic_size);
      ByteSource source(buffer, sent.bytes[i].size());
      back = VoxelFrame();
      CodedFrameStatistics statistics;
      CompressionStatus status;
      try {
        allocations_left = failures;
        status = decodePublished(source, DecoderLimits(), history, back, statistics);
        is_done = true;
      }
      catch (const std::bad_alloc&) {
        ++failures;
      }
      allocations_left = never;
      if (is_done)
        EXPECT_TRUE(status.ok()) << status.message();
      else
        expectSameHistory(history, before);
    }
    EXPECT_GT(failures, 10u);
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
    throw std::runtime_error("the cable is out");
  }
};

TEST(PublishedHistory, IsLeftAloneByASourceThatThrows)
{
  Stream sent = stream(3);
  PublishedHistory history;
  for (Bytes& bytes : sent.bytes) {
    Bytes frame(bytes.begin() + published_magic_size, bytes.end());
    const PublishedHistory before = history;
    VoxelFrame back;
    CodedFrameStatistics statistics;
    for (std::size_t size = 0; size < frame.size(); ++size) {
      BrokenBuffer broken(frame, size);
      ByteSource source(broken, frame.size());
      EXPECT_THROW(decodePublished(source, DecoderLimits(), history, back, statistics),
                   std::runtime_error);
      expectSameHistory(history, before);
    }
    BrokenBuffer whole(frame, frame.size());
    ByteSource source(whole, frame.size());
    ASSERT_TRUE(
        decodePublished(source, DecoderLimits(), history, back, statistics).ok());
  }
}

} // namespace

#include "codec/fast/classed_row.h"
#include "codec/fast/coder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <thread>
#include <vector>

namespace {

using pcl_ext::io::fast::ClassedRow;
using pcl_ext::io::fast::FrameCoder;
using pcl_ext::io::fast::Workspace;

struct Frame {
  std::vector<std::uint64_t> keys;
  std::vector<std::uint16_t> symbols;
};

using Bytes = std::vector<std::uint8_t>;

/** \brief Memory that all coders of a thread take turns with. */
Workspace&
work()
{
  thread_local Workspace workspace;
  return workspace;
}

Bytes
encoded(FrameCoder& encoder,
        const Frame& frame,
        bool is_i_frame,
        unsigned int bits,
        unsigned int depth)
{
  Bytes payload;
  encoder.encode(work(), is_i_frame, frame.keys, frame.symbols, bits, depth, payload);
  return payload;
}

bool
decoded(FrameCoder& decoder,
        const Bytes& payload,
        bool is_i_frame,
        std::size_t count,
        unsigned int bits,
        unsigned int depth,
        Frame& frame)
{
  const bool is_good = decoder.decode(work(),
                                      payload.data(),
                                      payload.data() + payload.size(),
                                      is_i_frame,
                                      count,
                                      bits,
                                      depth,
                                      frame.keys,
                                      frame.symbols);
  if (is_good)
    decoder.learn();
  return is_good;
}

/** \brief Both ends of a stream. */
struct Stream {
  FrameCoder encoder;
  FrameCoder decoder;

  /** \brief Sends a frame through. \return bytes of its payload */
  std::size_t
  send(const Frame& frame, bool is_i_frame, unsigned int bits, unsigned int depth)
  {
    const Bytes payload = encoded(encoder, frame, is_i_frame, bits, depth);
    Frame back;
    EXPECT_TRUE(
        decoded(decoder, payload, is_i_frame, frame.keys.size(), bits, depth, back));
    EXPECT_EQ(back.keys, frame.keys);
    EXPECT_EQ(back.symbols, frame.symbols);
    return payload.size();
  }
};

class Random {
public:
  explicit Random(unsigned int seed) : engine_(seed) {}

  /** \brief A number below `end`. */
  std::uint64_t
  below(std::uint64_t end)
  {
    return std::uniform_int_distribution<std::uint64_t>(0, end - 1)(engine_);
  }

  /** \brief A random frame: places and symbols anywhere. */
  Frame
  frame(std::size_t count, unsigned int bits, unsigned int depth)
  {
    Frame frame;
    const std::uint64_t keys = std::uint64_t{1} << (3 * depth);
    for (std::size_t i = 0; i < count; ++i)
      frame.keys.push_back(below(keys));
    std::sort(frame.keys.begin(), frame.keys.end());
    frame.keys.erase(std::unique(frame.keys.begin(), frame.keys.end()),
                     frame.keys.end());
    for (std::size_t i = 0; i < frame.keys.size(); ++i)
      frame.symbols.push_back(static_cast<std::uint16_t>(below(1u << bits)));
    return frame;
  }

  /** \brief A frame like that of a sensor: of a fixed scene each voxel is seen with a
   * probability of its own, with counts around a mean of its own, and there is noise. */
  Frame
  sensorFrame(std::size_t voxels, unsigned int depth, unsigned int highest)
  {
    Frame frame;
    const std::uint64_t keys = std::uint64_t{1} << (3 * depth);
    for (std::uint64_t i = 0; i < voxels; ++i) {
      const std::uint64_t key = i * 0x9e3779b1 % keys;
      if (below(16) <= i % 16)
        frame.keys.push_back(key);
      if (below(20) == 0)
        frame.keys.push_back(below(keys));
    }
    std::sort(frame.keys.begin(), frame.keys.end());
    frame.keys.erase(std::unique(frame.keys.begin(), frame.keys.end()),
                     frame.keys.end());
    for (const std::uint64_t key : frame.keys) {
      const auto mean = key % 7 == 0 ? highest : 1 + key % 5;
      frame.symbols.push_back(static_cast<std::uint16_t>(
          std::min<std::uint64_t>(mean + below(3), highest)));
    }
    return frame;
  }

private:
  std::mt19937 engine_;
};

TEST(FrameCoder, RandomFramesComeBack)
{
  Random random(1);
  for (const unsigned int depth : {1u, 2u, 3u, 5u, 13u, 21u})
    for (const unsigned int bits : {1u, 2u, 4u, 5u, 8u, 13u, 16u}) {
      Stream stream;
      for (int i = 0; i < 6; ++i) {
        const std::size_t most = i % 3 == 0 ? 1 : i % 3 == 1 ? 300 : 3000;
        stream.send(random.frame(most, bits, depth), i % 4 == 0, bits, depth);
      }
    }
}

TEST(FrameCoder, StreamsOfASensorComeBack)
{
  Random random(2);
  for (const unsigned int highest : {5u, 255u, 65535u}) {
    const unsigned int bits = highest > 255 ? 16 : 8;
    Stream stream;
    for (int i = 0; i < 70; ++i)
      stream.send(random.sensorFrame(2000, 6, highest), i % 32 == 0, bits, 6);
  }
}

TEST(FrameCoder, StreamsOfSeveralThreadsComeBack)
{
  std::vector<std::thread> threads;
  for (unsigned int seed = 1; seed <= 4; ++seed)
    threads.emplace_back([seed] {
      Random random(seed);
      // Of different sizes, in turn, as they use the same memory.
      std::array<Stream, 2> streams;
      for (int i = 0; i < 12; ++i) {
        streams[0].send(random.sensorFrame(2000, 6, 40), i % 5 == 0, 8, 6);
        streams[1].send(random.sensorFrame(120, 7, 200), i % 4 == 0, 8, 7);
      }
    });
  for (std::thread& thread : threads)
    thread.join();
}

TEST(FrameCoder, WholeBlocksComeBack)
{
  for (const unsigned int depth : {1u, 2u, 4u}) {
    Stream stream;
    Frame full;
    for (std::uint64_t key = 0; key < std::uint64_t{1} << (3 * depth); ++key) {
      full.keys.push_back(key);
      full.symbols.push_back(static_cast<std::uint16_t>(key % 256));
    }
    const Frame single{{full.keys.back()}, {255}};
    stream.send(full, true, 8, depth);
    stream.send(single, false, 8, depth);
    stream.send(full, false, 8, depth);
    for (int i = 0; i < 12; ++i)
      stream.send(single, false, 8, depth);
    stream.send(full, false, 8, depth);
    stream.send(single, true, 8, depth);
    stream.send(full, false, 8, depth);
  }
}

TEST(FrameCoder, ForgottenBlocksMakeRoomForOthers)
{
  Random random(3);
  Stream stream;
  for (int i = 0; i < 60; ++i) {
    // Something that moves along and never comes back.
    Frame frame = random.frame(400, 8, 3);
    for (std::uint64_t& key : frame.keys)
      key += static_cast<std::uint64_t>(i) << 9;
    stream.send(frame, i == 0, 8, 8);
  }
}

TEST(FrameCoder, KnowsWhatItHasSeenLately)
{
  Random random(9);
  Stream stream;
  const Frame frame = random.frame(300, 8, 4);
  EXPECT_EQ(stream.encoder.knownVoxels(work(), frame.keys), 0u);
  stream.send(frame, true, 8, 4);
  EXPECT_EQ(stream.encoder.knownVoxels(work(), frame.keys), frame.keys.size());
  EXPECT_EQ(stream.encoder.recordCount(), frame.keys.size());
  EXPECT_EQ(stream.decoder.recordCount(), frame.keys.size());
  const Frame single{{frame.keys[7]}, {1}};
  for (int i = 0; i < 6; ++i)
    stream.send(single, false, 8, 4);
  EXPECT_EQ(stream.encoder.knownVoxels(work(), frame.keys), 1u);
  EXPECT_EQ(stream.decoder.recordCount(), 1u);
}

TEST(FrameCoder, SmallFramesAreSmall)
{
  Random random(4);
  Stream stream;
  const Frame scene = random.frame(52, 1, 7);
  std::size_t bytes = 0;
  for (int i = 0; i < 30; ++i) {
    Frame frame;
    for (const std::uint64_t key : scene.keys)
      if (random.below(10) != 0) {
        frame.keys.push_back(key);
        frame.symbols.push_back(static_cast<std::uint16_t>(1 + random.below(4) / 3));
      }
    bytes = stream.send(frame, i == 0, 8, 7);
  }
  EXPECT_LE(bytes, 60u);
}

TEST(FrameCoder, ADiscardedFrameHasNotBeen)
{
  Random random(5);
  Stream stream;
  for (int i = 0; i < 12; ++i) {
    const bool is_i_frame = i % 6 == 0;
    const Frame frame = random.sensorFrame(500, 5, 255);
    const Bytes payload = encoded(stream.encoder, frame, is_i_frame, 8, 5);
    for (int times = 0; times < 3; ++times) {
      Frame back;
      ASSERT_TRUE(stream.decoder.decode(work(),
                                        payload.data(),
                                        payload.data() + payload.size(),
                                        is_i_frame,
                                        frame.keys.size(),
                                        8,
                                        5,
                                        back.keys,
                                        back.symbols));
      ASSERT_EQ(back.keys, frame.keys);
      ASSERT_EQ(back.symbols, frame.symbols);
      if (times < 2)
        stream.decoder.discard();
      else
        stream.decoder.learn();
    }
  }
}

/** \brief A stream up to the frame that a test changes. */
struct ChangedFrame : testing::TestWithParam<int> {
  static constexpr unsigned int bits = 9;
  static constexpr unsigned int depth = 4;

  Random random{6};
  Stream stream; // the decoder is one frame behind
  std::vector<Frame> frames_before;
  Frame frame;
  Bytes whole; // its payload
  bool is_i_frame = GetParam() == 0;

  ChangedFrame()
  {
    for (int i = 0; i < GetParam(); ++i) {
      frames_before.push_back(random.sensorFrame(120, depth, 300));
      stream.send(frames_before.back(), i == 0, bits, depth);
    }
    frame = random.sensorFrame(120, depth, 300);
    whole = encoded(stream.encoder, frame, is_i_frame, bits, depth);
  }

  /** \brief Decodes without learning the frame. */
  bool
  tried(const Bytes& payload, std::size_t count, Frame& back)
  {
    const bool is_good = stream.decoder.decode(work(),
                                               payload.data(),
                                               payload.data() + payload.size(),
                                               is_i_frame,
                                               count,
                                               bits,
                                               depth,
                                               back.keys,
                                               back.symbols);
    if (is_good)
      stream.decoder.discard();
    return is_good;
  }

  /** \brief Decodes changed bytes: they fail, or are a frame that is coded just so; the
   * frame that they were made of still comes back.
   * \return whether they fail
   */
  bool
  refuses(const Bytes& payload, std::size_t count)
  {
    Frame back;
    const bool is_refused = !tried(payload, count, back);
    if (!is_refused) {
      FrameCoder encoder;
      for (std::size_t i = 0; i < frames_before.size(); ++i)
        encoded(encoder, frames_before[i], i == 0, bits, depth);
      EXPECT_EQ(encoded(encoder, back, is_i_frame, bits, depth), payload);
    }
    EXPECT_TRUE(tried(whole, frame.keys.size(), back));
    EXPECT_EQ(back.keys, frame.keys);
    EXPECT_EQ(back.symbols, frame.symbols);
    return is_refused;
  }

  /** \brief Whatever was tried, the stream goes on. */
  void
  TearDown() override
  {
    Frame back;
    ASSERT_TRUE(decoded(
        stream.decoder, whole, is_i_frame, frame.keys.size(), bits, depth, back));
    for (int i = 0; i < 3; ++i)
      stream.send(random.sensorFrame(120, depth, 300), false, bits, depth);
  }
};

TEST_P(ChangedFrame, TruncatedIsRefused)
{
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_TRUE(
        refuses(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)),
                frame.keys.size()))
        << size << " bytes";
}

TEST_P(ChangedFrame, FlippedIsRefusedOrExact)
{
  std::size_t refused = 0;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    Bytes flipped = whole;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ 1u << bit % 8);
    refused += refuses(flipped, frame.keys.size());
  }
  // A coder's last state tells most of what is wrong, but is no checksum.
  EXPECT_GT(refused, 8 * whole.size() * 9 / 10);
}

TEST_P(ChangedFrame, AnyBytesAreRefused)
{
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(random.below(200));
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random.below(256));
    EXPECT_TRUE(refuses(bytes, 1 + random.below(100)));
  }
}

TEST_P(ChangedFrame, OtherVoxelCountIsRefused)
{
  const std::size_t count = frame.keys.size();
  for (const std::size_t other : {count - 1, count + 1, count * 2, std::size_t{1}})
    EXPECT_TRUE(refuses(whole, other)) << other << " voxels instead of " << count;
}

INSTANTIATE_TEST_SUITE_P(FrameCoder, ChangedFrame, testing::Values(0, 1, 9));

TEST(ClassedRow, RowsComeBack)
{
  Random random(7);
  ClassedRow encoder;
  ClassedRow decoder;
  for (const std::size_t count : {0u, 1u, 50u, 5000u}) {
    std::vector<std::uint16_t> numbers(count);
    std::vector<std::uint8_t> classes(count);
    for (std::size_t i = 0; i < count; ++i) {
      classes[i] = static_cast<std::uint8_t>(random.below(16));
      numbers[i] = static_cast<std::uint16_t>(
          random.below(40) == 0 ? random.below(0x10000) : random.below(1 + classes[i]));
    }
    Bytes bytes;
    encoder.encode(count == 0, numbers, classes, bytes);
    std::vector<std::uint16_t> back;
    const std::uint8_t* const end = bytes.data() + bytes.size();
    EXPECT_FALSE(decoder.decode(bytes.data(), end - 1, count == 0, classes, back));
    ASSERT_TRUE(decoder.decode(bytes.data(), end, count == 0, classes, back));
    decoder.learn();
    EXPECT_EQ(back, numbers);
  }
}

TEST(ClassedRow, HasFourStatesFrom1024NumbersOn)
{
  const auto size = [](std::size_t count) {
    ClassedRow encoder;
    Bytes bytes;
    encoder.encode(true,
                   std::vector<std::uint16_t>(count),
                   std::vector<std::uint8_t>(count),
                   bytes);
    return bytes.size();
  };
  EXPECT_GE(size(1024), size(1023) + 8);
}

TEST(ClassedRow, CostsAboutItsEntropy)
{
  Random random(8);
  ClassedRow encoder;
  const std::size_t count = 20000;
  std::vector<std::uint16_t> numbers(count);
  const std::vector<std::uint8_t> classes(count, 3);
  for (std::uint16_t& number : numbers)
    number = static_cast<std::uint16_t>(random.below(4) == 0 ? 1 : 0);
  Bytes bytes;
  encoder.encode(true, numbers, classes, bytes);
  // The entropy of a quarter is 0.811 bits.
  EXPECT_LT(static_cast<double>(bytes.size()) * 8 / count, 0.83);
}

} // namespace

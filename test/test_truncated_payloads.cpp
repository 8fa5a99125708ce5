/** \file
 * \brief Payloads that end too soon are not read behind their end.
 */
#include "fenced_memory.h"
#include "forged_frames.h"
#include "voxel_streams.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief Decodes the last of a stream's frames with less and less of its payload. */
void
expectTruncationsRefused(const std::vector<Bytes>& stream)
{
  Parts parts = takeApart(stream.back());
  const std::uint32_t reference =
      parts.header.is_i_frame ? 0 : takeApart(stream[stream.size() - 2]).checksum;
  const std::size_t size = parts.payload.size();
  // At some hundred places: what follows of the bytes is another frame at each.
  const std::size_t step = 1 + size / 300;
  for (std::size_t end = size - 1; end < size; end -= step) {
    parts.payload.resize(end);
    const Bytes bytes = putTogetherSized(parts, reference);
    FrameDecoder decoder;
    VoxelFrame back;
    for (std::size_t i = 0; i + 1 < stream.size(); ++i)
      ASSERT_EQ(decoded(decoder, stream[i], back), CompressionCode::Ok);
    fenced_memory.is_wanted = true;
    const CompressionCode answer = decoded(decoder, bytes, back);
    fenced_memory.is_wanted = false;
    // The context coder reads zeros behind the end, which may be what there was.
    if (parts.header.effort == Effort::Fast) {
      EXPECT_EQ(answer, CompressionCode::Corrupt);
    }
  }
}

/** \brief The frames of a stream of the effort fast. */
std::vector<Bytes>
fastStream(const std::vector<VoxelFrame>& frames)
{
  FrameEncoder encoder(StreamFormat::Version1, 1000, Effort::Fast);
  std::vector<Bytes> stream;
  for (const VoxelFrame& frame : frames)
    stream.push_back(encoded(encoder, frame));
  return stream;
}

VoxelFrame
fullFrame(std::mt19937_64& random,
          unsigned int depth,
          unsigned int bits,
          std::uint64_t end)
{
  VoxelFrame frame = emptyFrame(depth, bits);
  for (std::uint64_t key = 0; key < std::uint64_t{1} << (3 * depth); ++key) {
    frame.keys.push_back(key);
    frame.intensities.push_back(static_cast<std::uint16_t>(below(random, end)));
  }
  return frame;
}

TEST(TruncatedPayloads, NewSymbols)
{
  std::mt19937_64 random(1);
  for (const std::uint64_t end : {2u, 8u, 12u})
    expectTruncationsRefused(fastStream({fullFrame(random, 4, 8, end)}));
}

TEST(TruncatedPayloads, PlainSymbols)
{
  std::mt19937_64 random(2);
  for (const unsigned int bits : {8u, 16u})
    expectTruncationsRefused(
        fastStream({fullFrame(random, 4, bits, std::uint64_t{1} << bits)}));
}

TEST(TruncatedPayloads, KnownSymbols)
{
  std::mt19937_64 random(3);
  for (const std::uint64_t end : {2u, 5u, 9u, 60u}) {
    std::vector<VoxelFrame> frames;
    for (int i = 0; i < 3; ++i)
      frames.push_back(fullFrame(random, 4, 8, end));
    expectTruncationsRefused(fastStream(frames));
  }
}

TEST(TruncatedPayloads, NewVoxels)
{
  std::mt19937_64 random(4);
  for (const std::uint64_t share : {2u, 16u, 256u}) {
    std::vector<VoxelFrame> frames;
    for (int i = 0; i < 4; ++i) {
      std::set<std::uint64_t> keys;
      // Half of the blocks are known, and in each some voxels.
      for (std::uint64_t key = 0; key < 16384; ++key)
        if (below(random, share) == 0 && (key / 64 % 2 == 0 || i == 3))
          keys.insert(key);
      frames.push_back(emptyFrame(7));
      setVoxels(random, keys, frames.back());
      for (std::uint16_t& symbol : frames.back().intensities)
        symbol = 1;
    }
    expectTruncationsRefused(fastStream(frames));
    expectTruncationsRefused(fastStream({frames.back()}));
  }
}

TEST(TruncatedPayloads, Rests)
{
  RoomStream::Settings settings;
  settings.depth_model = roomDepthModel(settings.depth, settings.bits);
  RoomStream room(settings);
  const VoxelFrame first = room.next();
  expectTruncationsRefused(fastStream({first}));
  expectTruncationsRefused(fastStream({first, room.next()}));
}

TEST(TruncatedPayloads, ContextCoder)
{
  for (const Effort effort : {Effort::Balanced, Effort::Small}) {
    RoomStream::Settings settings;
    settings.width = 20;
    RoomStream room(settings);
    FrameEncoder encoder(StreamFormat::Version1, 1000, effort);
    std::vector<Bytes> stream;
    for (int i = 0; i < 2; ++i) {
      stream.push_back(encoded(encoder, room.next()));
      expectTruncationsRefused(stream);
    }
  }
}

} // namespace

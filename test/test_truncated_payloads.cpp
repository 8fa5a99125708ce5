/** \file
 * \brief Payloads that end too soon are not read behind their end.
 */
#include "fenced_memory.h"
#include "scripted_fast_stream.h"
#include "voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <random>
#include <set>
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

/** \brief An I-frame of a number of blocks, each with its cell 0. */
ScriptedStream
streamOfBlocks(unsigned int root, std::size_t block_count)
{
  return ScriptedStream(6, 8, block_count, [=](FastScript& script) {
    script.code(script.models.has_new_blocks, 1);
    script.byte(script.models.node[3], 0, root);
    for (const std::size_t blocks_in_node : {64u, 8u, 1u})
      for (std::size_t i = 0; i < block_count / blocks_in_node / 8; ++i)
        script.byte(script.models.node[blocks_in_node == 64  ? 2
                                       : blocks_in_node == 8 ? 1
                                                             : 0],
                    0,
                    255);
    for (std::size_t i = 0; i < block_count; ++i)
      script.newBlock(true, 1);
    script.plainSymbols(block_count, 1);
  });
}

/** \brief Refuses a script's frame with less and less of its payload.
 *
 * Behind the end zeros are read, so that a symbol behind a word of them is the lowest of
 * its model. Where the low nibble of a byte is always 15, which takes hardly a word, and
 * the high one anything, in states of its own, what is read goes on being good.
 */
void
expectScriptRefused(const ScriptedStream& stream,
                    unsigned int depth,
                    bool is_i_frame,
                    const Choices& choices)
{
  const std::size_t count = std::size_t{1} << std::min(3 * depth, 20u);
  FastScript script(is_i_frame ? FastModels() : stream.models());
  choices(script);
  RansChoices four;
  four.states = 4;
  const Bytes whole = script.rans(four).bytes;
  ASSERT_GT(whole.size(), 500u);
  for (std::ptrdiff_t size = 100; size < 500; size += 2) {
    const Bytes payload(whole.begin(), whole.begin() + size);
    const Bytes bytes = is_i_frame ? stream.otherIFrame(depth, 16, count, payload)
                                   : stream.frame(false, count, payload);
    FrameDecoder decoder;
    VoxelFrame back;
    if (!is_i_frame) {
      ASSERT_EQ(decoded(decoder, stream.iFrame(), back), CompressionCode::Ok);
    }
    fenced_memory.is_wanted = true;
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Corrupt);
    fenced_memory.is_wanted = false;
  }
}

/** \brief A byte that goes on being good. */
unsigned int
goodByte(std::mt19937_64& random)
{
  return static_cast<unsigned int>(below(random, 16) << 4) | 15;
}

TEST(TruncatedPayloads, MasksOfSeveral)
{
  constexpr std::size_t blocks = 2048;
  const ScriptedStream stream = streamOfBlocks(15, blocks);
  std::mt19937_64 random(5);
  const auto knownBlocks = [](FastScript& script, unsigned int symbol) {
    for (std::size_t i = 0; i < blocks / 8; ++i)
      script.knownVoxels(3, 8, 255);
    for (std::size_t i = 0; i < blocks; ++i)
      script.octants(false, symbol);
  };
  expectScriptRefused(stream, 6, false, [&](FastScript& script) {
    knownBlocks(script, 9);
    for (std::size_t i = 0; i < blocks; ++i)
      script.byte(script.models.octants, 0, goodByte(random));
  });
  expectScriptRefused(stream, 6, false, [&](FastScript& script) {
    knownBlocks(script, 8); // the farthest octant, whose cells are all open
    for (std::size_t i = 0; i < blocks; ++i)
      script.cells(0, 8, 8);
    for (std::size_t i = 0; i < blocks; ++i)
      script.byte(script.models.cells, 0, goodByte(random));
  });
}

TEST(TruncatedPayloads, NewBlocks)
{
  const ScriptedStream stream = streamOfBlocks(3, 1024);
  std::mt19937_64 random(6);
  // Nodes of a deep grid, and cells of many blocks. What comes first has one state less
  // than a byte, so that the high nibbles have states of their own.
  expectScriptRefused(stream, 20, true, [&](FastScript& script) {
    script.code(script.models.has_new_blocks, 1);
    for (std::size_t i = 0; i < 2000; ++i)
      script.byte(script.models.node[3], 0, goodByte(random));
  });
  expectScriptRefused(stream, 6, true, [&](FastScript& script) {
    script.code(script.models.has_new_blocks, 1);
    for (const unsigned int level : {3u, 2u, 1u, 0u})
      for (std::size_t i = 0; i < std::size_t{1} << 3 * (3 - level); ++i)
        script.byte(script.models.node[level], 0, 255);
    for (std::size_t i = 0; i < 512; ++i) {
      std::uint64_t voxels = 0;
      for (unsigned int octant = 0; octant < 8; ++octant)
        voxels |= std::uint64_t{goodByte(random)} << 8 * octant;
      script.newBlock(true, goodByte(random), voxels);
    }
  });
}

TEST(TruncatedPayloads, NewSymbols)
{
  // All voxels of a grid, of which the payload has the first symbols.
  constexpr unsigned int depth = 4;
  const ScriptedStream stream = streamOfBlocks(3, 1024);
  std::mt19937_64 random(7);
  const auto expectSymbolsRefused = [&](const Choices& symbols) {
    expectScriptRefused(stream, depth, true, [&](FastScript& script) {
      writeFullGrid(script, depth);
      symbols(script);
    });
  };
  expectSymbolsRefused([&](FastScript& script) {
    script.bits(1, 1);
    for (int i = 0; i < 400; ++i) {
      script.byte(
          script.models.plain, 0, static_cast<unsigned int>(below(random, 256)));
      script.bits(8, static_cast<unsigned int>(below(random, 256)));
    }
  });
}

TEST(TruncatedPayloads, NewSymbolsAsThoseOfEarlierFrames)
{
  // A scene that stays, and each frame a new block with any of some steps: short frames
  // teach what is wanted. The last frame has a cube of new blocks.
  constexpr std::uint64_t staying = 1408;
  constexpr std::uint64_t cube = 4096;
  std::mt19937_64 random(8);
  std::vector<VoxelFrame> frames;
  for (std::uint64_t i = 0; i <= 150; ++i) {
    frames.push_back(emptyFrame(7));
    VoxelFrame& frame = frames.back();
    for (std::uint64_t key = 0; key < staying; ++key)
      frame.keys.push_back(key);
    frame.intensities.assign(frame.size(), 0);
    const std::uint64_t first = i < 150 ? cube + 64 * i : 8 * cube;
    for (std::uint64_t k = 0; k < (i < 150 ? 64 : cube); ++k) {
      frame.keys.push_back(first + k);
      frame.intensities.push_back(static_cast<std::uint16_t>(below(random, 8)));
    }
  }
  const std::vector<Bytes> stream = fastStream(frames);
  Parts parts = takeApart(stream.back());
  ASSERT_FALSE(parts.header.is_i_frame);
  const std::uint32_t reference = takeApart(stream[stream.size() - 2]).checksum;
  const Bytes whole = parts.payload;
  ASSERT_GT(whole.size(), 1000u);
  fenced_memory.is_wanted = true;
  FrameDecoder decoder;
  VoxelFrame back;
  for (std::size_t i = 0; i + 1 < stream.size(); ++i)
    ASSERT_EQ(decoded(decoder, stream[i], back), CompressionCode::Ok);
  // The shortest first: memory stays as large as it was.
  for (std::ptrdiff_t size = 16; size < 300; size += 2) {
    parts.payload.assign(whole.begin(), whole.begin() + size);
    EXPECT_EQ(decoded(decoder, putTogetherSized(parts, reference), back),
              CompressionCode::Corrupt);
  }
  fenced_memory.is_wanted = false;
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

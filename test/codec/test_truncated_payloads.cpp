/** \file
 * \brief Payloads that end too soon are not read behind their end.
 */
#include "support/scripted_fast_stream.h"
#include "support/test_memory.h"
#include "support/voxel_streams.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::FencedMemory;

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
    const FencedMemory fences;
    const CompressionCode answer = decoded(decoder, bytes, back);
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

/** \brief Voxels of a header, more than any payload here has. */
constexpr std::size_t many = std::size_t{1} << 20;

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
                    std::size_t count,
                    const Choices& choices)
{
  FastScript script(is_i_frame ? fast::Models() : stream.models());
  choices(script);
  RansChoices states;
  states.states = count < 1024 ? 1 : 4;
  const Bytes whole = script.rans(states).bytes;
  ASSERT_GT(whole.size(), 600u);
  for (std::size_t size = 20; size < 600; size += 2) {
    const Bytes payload = prefixOf(whole, size);
    const Bytes bytes = is_i_frame ? stream.otherIFrame(depth, 16, count, payload)
                                   : stream.frame(false, count, payload);
    const FencedMemory fences;
    FrameDecoder decoder;
    VoxelFrame back;
    if (!is_i_frame) {
      ASSERT_EQ(decoded(decoder, stream.iFrame(), back), CompressionCode::Ok);
    }
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Corrupt);
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
  expectScriptRefused(stream, 6, false, many, [&](FastScript& script) {
    knownBlocks(script, 9);
    for (std::size_t i = 0; i < blocks; ++i)
      script.byte(script.models.octants, 0, goodByte(random));
  });
  expectScriptRefused(stream, 6, false, many, [&](FastScript& script) {
    knownBlocks(script, 8); // the farthest octant, whose cells are all open
    for (std::size_t i = 0; i < blocks; ++i)
      script.cells(0, 8, 8);
    for (std::size_t i = 0; i < blocks; ++i)
      script.byte(script.models.cells, 0, goodByte(random));
  });
}

TEST(TruncatedPayloads, NewNodes)
{
  // Nodes of a deep grid.
  const ScriptedStream stream = streamOfBlocks(3, 1024);
  std::mt19937_64 random(6);
  expectScriptRefused(stream, 20, true, many, [&](FastScript& script) {
    script.code(script.models.has_new_blocks, 1);
    for (std::size_t i = 0; i < 2000; ++i)
      script.byte(script.models.node[3], 0, goodByte(random));
  });
}

TEST(TruncatedPayloads, NewSymbols)
{
  // All voxels of a grid, of which the payload has the first symbols.
  constexpr unsigned int depth = 4;
  const ScriptedStream stream = streamOfBlocks(3, 1024);
  std::mt19937_64 random(7);
  const auto expectSymbolsRefused = [&](const Choices& symbols) {
    expectScriptRefused(
        stream, depth, true, std::size_t{1} << 3 * depth, [&](FastScript& script) {
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

/** \brief An I-frame of all voxels of a grid, each with one step that has no
 * bits. */
ScriptedStream
streamOfFullGrid(unsigned int bits, unsigned int step)
{
  return ScriptedStream(4, bits, 4096, [=](FastScript& script) {
    writeFullGrid(script, 4);
    script.beginSteps(0);
    script.newStep(0); // a symbol is 0
    for (int i = 1; i < 4096; ++i)
      script.newStepOrWhole(step);
  });
}

TEST(TruncatedPayloads, KnownVoxelsAndSteps)
{
  std::mt19937_64 random(9);
  // A single state reads them if the header says that there are few; there are half of
  // those that are written.
  for (const std::size_t count : {1000u, 4096u})
    expectScriptRefused(
        streamOfFullGrid(8, 0), 4, false, count, [&](FastScript& script) {
          for (int i = 0; i < 1024; ++i)
            script.knownVoxels(3, 8, random());
        });
  const auto knownVoxels = [](FastScript& script) {
    for (int i = 0; i < 512; ++i)
      script.knownVoxels(3, 8, 255);
    for (int i = 0; i < 64; ++i)
      script.octants(false, 0);
    script.noNewBlocks();
    script.beginSteps(0);
  };
  // Quads, of any four, and of which all are escapes.
  expectScriptRefused(streamOfFullGrid(8, 0), 4, false, 4096, [&](FastScript& script) {
    knownVoxels(script);
    for (int i = 0; i < 1024; ++i)
      script.code(script.models.quad[0], static_cast<unsigned int>(below(random, 256)));
  });
  expectScriptRefused(streamOfFullGrid(8, 0), 4, false, 4096, [&](FastScript& script) {
    knownVoxels(script);
    for (int i = 0; i < 1024; ++i)
      script.code(script.models.quad[0], 255);
    for (int i = 0; i < 4096; ++i)
      script.code(script.models.quad_escape[0],
                  static_cast<unsigned int>(below(random, 12)));
  });
  // Highest symbols of all, and behind them such that have a step below all nibbles'.
  expectScriptRefused(streamOfFullGrid(5, 24), 4, false, 4096, [&](FastScript& script) {
    knownVoxels(script);
    for (int i = 1; i < 4096; ++i)
      script.knownStep(24, 15);
    script.knownStep(0, 0);
    for (int i = 1; i < 4096; ++i)
      script.wholeStep(static_cast<unsigned int>(below(random, 16)));
  });
}

/** \brief A scene that stays, and new blocks: one in each frame but the last, so that
 * short frames teach what the last one, of many, needs.
 * \param[in] block makes the cells of a block
 * \param[in] steps_end behind the symbols of new voxels
 */
void
expectRefusedBehindShortFrames(std::mt19937_64& random,
                               const std::function<std::uint64_t()>& block,
                               std::uint64_t steps_end)
{
  constexpr std::uint64_t staying = 1408;
  constexpr std::uint64_t cube = 4096;
  constexpr std::uint64_t short_frames = 600;
  std::vector<VoxelFrame> frames;
  for (std::uint64_t i = 0; i <= short_frames; ++i) {
    frames.push_back(emptyFrame(7));
    VoxelFrame& frame = frames.back();
    for (std::uint64_t key = 0; key < staying; ++key)
      frame.keys.push_back(key);
    frame.intensities.assign(frame.size(), 0);
    const bool is_last = i == short_frames;
    const std::uint64_t first = is_last ? 32 * cube : cube + 64 * i;
    for (std::uint64_t key = first; key < first + (is_last ? cube : 64); key += 64)
      for (std::uint64_t cells = block(); cells != 0; cells &= cells - 1) {
        frame.keys.push_back(key + pcl_ext::lowestBit(cells));
        frame.intensities.push_back(
            static_cast<std::uint16_t>(below(random, steps_end)));
      }
  }
  const std::vector<Bytes> stream = fastStream(frames);
  Parts parts = takeApart(stream.back());
  ASSERT_FALSE(parts.header.is_i_frame);
  const std::uint32_t reference = takeApart(stream[stream.size() - 2]).checksum;
  const Bytes whole = parts.payload;
  ASSERT_GT(whole.size(), 250u);
  const FencedMemory fences;
  FrameDecoder decoder;
  VoxelFrame back;
  for (std::size_t i = 0; i + 1 < stream.size(); ++i)
    ASSERT_EQ(decoded(decoder, stream[i], back), CompressionCode::Ok);
  // The shortest first: memory stays as large as it was.
  for (std::size_t size = 16; size < 250; size += 2) {
    parts.payload = prefixOf(whole, size);
    EXPECT_EQ(decoded(decoder, putTogetherSized(parts, reference), back),
              CompressionCode::Corrupt);
  }
}

TEST(TruncatedPayloads, BehindShortFrames)
{
  std::mt19937_64 random(8);
  expectRefusedBehindShortFrames(
      random, [] { return ~std::uint64_t{0}; }, 8);
  // Masks of octants and of cells with any low nibble, each with a high one of 15: none
  // is 0.
  const auto block = [&] {
    std::uint64_t cells = random() | 0xf0f0f0f0f0f0f0f0;
    for (std::uint64_t octant = 0; octant < 4; ++octant)
      if (below(random, 2) == 0)
        cells &= ~(std::uint64_t{0xff} << 8 * octant);
    return cells;
  };
  for (int round = 0; round < 2; ++round)
    expectRefusedBehindShortFrames(random, block, 1);
}

TEST(TruncatedPayloads, Residuals)
{
  RoomStream room(roomSettings(8, 60, true));
  const VoxelFrame first = room.next();
  expectTruncationsRefused(fastStream({first}));
  expectTruncationsRefused(fastStream({first, room.next()}));
}

TEST(TruncatedPayloads, ContextCoder)
{
  for (const Effort effort : {Effort::Balanced, Effort::Small}) {
    RoomStream room(roomSettings(8, 20));
    FrameEncoder encoder(StreamFormat::Version1, 1000, effort);
    std::vector<Bytes> stream;
    for (int i = 0; i < 2; ++i) {
      stream.push_back(encoded(encoder, room.next()));
      expectTruncationsRefused(stream);
    }
  }
}

} // namespace

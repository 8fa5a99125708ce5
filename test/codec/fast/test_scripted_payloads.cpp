#include "support/scripted_fast_stream.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::fast;
using namespace pcl_ext::io::test;

constexpr CompressionCode ok = CompressionCode::Ok;

TEST(ScriptedFastPayloads, NewVoxelsInKnownBlocks)
{
  // In block 2 first: bit 0 of the known voxels is cell 0, whose octant has the rank 0;
  // three open cells lie beside it.
  const auto frame = [](bool has_cell_0, const Choices& octants, std::size_t symbols) {
    return [=](FastScript& script) {
      script.knownVoxels(3, 10, has_cell_0 ? 0x3ff : 0x3fe);
      octants(script);
      script.noNewBlocks();
      script.plainSymbols(symbols, 5);
    };
  };
  // Without cell 0 it is octant 1, of cell 9, that has the rank 0, and octant 0 has no
  // near cells.
  const auto octantZero = [](unsigned int near, const Choices& cells) {
    return [=](FastScript& script) {
      script.octants(false, near == 0 ? 2 : 1);
      script.octants(false, 0);
      cells(script);
    };
  };
  const auto octantMask = [](unsigned int symbol, unsigned int mask) {
    return [=](FastScript& script) {
      script.octants(false, symbol);
      script.octants(false, 0);
      script.byte(script.models.octants, 0, mask);
      for (unsigned int octants = mask; octants != 0; octants &= octants - 1)
        script.cells(3, 7, 0);
    };
  };
  const auto oneCell = [&](unsigned int near, unsigned int symbol) {
    return octantZero(near, [=](FastScript& script) { script.cells(near, 7, symbol); });
  };
  const auto cellMask = [&](unsigned int near, unsigned int symbol, unsigned int mask) {
    return octantZero(near, [=](FastScript& script) {
      script.cells(near, 7, symbol);
      script.byte(script.models.cells, 0, mask);
    });
  };
  // Block 5 has no open cell in octant 3, whose rank is 0.
  const auto inFullOctant = [](unsigned int symbol) {
    return [=](FastScript& script) {
      script.octants(false, 0);
      script.octants(false, 1);
      script.cells(0, 0, symbol);
      if (symbol == 8)
        script.byte(script.models.cells, 0, 3);
    };
  };
  std::vector<ScriptedFrame> cases = {
      {"single", 11, frame(true, oneCell(3, 0), 11), ok},
      {"last open", 11, frame(true, oneCell(3, 6), 11), ok},
      {"last open, none near", 10, frame(false, oneCell(0, 6), 10), ok},
      {"behind the open ones", 10, frame(false, oneCell(0, 7), 10)},
      {"behind the near ones", 11, frame(true, oneCell(3, 7), 11)},
      {"several", 12, frame(true, cellMask(3, 8, 6), 12), ok},
      {"several, one empty", 11, frame(false, cellMask(0, 8, 6), 11), ok},
      {"several over an empty one", 11, frame(false, cellMask(0, 8, 3), 11)},
      {"several over an occupied one", 12, frame(true, cellMask(3, 8, 3), 12)},
      {"the same, counted once", 11, frame(true, cellMask(3, 8, 3), 11)},
      {"several that are one", 11, frame(true, cellMask(3, 8, 2), 11)},
      {"several that are none", 10, frame(true, cellMask(3, 8, 0), 10)},
      {"too few voxels", 11, frame(true, cellMask(3, 8, 6), 11)},
      {"too many voxels", 13, frame(true, cellMask(3, 8, 6), 13)},
      {"no open cell, single", 10, frame(true, inFullOctant(0), 10)},
      {"no open cell, single, counted", 11, frame(true, inFullOctant(0), 11)},
      {"no open cell, several", 12, frame(true, inFullOctant(8), 12)},
      {"two octants", 12, frame(true, octantMask(9, 3), 12), ok},
      {"several octants that are one", 11, frame(true, octantMask(9, 1), 11)},
      {"several octants that are none", 10, frame(true, octantMask(9, 0), 10)}};
  for (unsigned int symbol = 9; symbol < 16; ++symbol)
    cases.push_back({"cell symbol " + std::to_string(symbol),
                     12,
                     frame(true, cellMask(3, symbol, 6), 12)});
  for (unsigned int symbol = 10; symbol < 16; ++symbol)
    cases.push_back({"octant symbol " + std::to_string(symbol),
                     12,
                     frame(true, octantMask(symbol, 3), 12)});
  expectAnswers(streamOfTwoBlocks(), cases);
}

TEST(ScriptedFastPayloads, NewBlocks)
{
  const auto frame = [](const Choices& blocks, std::size_t symbols) {
    return [=](FastScript& script) {
      script.knownVoxels(3, 10, 0x3ff);
      script.octants(false, 0);
      script.octants(false, 0);
      script.code(script.models.has_new_blocks, 1);
      blocks(script);
      script.plainSymbols(symbols, 5);
    };
  };
  const auto block =
      [](unsigned int nodes, unsigned int octants, std::uint64_t voxels) {
        return [=](FastScript& script) {
          script.byte(script.models.node[0], 0, nodes);
          if (nodes != 0)
            script.newBlock(false, octants, voxels);
        };
      };
  const std::vector<ScriptedFrame> cases = {
      {"new", 11, frame(block(1, 2, 1 << 8), 11), ok},
      {"known", 11, frame(block(1 << 2, 2, 1 << 10), 11)},
      {"known, below its voxels", 11, frame(block(1 << 5, 1, 1), 11)},
      {"known, over a voxel", 11, frame(block(1 << 2, 1, 1), 11)},
      {"no blocks", 10, frame(block(0, 0, 0), 10)},
      {"no octants", 10, frame(block(1, 0, 0), 10)},
      {"a block of none beside another one",
       12,
       frame(
           [](FastScript& script) {
             script.byte(script.models.node[0], 0, 3);
             script.newBlock(false, 0, 0);
             script.newBlock(false, 1, 3);
           },
           12)},
      {"an octant without cells", 10, frame(block(1, 1, 0), 10)},
      {"two octants, one without cells", 11, frame(block(1, 3, 2), 11)},
      {"too few voxels", 11, frame(block(1, 1, 3), 11)},
      {"more blocks than voxels", 10, frame(block(1, 1, 1), 10)},
      {"too many voxels", 13, frame(block(1, 1, 3), 13)}};
  expectAnswers(streamOfTwoBlocks(), cases);
}

TEST(ScriptedFastPayloads, VoxelsOutsideOfAGridOfOneOctant)
{
  const auto iFrame = [](std::uint64_t voxels, std::size_t count) {
    return [=](FastScript& script) {
      script.code(script.models.has_new_blocks, 1);
      script.newBlock(true, voxels);
      script.plainSymbols(count, 0);
    };
  };
  ScriptedStream stream(1, 4, 1, iFrame(1, 1));
  const auto frame = [](unsigned int symbol, const Choices& cells, std::size_t count) {
    return [=](FastScript& script) {
      script.knownVoxels(3, 1, 1);
      script.octants(false, symbol);
      cells(script);
      script.noNewBlocks();
      script.plainSymbols(count, 0);
    };
  };
  const auto none = [](FastScript&) {};
  stream.setGenuine(stream.pFrame(1, frame(0, none, 1)));
  std::vector<ScriptedFrame> cases = {
      {"beside",
       2,
       frame(
           1, [](auto& script) { script.cells(3, 7, 1); }, 2),
       ok}};
  // Octants 1, 2 and 4 lie beside octant 0.
  for (unsigned int rank = 1; rank < 8; ++rank)
    for (const unsigned int open : {0u, 8u}) {
      const auto single = [=](FastScript& script) { script.cells(0, open, 7); };
      const auto several = [=](FastScript& script) {
        script.cells(0, open, 8);
        script.byte(script.models.cells, 0, 3);
      };
      cases.push_back({"single", 2, frame(1 + rank, single, 2)});
      cases.push_back({"several", 3, frame(1 + rank, several, 3)});
    }
  for (const unsigned int open : {0u, 8u})
    cases.push_back({"several octants",
                     3,
                     frame(
                         9,
                         [=](FastScript& script) {
                           script.byte(script.models.octants, 0, 1 | 1 << 7);
                           script.cells(3, 7, 0);
                           script.cells(0, open, 7);
                         },
                         3)});
  expectAnswers(stream, cases);
  for (const std::uint64_t voxels : {std::uint64_t{1} << 8, std::uint64_t{1} << 63}) {
    FastScript script;
    iFrame(voxels, 1)(script);
    EXPECT_EQ(stream.answerTo(stream.frame(true, 1, script.rans().bytes)),
              CompressionCode::Corrupt);
  }
}

TEST(ScriptedFastPayloads, InvalidFinalStates)
{
  const ScriptedStream stream = streamOfTwoBlocks();
  bool was_below = false;
  bool was_above = false;
  for (const unsigned int depth : {3u, 4u}) // of one state, and of four
    for (std::size_t symbols = 1; symbols < (depth == 3 ? 64u : 8u); ++symbols) {
      FastScript script;
      writeFullGrid(script, depth);
      script.bits(1, 1);
      for (std::size_t i = 0; i < std::size_t{1} << 3 * depth; ++i)
        script.byte(script.models.plain, 0, static_cast<unsigned int>(i % symbols));
      const auto answer = [&](const RansChoices& choices) {
        return stream.answerTo(stream.otherIFrame(
            depth, 8, std::size_t{1} << 3 * depth, script.rans(choices).bytes));
      };
      RansChoices genuine;
      genuine.states = depth == 3 ? 1 : 4;
      EXPECT_EQ(answer(genuine), ok);
      for (std::size_t k = 0; k < genuine.states; ++k) {
        RansChoices choices = genuine;
        for (const std::uint32_t end :
             {lowest_rans_state + 1, 2 * lowest_rans_state, (1u << 31) - 1}) {
          choices.ends[k] = end;
          EXPECT_EQ(answer(choices), CompressionCode::Corrupt);
        }
        choices = genuine;
        choices.wrong_start = k;
        EXPECT_EQ(answer(choices), CompressionCode::Corrupt);
        const std::uint32_t start = script.rans(choices).starts[k];
        was_below |= start < lowest_rans_state;
        was_above |= start >= 1u << 31;
      }
    }
  EXPECT_TRUE(was_below);
  EXPECT_TRUE(was_above);
}

TEST(ScriptedFastPayloads, StatesAtTheEndsOfTheirRange)
{
  const auto isGood = [](std::uint32_t state, std::size_t size) {
    Bytes bytes;
    ByteWriter(bytes).u32(state);
    bytes.resize(size);
    Bytes copy;
    const NibbleDecoder decoder(
        bytes.data(), bytes.data() + size, Interleaving::One, copy);
    return !decoder.isOverrun();
  };
  EXPECT_TRUE(isGood(lowest_rans_state, 4));
  EXPECT_TRUE(isGood((1u << 31) - 1, 4));
  for (const std::uint32_t state : {0u, 1u, lowest_rans_state - 1, 1u << 31, ~0u})
    EXPECT_FALSE(isGood(state, 4)) << state;
  for (std::size_t size = 0; size < 4; ++size)
    EXPECT_FALSE(isGood(lowest_rans_state, size)) << size;
}

TEST(ScriptedFastPayloads, FourStatesFrom1024VoxelsOn)
{
  const ScriptedStream stream = streamOfTwoBlocks();
  for (const std::size_t count : {1023u, 1024u}) {
    FastScript script;
    script.code(script.models.has_new_blocks, 1);
    script.byte(script.models.node[1], 0, 3);
    script.byte(script.models.node[0], 0, 255);
    script.byte(script.models.node[0], 0, 255);
    for (int block = 1; block < 16; ++block)
      script.newBlock(true, ~std::uint64_t{0});
    script.newBlock(true, ~std::uint64_t{0} >> (1024 - count));
    script.plainSymbols(count, 1);
    for (const std::size_t states : {1u, 4u}) {
      RansChoices choices;
      choices.states = states;
      EXPECT_EQ(
          stream.answerTo(stream.otherIFrame(4, 8, count, script.rans(choices).bytes)),
          (states == 4) == (count == 1024) ? ok : CompressionCode::Corrupt);
    }
  }
}

TEST(ScriptedFastPayloads, APFrameOfAnotherEffortThanItsIFrame)
{
  // Valid for a decoder of the effort fast without history.
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  VoxelFrame frame = emptyFrame(2);
  frame.keys = {7};
  frame.intensities = {1};
  const Bytes i_frame = encoded(encoder, frame);
  const Bytes p_frame = encoded(encoder, frame);
  Parts parts = takeApart(p_frame);
  ASSERT_FALSE(parts.header.is_i_frame);
  FastScript script;
  script.code(script.models.has_new_blocks, 1);
  script.newBlock(false, 1);
  script.plainSymbols(1, 1);
  parts.header.effort = Effort::Fast;
  parts.payload = script.rans().bytes;
  FrameDecoder decoder;
  VoxelFrame back;
  ASSERT_EQ(decoded(decoder, i_frame, back), ok);
  EXPECT_EQ(
      decoded(decoder, putTogetherSized(parts, takeApart(i_frame).checksum), back),
      CompressionCode::Corrupt);
  EXPECT_EQ(decoded(decoder, p_frame, back), ok);
  expectSameFrame(back, frame);
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/scripted_fast_stream.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::fast;
using namespace pcl_ext::io::test;

constexpr CompressionCode ok = CompressionCode::Ok;

TEST(ScriptedFastPayloads, NewVoxelsInTrackedBlocks)
{
  // In block 2 first: bit 0 of the tracked voxels is cell 0, whose octant has the place
  // 0; three open cells lie beside it.
  const auto frame = [](bool has_cell_0, const Choices& octants) {
    return [=](FastScript& script) {
      script.trackedVoxels(3, 10, has_cell_0 ? 0x3ff : 0x3fe);
      octants(script);
      script.noNewBlocks();
    };
  };
  // Without cell 0 it is octant 1, of cell 9, that has the place 0, and octant 0 has no
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
      script.mask(script.models.several, 3, mask);
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
      // Beside cell 0 are cells 1, 2 and 4.
      script.mask(script.models.several, near == 3 ? 0x16 : 0, mask);
    });
  };
  // Block 5 has no open cell in octant 3, whose place is 0.
  const auto inFullOctant = [](unsigned int symbol) {
    return [=](FastScript& script) {
      script.octants(false, 0);
      script.octants(false, 1);
      script.cells(0, 0, symbol);
      if (symbol == 8)
        script.mask(script.models.several, 0, 3);
    };
  };
  std::vector<ScriptedFrame> cases = {
      {"single", 11, frame(true, oneCell(3, 0)), ok},
      {"last open", 11, frame(true, oneCell(3, 6)), ok},
      {"last open, none near", 10, frame(false, oneCell(0, 6)), ok},
      {"behind the open ones", 10, frame(false, oneCell(0, 7))},
      {"behind the near ones", 11, frame(true, oneCell(3, 7))},
      {"several", 12, frame(true, cellMask(3, 8, 6)), ok},
      {"several, one empty", 11, frame(false, cellMask(0, 8, 6)), ok},
      {"several over an empty one", 11, frame(false, cellMask(0, 8, 3))},
      {"several over an occupied one", 12, frame(true, cellMask(3, 8, 3))},
      {"the same, counted once", 11, frame(true, cellMask(3, 8, 3))},
      {"several that are one", 11, frame(true, cellMask(3, 8, 2))},
      {"several that are none", 10, frame(true, cellMask(3, 8, 0))},
      {"too few voxels", 11, frame(true, cellMask(3, 8, 6))},
      {"too many voxels", 13, frame(true, cellMask(3, 8, 6))},
      {"no open cell, single", 10, frame(true, inFullOctant(0))},
      {"no open cell, single, counted", 11, frame(true, inFullOctant(0))},
      {"no open cell, several", 12, frame(true, inFullOctant(8))},
      {"two octants", 12, frame(true, octantMask(9, 3)), ok},
      {"several octants that are one", 11, frame(true, octantMask(9, 1))},
      {"several octants that are none", 10, frame(true, octantMask(9, 0))}};
  for (unsigned int symbol = 9; symbol < 16; ++symbol)
    cases.push_back({"cell symbol " + std::to_string(symbol),
                     12,
                     frame(true, cellMask(3, symbol, 6))});
  for (unsigned int symbol = 10; symbol < 16; ++symbol)
    cases.push_back({"octant symbol " + std::to_string(symbol),
                     12,
                     frame(true, octantMask(symbol, 3))});
  expectAnswers(streamOfTwoBlocks(), cases);
}

TEST(ScriptedFastPayloads, NewBlocks)
{
  const auto frame = [](const Choices& blocks) {
    return [=](FastScript& script) {
      script.trackedVoxels(3, 10, 0x3ff);
      script.octants(false, 0);
      script.octants(false, 0);
      blocks(script);
    };
  };
  const auto block = [](std::uint64_t key, std::uint64_t cells) {
    return [=](FastScript& script) { script.newVoxels(3, keysOf(key, cells)); };
  };
  // Masks of the root, of block 0, and of its octant 0, as far as there are some.
  const auto nodes = [](const std::vector<unsigned int>& masks) {
    return [=](FastScript& script) {
      for (const unsigned int mask : masks)
        script.node(mask);
    };
  };
  const std::vector<ScriptedFrame> cases = {
      {"new", 11, frame(block(0, 1 << 8)), ok},
      {"new, of several octants", 13, frame(block(7, 1 | 1 << 8 | 1 << 16)), ok},
      {"none", 10, frame(nodes({0})), ok},
      {"tracked", 11, frame(block(2, 1 << 10))},
      {"tracked, below its voxels", 11, frame(block(5, 1))},
      {"tracked, over a voxel", 11, frame(block(2, 1))},
      {"no octants", 10, frame(nodes({1, 0}))},
      {"a block of none beside another one", 12, frame(nodes({9, 0, 1, 3}))},
      {"an octant without cells", 10, frame(nodes({1, 1, 0}))},
      {"two octants, one without cells", 11, frame(nodes({1, 9, 1, 0}))},
      {"too few voxels", 11, frame(block(0, 3))},
      {"more blocks than voxels", 10, frame(block(0, 1))},
      {"too many voxels", 13, frame(block(0, 3))}};
  expectAnswers(streamOfTwoBlocks(), cases);
}

TEST(ScriptedFastPayloads, VoxelsOutsideOfAGridOfOneOctant)
{
  const auto iFrame = [](std::uint64_t voxels) {
    return [=](FastScript& script) { script.newVoxels(2, keysOf(0, voxels)); };
  };
  ScriptedStream stream(1, 0, 1, iFrame(1));
  const auto frame = [](unsigned int symbol, const Choices& cells) {
    return [=](FastScript& script) {
      script.trackedVoxels(3, 1, 1);
      script.octants(false, symbol);
      cells(script);
      script.noNewBlocks();
    };
  };
  const auto none = [](FastScript&) {};
  stream.setGenuine(stream.pFrame(1, frame(0, none)));
  std::vector<ScriptedFrame> cases = {
      {"beside", 2, frame(1, [](auto& script) { script.cells(3, 7, 1); }), ok}};
  // Octants 1, 2 and 4 lie beside octant 0.
  for (unsigned int index = 1; index < 8; ++index)
    for (const unsigned int open : {0u, 8u}) {
      const auto single = [=](FastScript& script) { script.cells(0, open, 7); };
      const auto several = [=](FastScript& script) {
        script.cells(0, open, 8);
        script.mask(script.models.several, 0, 3);
      };
      cases.push_back({"single", 2, frame(1 + index, single)});
      cases.push_back({"several", 3, frame(1 + index, several)});
    }
  for (const unsigned int open : {0u, 8u})
    cases.push_back({"several octants", 3, frame(9, [=](FastScript& script) {
                       script.mask(script.models.several, 1, 1 | 1 << 7);
                       script.cells(3, 7, 0);
                       script.cells(0, open, 7);
                     })});
  expectAnswers(stream, cases);
  for (const std::uint64_t voxels : {std::uint64_t{1} << 8, std::uint64_t{1} << 63}) {
    FastScript script;
    iFrame(voxels)(script);
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
      script.beginSteps();
      for (std::size_t i = 0; i < std::size_t{1} << 3 * depth; ++i)
        script.newStepOrWhole(static_cast<unsigned int>(i * i % symbols % 16));
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
    std::set<std::uint64_t> keys;
    for (std::uint64_t key = 0; key < count; ++key)
      keys.insert(key);
    script.newVoxels(4, keys);
    for (const std::size_t states : {1u, 4u}) {
      RansChoices choices;
      choices.states = states;
      EXPECT_EQ(
          stream.answerTo(stream.otherIFrame(4, 0, count, script.rans(choices).bytes)),
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
  FastScript script{fast::Models()};
  script.newVoxels(2, {0});
  script.broughtStep(1);
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

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Payloads of the effort fast that end too soon, of symbols that take the most
 * bytes: no loop reads further past their end than it may. A sanitizer sees one that
 * does.
 */
#include "support/payload_frames.h"
#include "support/scripted_fast_stream.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief The frames of a stream of the effort fast, all but the first P-frames, also
 * where an encoder would make I-frames. */
std::vector<Bytes>
fastStream(const std::vector<VoxelFrame>& frames)
{
  PayloadCoders coders;
  CodingWorkspace work;
  std::vector<Bytes> stream;
  std::uint32_t checksum = 0;
  for (const VoxelFrame& frame : frames) {
    Parts parts;
    parts.header.is_i_frame = stream.empty();
    parts.header.effort = Effort::Fast;
    parts.header.grid = frame.grid;
    parts.header.intensity_scale = frame.intensity_scale;
    parts.header.frame_number = static_cast<std::uint32_t>(stream.size() + 1);
    parts.header.voxel_count = frame.size();
    encodePayload(coders.of(Effort::Fast), work, frame, stream.empty(), parts.payload);
    stream.push_back(putTogetherSized(parts, checksum));
    checksum = takeApart(stream.back()).checksum;
  }
  return stream;
}

/** \brief An I-frame of the first blocks of a grid, each with its cell 0. */
ScriptedStream
streamOfBlocks(std::size_t block_count)
{
  return ScriptedStream(6, 0, block_count, [=](FastScript& script) {
    std::set<std::uint64_t> keys;
    for (std::uint64_t block = 0; block < block_count; ++block)
      keys.insert(block << 6);
    script.newVoxels(6, keys);
  });
}

/** \brief Voxels of a header, more than any payload here has. */
constexpr std::size_t many = std::size_t{1} << 20;

/** \brief Refuses a script's frame with less and less of its payload.
 *
 * After the end zeros are read, so that a symbol after a word of them is the lowest of
 * its model. Where the low nibble of a byte is always 15, which takes hardly a word,
 * and the high one anything, in states of its own, what is read goes on being good.
 */
void
expectScriptRefused(const ScriptedStream& stream,
                    unsigned int depth,
                    bool is_i_frame,
                    std::size_t count,
                    const Choices& choices)
{
  RansChoices states;
  states.states = count < 1024 ? 1 : 4;
  const auto write = [&](auto&&... models) {
    FastScript script(models...);
    choices(script);
    return script.rans(states).bytes;
  };
  const Bytes whole = is_i_frame ? write() : write(stream.models());
  ASSERT_GT(whole.size(), 600u);
  for (std::size_t size = 20; size < 600; size += 2) {
    const Bytes payload = prefixOf(whole, size);
    const Bytes bytes = is_i_frame ? stream.otherIFrame(depth, 16, count, payload)
                                   : stream.frame(false, count, payload);
    FrameDecoder decoder;
    VoxelFrame back;
    if (!is_i_frame) {
      ASSERT_EQ(decoded(decoder, stream.iFrame(), back), CompressionCode::Ok);
    }
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Corrupt);
  }
}

unsigned int
goodByte(std::mt19937_64& random)
{
  return static_cast<unsigned int>(below(random, 16) << 4) | 15;
}

TEST(ScriptedOverruns, MasksOfSeveral)
{
  constexpr std::size_t blocks = 2048;
  const ScriptedStream stream = streamOfBlocks(blocks);
  std::mt19937_64 random(5);
  const auto trackedBlocks = [](FastScript& script, unsigned int symbol) {
    for (std::size_t i = 0; i < blocks / 8; ++i)
      script.trackedVoxels(3, 8, 255);
    for (std::size_t i = 0; i < blocks; ++i)
      script.octants(false, symbol);
  };
  expectScriptRefused(stream, 6, false, many, [&](FastScript& script) {
    trackedBlocks(script, 9);
    for (std::size_t i = 0; i < blocks; ++i)
      script.mask(script.models.several, 1, goodByte(random));
  });
  expectScriptRefused(stream, 6, false, many, [&](FastScript& script) {
    trackedBlocks(script, 8); // the farthest octant, whose cells are all open
    for (std::size_t i = 0; i < blocks; ++i)
      script.cells(0, 8, 8);
    for (std::size_t i = 0; i < blocks; ++i)
      script.mask(script.models.several, 0, goodByte(random));
  });
}

TEST(ScriptedOverruns, NewNodes)
{
  // Nodes of a deep grid.
  const ScriptedStream stream = streamOfBlocks(1024);
  std::mt19937_64 random(6);
  expectScriptRefused(stream, 20, true, many, [&](FastScript& script) {
    std::set<std::uint64_t> nodes = {0};
    constexpr unsigned int levels = 6;
    for (unsigned int level = 0; level < levels; ++level) {
      std::set<std::uint64_t> children;
      for (const std::uint64_t node : nodes)
        for (unsigned int left = goodByte(random); left != 0; left &= left - 1)
          children.insert(node << 3 | pcl_ext::lowestBit(left));
      nodes = children;
    }
    script.newVoxels(levels, nodes);
  });
}

TEST(ScriptedOverruns, NewSymbols)
{
  // All voxels of a grid, of which the payload has the first symbols.
  constexpr unsigned int depth = 4;
  const ScriptedStream stream = streamOfBlocks(1024);
  std::mt19937_64 random(7);
  expectScriptRefused(
      stream, depth, true, std::size_t{1} << 3 * depth, [&](FastScript& script) {
        writeFullGrid(script, depth);
        script.beginSteps();
        for (int i = 0; i < 1600; ++i)
          script.newStepOrWhole(static_cast<unsigned int>(below(random, 16)));
      });
}

/** \brief An I-frame of all voxels of a grid, each with one step that has no
 * bits. */
ScriptedStream
streamOfFullGrid(unsigned int bits, unsigned int step)
{
  return ScriptedStream(4, bits, 4096, [=](FastScript& script) {
    writeFullGrid(script, 4);
    script.beginSteps();
    script.newStep(0);
    for (int i = 1; i < 4096; ++i)
      script.newStepOrWhole(step);
  });
}

TEST(ScriptedOverruns, TrackedVoxelsAndSteps)
{
  std::mt19937_64 random(9);
  // A single state reads them if the header says that there are few; there are half of
  // those that are written.
  for (const std::size_t count : {1000u, 4096u})
    expectScriptRefused(
        streamOfFullGrid(8, 0), 4, false, count, [&](FastScript& script) {
          for (int i = 0; i < 1024; ++i)
            script.trackedVoxels(3, 8, random());
        });
  const auto trackedVoxels = [](FastScript& script) {
    for (int i = 0; i < 512; ++i)
      script.trackedVoxels(3, 8, 255);
    for (int i = 0; i < 64; ++i)
      script.octants(false, 0);
    script.noNewBlocks();
  };
  expectScriptRefused(streamOfFullGrid(8, 0), 4, false, 4096, [&](FastScript& script) {
    trackedVoxels(script);
    for (int i = 0; i < 4096; ++i)
      script.trackedStep(0, static_cast<unsigned int>(below(random, 15)));
  });
  // Escapes, and after them steps below all nibbles'.
  expectScriptRefused(streamOfFullGrid(5, 24), 4, false, 4096, [&](FastScript& script) {
    trackedVoxels(script);
    script.trackedStep(0, 0);
    for (int i = 1; i < 4096; ++i)
      script.trackedStep(24, 15);
    for (int i = 1; i < 4096; ++i)
      script.wholeStep(static_cast<unsigned int>(below(random, 16)));
  });
}

/** \brief A scene that stays, and new blocks: one in each frame but the last, so that
 * short frames teach what the last one, of many, needs.
 * \param[in] block makes the cells of a block
 * \param[in] steps_end after the symbols of new voxels
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

TEST(ScriptedOverruns, BehindShortFrames)
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

} // namespace

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

/** \brief Writes the first four voxels of a P-frame, and then the others. */
Choices
afterFour(const Choices& steps)
{
  return [=](FastScript& script) {
    script.trackedVoxels(3, 6, 0x3f);
    script.octants(false, 0);
    script.noNewBlocks();
    for (int voxel = 0; voxel < 4; ++voxel)
      script.trackedStep(0, 0);
    steps(script);
  };
}

/** \brief A block of which the voxels had the steps 0, 0, 0, 0, 5, 12. */
ScriptedStream
streamOfSteps(unsigned int bits)
{
  ScriptedStream stream(2, bits, 6, [](FastScript& script) {
    script.newVoxels(2, keysOf(0, 0x3f));
    script.beginSteps();
    for (const unsigned int step : {0u, 0u, 0u, 0u, 5u, 12u})
      script.newStep(step);
  });
  stream.setGenuine(stream.pFrame(6, afterFour([](FastScript& script) {
                                    script.trackedStep(5, 4);
                                    script.trackedStep(12, 8);
                                  })));
  return stream;
}

Choices
withBits(const Choices& choices, unsigned int count, unsigned int bits)
{
  return [=](FastScript& script) {
    choices(script);
    script.bits(count, bits);
  };
}

TEST(ScriptedFastSymbols, StepsOfTrackedVoxels)
{
  // A voxel with the step 12 has nibbles from 5 on.
  const auto tracked = [](unsigned int nibble, int whole) {
    return afterFour([=](FastScript& script) {
      script.trackedStep(5, 4);
      script.trackedStep(12, nibble);
      if (whole >= 0)
        script.wholeStep(static_cast<unsigned int>(whole));
    });
  };
  // What follows the nibbles is in the order of the voxels.
  const auto both = [](unsigned int first, unsigned int second) {
    return afterFour([=](FastScript& script) {
      script.trackedStep(5, 15);
      script.trackedStep(12, 15);
      script.wholeStep(first);
      script.wholeStep(second);
    });
  };
  std::vector<ScriptedFrame> cases = {
      {"nibble", 6, tracked(8, -1), ok},
      {"step 4", 6, tracked(15, 4), ok},
      {"step 20", 6, withBits(tracked(15, 20), 1, 1), ok},
      {"step 47", 6, withBits(tracked(15, 47), 4, 14), ok},
      {"the highest in a step", 6, withBits(tracked(15, 47), 4, 15)},
      {"the highest", 6, tracked(15, 48), ok},
      {"a step of 16 without its bit", 6, tracked(11, -1)},
      {"both whole", 6, both(15, 4), ok},
      {"both whole, the other way around", 6, both(4, 15)}};
  for (int step = 5; step < 16; ++step)
    cases.push_back({"needless step " + std::to_string(step), 6, tracked(15, step)});
  for (int step = 16; step < 20; ++step)
    cases.push_back({"needless step " + std::to_string(step),
                     6,
                     withBits(tracked(15, step), 1, 0)});
  for (const int step : {49, 60, 113, 114, 128, 255})
    cases.push_back({"step " + std::to_string(step), 6, tracked(15, step)});
  expectAnswers(streamOfSteps(8), cases);
  // Of four bits, where values have no steps, the highest symbol is 15.
  expectAnswers(streamOfSteps(4),
                {{"highest", 6, tracked(10, -1), ok},
                 {"above", 6, withBits(tracked(11, -1), 1, 0)},
                 {"above, whole", 6, withBits(tracked(15, 20), 1, 0)},
                 {"no bits above", 6, tracked(11, -1)}});
}

TEST(ScriptedFastSymbols, StepsOfVoxelsThatAPFrameBrings)
{
  // Of the two open cells of the octant the first one.
  const auto brought = [](unsigned int nibble, int whole) {
    return [=](FastScript& script) {
      script.trackedVoxels(3, 6, 0x3f);
      script.octants(false, 1);
      script.cells(2, 2, 0);
      script.noNewBlocks();
      for (int voxel = 0; voxel < 4; ++voxel)
        script.trackedStep(0, 0);
      script.trackedStep(5, 4);
      script.trackedStep(12, 8);
      script.broughtStep(nibble);
      if (whole >= 0)
        script.wholeStep(static_cast<unsigned int>(whole));
    };
  };
  std::vector<ScriptedFrame> cases = {{"lowest", 7, brought(0, -1), ok},
                                      {"highest nibble", 7, brought(14, -1), ok},
                                      {"whole", 7, brought(15, 15), ok},
                                      {"bits", 7, withBits(brought(15, 16), 1, 1), ok},
                                      {"the highest", 7, brought(15, 48), ok},
                                      {"above", 7, brought(15, 49)}};
  for (int step = 0; step < 15; ++step)
    cases.push_back({"needless step " + std::to_string(step), 7, brought(15, step)});
  expectAnswers(streamOfSteps(8), cases);
}

TEST(ScriptedFastSymbols, StepsOfAnIFrame)
{
  // One voxel: its class is that of a step 2, whose nibbles are from 0 on.
  const ScriptedStream stream = streamOfSteps(8);
  const auto answer = [&](unsigned int bits, const Choices& steps) {
    FastScript script;
    script.newVoxels(2, {0});
    script.beginSteps();
    steps(script);
    return stream.answerTo(stream.otherIFrame(2, bits, 1, script.rans().bytes));
  };
  const auto nibble = [](unsigned int symbol) {
    return [=](FastScript& script) { script.newStep(symbol, symbol); };
  };
  const auto whole = [](unsigned int step, unsigned int count, unsigned int bits) {
    return [=](FastScript& script) {
      script.newStep(15, step);
      script.wholeStep(step);
      if (count > 0)
        script.bits(count, bits);
    };
  };
  EXPECT_EQ(answer(8, nibble(0)), ok);
  EXPECT_EQ(answer(8, nibble(14)), ok);
  EXPECT_EQ(answer(8, whole(15, 0, 0)), ok);
  EXPECT_EQ(answer(8, whole(47, 4, 14)), ok);
  EXPECT_EQ(answer(8, whole(48, 0, 0)), ok);
  for (unsigned int step = 0; step < 15; ++step)
    EXPECT_EQ(answer(8, whole(step, 0, 0)), CompressionCode::Corrupt) << step;
  EXPECT_EQ(answer(8, whole(47, 4, 15)), CompressionCode::Corrupt); // the highest
  for (const unsigned int step : {49u, 113u, 114u, 128u, 255u})
    EXPECT_EQ(answer(8, whole(step, 0, 0)), CompressionCode::Corrupt) << step;
  // Of two bits: values 0..3.
  EXPECT_EQ(answer(2, nibble(3)), ok);
  for (const unsigned int symbol : {4u, 5u, 14u})
    EXPECT_EQ(answer(2, nibble(symbol)), CompressionCode::Corrupt) << symbol;
  EXPECT_EQ(answer(2, whole(15, 0, 0)), CompressionCode::Corrupt);
  EXPECT_EQ(answer(2, whole(16, 1, 0)), CompressionCode::Corrupt);
}

} // namespace

#include "support/scripted_fast_stream.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::fast;
using namespace pcl_ext::io::test;

constexpr CompressionCode ok = CompressionCode::Ok;

TEST(ScriptedFastSymbols, PlainSymbolsAreBelowTheirEnd)
{
  const ScriptedStream stream = streamOfTwoBlocks(); // of four bits
  const auto frame = [](unsigned int symbol) {
    return [=](FastScript& script) {
      script.knownVoxels(3, 10, 0x3ff);
      script.octants(false, 0);
      script.octants(false, 0);
      script.noNewBlocks();
      script.plainSymbols(10, symbol);
    };
  };
  std::vector<ScriptedFrame> cases = {{"highest", 10, frame(15), ok}};
  for (const unsigned int symbol : {16u, 17u, 255u})
    cases.push_back({std::to_string(symbol), 10, frame(symbol)});
  expectAnswers(stream, cases);
}

/** \brief A block of which the voxels had the steps 0, 0, 0, 0, 5, 12. */
ScriptedStream
streamOfSteps(unsigned int bits)
{
  ScriptedStream stream(2, bits, 6, [](FastScript& script) {
    script.code(script.models.has_new_blocks, 1);
    script.newBlock(true, 0x3f);
    script.beginSteps(0);
    for (const unsigned int step : {0u, 0u, 0u, 0u, 5u, 12u})
      script.newStep(step);
  });
  stream.setGenuine(stream.pFrame(6, [](FastScript& script) {
    script.knownVoxels(3, 6, 0x3f);
    script.octants(false, 0);
    script.noNewBlocks();
    script.beginSteps(0);
    script.code(script.models.quad[0], 0);
    script.knownStep(5, 4);
    script.knownStep(12, 8);
  }));
  return stream;
}

TEST(ScriptedFastSymbols, StepsOfKnownVoxels)
{
  // A voxel with the step 12 has nibbles from 5 on.
  const auto frame = [](unsigned int origin, unsigned int quad, const Choices& steps) {
    return [=](FastScript& script) {
      script.knownVoxels(3, 6, 0x3f);
      script.octants(false, 0);
      script.noNewBlocks();
      script.beginSteps(origin);
      script.code(script.models.quad[0], quad);
      steps(script);
    };
  };
  const auto knownWith = [&](unsigned int origin, unsigned int nibble, int whole) {
    return frame(origin, 0, [=](FastScript& script) {
      script.knownStep(5, 4);
      script.knownStep(12, nibble);
      if (whole >= 0)
        script.wholeStep(static_cast<unsigned int>(whole));
    });
  };
  const auto known = [&](unsigned int nibble, int whole) {
    return knownWith(0, nibble, whole);
  };
  const auto escaped = [&](unsigned int nibble, int whole) {
    return frame(0, 3, [=](FastScript& script) {
      script.knownStep(5, 4);
      script.knownStep(12, 8);
      script.code(script.models.quad_escape[0], nibble);
      if (whole >= 0)
        script.wholeStep(static_cast<unsigned int>(whole));
    });
  };
  const auto withBits = [](const Choices& choices, unsigned int count, unsigned int b) {
    return [=](FastScript& script) {
      choices(script);
      script.bits(count, b);
    };
  };
  std::vector<ScriptedFrame> cases = {
      {"nibble", 6, known(8, -1), ok},
      {"step 4", 6, known(15, 4), ok},
      {"step 20", 6, withBits(known(15, 20), 1, 1), ok},
      {"step 47", 6, withBits(known(15, 47), 4, 14), ok},
      {"the highest in a step", 6, withBits(known(15, 47), 4, 15)},
      {"the highest", 6, known(15, 48), ok},
      {"quad", 6, escaped(1, -1), ok},
      {"quad, step 18", 6, withBits(escaped(15, 18), 1, 0), ok},
      {"quad, highest in a step", 6, withBits(escaped(15, 47), 4, 15)},
      {"no symbol is 0", 6, frame(0, 0x55, [](FastScript& script) {
         script.knownStep(5, 4);
         script.knownStep(12, 8);
       })}};
  for (int step = 5; step < 16; ++step)
    cases.push_back({"needless step " + std::to_string(step), 6, known(15, step)});
  for (int step = 16; step < 20; ++step)
    cases.push_back(
        {"needless step " + std::to_string(step), 6, withBits(known(15, step), 1, 0)});
  for (int step = 0; step < 16; ++step)
    cases.push_back({"quad, step " + std::to_string(step), 6, escaped(15, step)});
  for (int step = 16; step < 18; ++step)
    cases.push_back(
        {"quad, step " + std::to_string(step), 6, withBits(escaped(15, step), 1, 0)});
  for (const int step : {49, 60, 113, 114, 128, 255}) {
    cases.push_back({"step " + std::to_string(step), 6, known(15, step)});
    cases.push_back({"quad, step " + std::to_string(step), 6, escaped(15, step)});
  }
  expectAnswers(streamOfSteps(8), cases);
  // Of four bits, where values have no steps, the highest symbol is 15.
  expectAnswers(streamOfSteps(4),
                {{"highest", 6, known(10, -1), ok},
                 {"highest, lowered", 6, knownWith(1, 9, -1), ok},
                 {"above, lowered", 6, knownWith(1, 10, -1)},
                 {"above", 6, withBits(known(11, -1), 1, 0)},
                 {"above, whole", 6, withBits(known(15, 20), 1, 0)},
                 {"no bits above", 6, known(11, -1)}});
}

TEST(ScriptedFastSymbols, StepsOfNewVoxels)
{
  // One voxel: its class is that of a step 2, whose nibbles are from 0 on.
  const ScriptedStream stream = streamOfSteps(8);
  const auto answer =
      [&](unsigned int bits, unsigned int origin, const Choices& steps) {
        FastScript script;
        script.code(script.models.has_new_blocks, 1);
        script.newBlock(true, 1);
        script.beginSteps(origin);
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
  EXPECT_EQ(answer(8, 1, nibble(14)), ok);
  EXPECT_EQ(answer(8, 0, nibble(0)), ok);
  EXPECT_EQ(answer(8, 0, nibble(14)), CompressionCode::Corrupt); // none is 0
  EXPECT_EQ(answer(8, 1, whole(15, 0, 0)), ok);
  EXPECT_EQ(answer(8, 1, whole(46, 4, 15)), ok);
  EXPECT_EQ(answer(8, 1, whole(48, 0, 0)), ok);
  for (unsigned int step = 0; step < 15; ++step)
    EXPECT_EQ(answer(8, 1, whole(step, 0, 0)), CompressionCode::Corrupt) << step;
  EXPECT_EQ(answer(8, 1, whole(47, 4, 14)), CompressionCode::Corrupt); // the highest
  EXPECT_EQ(answer(8, 1, whole(47, 4, 15)), CompressionCode::Corrupt); // above it
  for (const unsigned int step : {49u, 113u, 114u, 128u, 255u})
    EXPECT_EQ(answer(8, 1, whole(step, 0, 0)), CompressionCode::Corrupt) << step;
  // Of two bits: values 0..2 above the origin.
  EXPECT_EQ(answer(2, 1, nibble(2)), ok);
  for (const unsigned int symbol : {3u, 4u, 14u})
    EXPECT_EQ(answer(2, 1, nibble(symbol)), CompressionCode::Corrupt) << symbol;
  EXPECT_EQ(answer(2, 1, whole(15, 0, 0)), CompressionCode::Corrupt);
  EXPECT_EQ(answer(2, 1, whole(16, 1, 0)), CompressionCode::Corrupt);
}

} // namespace

#include <pcl_ext/compression/depth_model.h>

#include "codec/context/history.h"
#include "codec/depth_split.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr std::int64_t farthest = std::int64_t{1} << 56;
constexpr std::int32_t steepest = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t deepest = std::numeric_limits<std::int32_t>::min();

DepthModel
randomModel(std::mt19937_64& random)
{
  DepthModel model;
  model.exponent = static_cast<std::uint8_t>(1 + below(random, 2));
  const std::uint64_t kind = below(random, 5);
  model.full_symbol =
      kind == 0 ? 0
      : kind == 1
          ? (1u << 24) - 1
          : static_cast<std::uint32_t>(below(random, 1u << (1 + below(random, 24))));
  const std::uint64_t place = below(random, 5);
  model.origin = place == 0   ? farthest
                 : place == 1 ? -farthest
                              : static_cast<std::int64_t>(below(random, 1ull << 33)) -
                                    (std::int64_t{1} << 30);
  for (std::int32_t& step : model.step) {
    const std::uint64_t slope = below(random, 5);
    step = slope == 0 ? steepest
           : slope == 1
               ? deepest
               : static_cast<std::int32_t>(below(random, 1u << 26)) - (1 << 25);
  }
  return model;
}

std::vector<DepthPrediction>
predictionsOf(const context::History& history, const BlockList& blocks)
{
  std::vector<DepthPrediction> predictions;
  history.predictDepths(blocks, predictions);
  return predictions;
}

/** \brief Splits a frame as an encoder does, joins it as a decoder does.
 * \param[in,out] residuals how many symbols had a residual
 */
void
expectLossless(const DepthModel& model,
               const VoxelFrame& frame,
               context::History& history,
               bool is_i_frame,
               std::size_t& residuals)
{
  BlockList blocks;
  blocks.assign(frame.keys);
  const std::uint32_t max_symbol = frame.intensity_scale.maxSymbol();
  DepthSplit split;
  split.begin(model, blocks, predictionsOf(history, blocks), max_symbol);
  std::vector<std::uint16_t> numbers;
  split.baseSymbolsOf(frame.intensities, numbers);
  ASSERT_EQ(numbers.size(), frame.size());
  split.predict(numbers);

  DepthSplit join;
  join.begin(model, blocks, predictionsOf(history, blocks), max_symbol);
  join.predict(numbers);
  ASSERT_EQ(join.classes(), split.classes());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    ASSERT_LE(numbers[i], frame.intensities[i]); // a point is a symbol or more
    if (split.classes()[i] == DepthSplit::no_residual) {
      ASSERT_EQ(numbers[i], frame.intensities[i]);
      continue;
    }
    ++residuals;
    ASSERT_LT(split.classes()[i], DepthSplit::class_count);
    ASSERT_LT(split.predictionContext(i), 128u);
    ASSERT_LT(split.pointClass(i), 4u);
    ASSERT_EQ(join.predictionContext(i), split.predictionContext(i));
    std::uint16_t symbol = 0;
    ASSERT_TRUE(join.symbol(i, split.residual(i, frame.intensities[i]), symbol));
    ASSERT_EQ(symbol, frame.intensities[i]);
  }
  DepthObservations depths;
  split.observe(numbers, frame.intensities, depths);
  ASSERT_EQ(depths.offsets.size(), frame.size());
  ASSERT_EQ(depths.residuals.size(), frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    ASSERT_LE(std::abs(depths.offsets[i]), 8192);
    ASSERT_LE(depths.residuals[i], 15);
  }
  history.update(blocks, numbers, &depths, is_i_frame);
}

TEST(DepthSplit, AnySymbolsComeBackWithAnyModel)
{
  std::mt19937_64 random(1);
  std::size_t symbols = 0;
  std::size_t residuals = 0;
  for (int round = 0; round < 400; ++round) {
    const unsigned int bits = 1 + static_cast<unsigned int>(round) % 16;
    const unsigned int depths[] = {1, 2, 5, 21};
    const unsigned int depth = depths[round / 16 % 4];
    context::History history;
    history.clear(bits);
    VoxelFrame frame = randomFrame(random, depth, depth == 1 ? 5 : 40, bits);
    DepthModel model = randomModel(random);
    ASSERT_TRUE(isConsistent(model));
    for (int i = 0; i < 6; ++i) {
      ASSERT_NO_FATAL_FAILURE(expectLossless(model, frame, history, i == 0, residuals));
      symbols += frame.size();
      walk(random, 3, frame);
      if (i == 3) // models may change on the way
        model = randomModel(random);
      if (i == 4) // the ends of the scale
        for (std::uint16_t& symbol : frame.intensities)
          symbol = below(random, 2) == 0
                       ? std::uint16_t{0}
                       : static_cast<std::uint16_t>(frame.intensity_scale.maxSymbol());
    }
  }
  EXPECT_GT(residuals, symbols / 10);
  EXPECT_LT(residuals, symbols);
}

TEST(DepthSplit, SymbolsOutsideTheScaleAreRefused)
{
  DepthModel model = roomDepthModel(4, 8);
  model.origin = std::int64_t{1} << 31; // a point is worth 21 symbols
  model.step = {};
  BlockList blocks;
  blocks.assign({0, 1});
  DepthSplit split;
  split.begin(model, blocks, {}, 255);
  split.predict({1, 11});
  std::uint16_t symbol = 0;
  const std::uint32_t residual_of_0 = split.residual(0, 0);
  const std::uint32_t residual_of_255 = split.residual(0, 255);
  EXPECT_TRUE(split.symbol(0, residual_of_0, symbol));
  EXPECT_EQ(symbol, 0);
  EXPECT_FALSE(split.symbol(0, residual_of_0 + 2, symbol)); // -1
  EXPECT_TRUE(split.symbol(0, residual_of_255, symbol));
  EXPECT_EQ(symbol, 255);
  EXPECT_FALSE(split.symbol(0, residual_of_255 + 2, symbol)); // 256
  for (const std::uint32_t residual :
       {511u, 512u, 65535u, 1u << 20, 0xfffffffeu, 0xffffffffu})
    EXPECT_FALSE(split.symbol(0, residual, symbol)) << residual;
  std::size_t symbols = 0;
  for (std::uint32_t residual = 0; residual < 600; ++residual)
    symbols += split.symbol(1, residual, symbol) ? 1 : 0;
  EXPECT_EQ(symbols, 256u);
}

TEST(DepthSplit, ResidualsAreZeroWhereTheModelIsExact)
{
  const unsigned int bits = 12;
  const DepthModel model = roomDepthModel(6, bits);
  std::mt19937_64 random(2);
  VoxelFrame frame = randomFrame(random, 6, 3000, bits);
  BlockList blocks;
  blocks.assign(frame.keys);
  std::vector<std::uint64_t> points;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    points.push_back(1 + below(random, 5));
    const std::uint64_t exact =
        points[i] * model.pointSymbol(voxelPosition(frame.keys[i]));
    frame.intensities[i] = static_cast<std::uint16_t>(
        std::min<std::uint64_t>((exact + (1 << 15)) >> 16, 4095));
  }
  DepthSplit split;
  split.begin(model, blocks, {}, 4095);
  std::vector<std::uint16_t> numbers;
  split.baseSymbolsOf(frame.intensities, numbers);
  split.predict(numbers);
  std::size_t with_residual = 0;
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (split.classes()[i] != DepthSplit::no_residual && frame.intensities[i] < 4095) {
      ++with_residual;
      ASSERT_EQ(numbers[i], points[i]);
      ASSERT_EQ(split.residual(i, frame.intensities[i]), 0u);
    }
  EXPECT_GT(with_residual, 2000u);
}

TEST(DepthSplit, TheHistoryLearnsDepthOffsets)
{
  // Every point is worth a tenth more than the centre says.
  const unsigned int bits = 16;
  DepthModel model = roomDepthModel(6, bits, 1);
  model.step = {1 << 22, 0, 0};
  std::mt19937_64 random(3);
  VoxelFrame frame = randomFrame(random, 6, 500, bits);
  BlockList blocks;
  blocks.assign(frame.keys);
  context::History history;
  history.clear(bits);
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  for (int round = 0; round < 20; ++round) {
    for (std::size_t i = 0; i < frame.size(); ++i)
      frame.intensities[i] = static_cast<std::uint16_t>(
          2 * model.pointSymbol(voxelPosition(frame.keys[i])) * 11 / 10 >> 16);
    DepthSplit split;
    split.begin(model,
                blocks,
                predictionsOf(history, blocks),
                frame.intensity_scale.maxSymbol());
    std::vector<std::uint16_t> numbers;
    split.baseSymbolsOf(frame.intensities, numbers);
    split.predict(numbers);
    std::uint64_t residuals = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      ASSERT_EQ(numbers[i], 2);
      residuals += split.residual(i, frame.intensities[i]);
    }
    (round == 0 ? first : last) = residuals;
    DepthObservations depths;
    split.observe(numbers, frame.intensities, depths);
    history.update(blocks, numbers, &depths, round == 0);
  }
  EXPECT_LT(last, first / 50);
}

} // namespace

#include "codec/context/choices.h"
#include "codec/context/entropy_coder.h"
#include "codec/context/models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io::context;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t class_count = 5;
using Model = ChoiceModel<class_count>;

constexpr std::array<std::uint16_t, class_count> starting_weights = {1, 2, 40, 1023, 7};

/** \brief A choice, and what there is to choose from. */
struct Step {
  Model::Counts counts;
  Choice choice;
};

/** \brief Numbers of alternatives: few, one alone, or 64. */
Model::Counts
drawCounts(std::mt19937_64& random)
{
  Model::Counts counts{};
  switch (random() % 4) {
  case 0:
    counts[random() % class_count] = 1;
    break;
  case 1:
    counts[random() % class_count] = 64;
    break;
  default:
    for (std::uint32_t& count : counts)
      count = static_cast<std::uint32_t>(random() % 13);
    counts[random() % class_count] += 1;
  }
  return counts;
}

std::vector<Step>
drawSteps(std::uint64_t seed, std::size_t count)
{
  std::mt19937_64 random(seed);
  std::vector<Step> steps(count);
  for (Step& step : steps) {
    step.counts = drawCounts(random);
    do
      step.choice.alternative_class = random() % class_count;
    while (step.counts[step.choice.alternative_class] == 0);
    step.choice.index = static_cast<std::uint32_t>(
        random() % step.counts[step.choice.alternative_class]);
  }
  return steps;
}

/** \brief The weights by the formula of doc/bitstream_context.md, "Choices". */
class NaiveWeights {
public:
  NaiveWeights()
  {
    for (std::size_t i = 0; i < class_count; ++i)
      weights_[i] = 65536.0 * starting_weights[i];
  }

  double
  used(std::size_t i) const
  {
    return std::floor(weights_[i] / 65536.0);
  }

  /** \brief All numbers are integers below 2^53. */
  void
  learn(const Step& step)
  {
    double total = 0.0;
    std::array<double, class_count> used_before{};
    for (std::size_t i = 0; i < class_count; ++i) {
      used_before[i] = used(i);
      total += used_before[i] * step.counts[i];
    }
    const double reciprocal = std::floor(4294967296.0 / total);
    for (std::size_t i = 0; i < class_count; ++i) {
      const double share =
          std::floor(used_before[i] * step.counts[i] * reciprocal / 65536.0);
      const double error = (i == step.choice.alternative_class ? 65536.0 : 0.0) - share;
      weights_[i] += std::floor(weights_[i] * error / 1048576.0);
      weights_[i] = std::clamp(weights_[i], 65536.0, 67108863.0);
    }
  }

private:
  std::array<double, class_count> weights_{};
};

TEST(Choices, ModelsFollowTheFormula)
{
  Model model(starting_weights);
  NaiveWeights naive;
  std::size_t step_number = 0;
  for (const Step& step : drawSteps(1, 20000)) {
    for (std::size_t i = 0; i < class_count; ++i)
      ASSERT_EQ(model.weight(i), naive.used(i)) << step_number;
    model.learn(step.counts, model.total(step.counts), step.choice.alternative_class);
    naive.learn(step);
    ++step_number;
  }
}

TEST(Choices, WeightsStayWithinTheirLimits)
{
  // Of class 3 one is always chosen, of class 0 never.
  Model model(starting_weights);
  for (int i = 0; i < 2000; ++i) {
    Model::Counts counts{};
    counts[0] = 32;
    counts[3] = 32;
    model.learn(counts, model.total(counts), 3);
  }
  EXPECT_EQ(model.weight(0), 1u);
  EXPECT_EQ(model.weight(3), 1023u);
  Model::Counts all_heaviest{};
  all_heaviest[3] = 64;
  EXPECT_LT(model.total(all_heaviest), 1u << 16);
}

TEST(Choices, ModelsLearnHowOftenAClassIsChosen)
{
  // Class 2 has 10 alternatives and is chosen in 30 % of the choices, class 4 has 5.
  Model model(starting_weights);
  Model::Counts counts{};
  counts[2] = 10;
  counts[4] = 5;
  std::mt19937_64 random(2);
  double share = 0.0;
  constexpr int rounds = 20000;
  for (int i = 0; i < rounds; ++i) {
    const double total = model.total(counts);
    share += model.weight(2) * 10 / total / rounds;
    model.learn(counts, model.total(counts), random() % 10 < 3 ? 2 : 4);
  }
  EXPECT_NEAR(share, 0.3, 0.02);
}

template <typename CoderT>
using Coding = DecisionCoding<CoderT, false>;

Bytes
encode(const std::vector<Step>& steps)
{
  Bytes bytes;
  Coding<BinaryRangeEncoder> coding{BinaryRangeEncoder(bytes)};
  Model model(starting_weights);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    coding.codeChoice(model, steps[i].counts, steps[i].choice);
    coding.codeBypass(i % 3 == 0);
  }
  coding.coder().finish();
  return bytes;
}

TEST(Choices, AreDecodedBetweenBits)
{
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const std::vector<Step> steps = drawSteps(seed, 400);
    const Bytes bytes = encode(steps);
    Coding<BinaryRangeDecoder> coding{
        BinaryRangeDecoder(bytes.data(), bytes.data() + bytes.size())};
    Model model(starting_weights);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const Choice choice = coding.codeChoice(model, steps[i].counts, {});
      ASSERT_EQ(choice.alternative_class, steps[i].choice.alternative_class) << i;
      ASSERT_EQ(choice.index, steps[i].choice.index) << i;
      ASSERT_EQ(coding.codeBypass(false), i % 3 == 0) << i;
    }
    EXPECT_TRUE(coding.coder().isAtEnd());
  }
}

TEST(Choices, TakeTheBitsOfTheirShares)
{
  const std::vector<Step> steps = drawSteps(3, 20000);
  Model model(starting_weights);
  double bits = 0.0;
  for (const Step& step : steps) {
    const std::uint32_t total = model.total(step.counts);
    const std::size_t chosen = step.choice.alternative_class;
    bits += std::log2(static_cast<double>(total) / model.weight(chosen)) + 1.0;
    model.learn(step.counts, total, chosen);
  }
  // Shares are of the units that fit into the interval: some are lost.
  const double bytes = static_cast<double>(encode(steps).size());
  EXPECT_GT(bytes, 0.999 * bits / 8.0);
  EXPECT_LT(bytes, 1.01 * bits / 8.0);
}

TEST(Choices, AnyBytesDecodeToAnAlternative)
{
  std::mt19937_64 random(4);
  for (int round = 0; round < 200; ++round) {
    Bytes bytes(random() % 300);
    // Runs of the highest and the lowest byte are at the ends of intervals.
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = round % 3 == 0   ? 0xff
                 : round % 3 == 1 ? static_cast<std::uint8_t>(random())
                                  : static_cast<std::uint8_t>(random() % 2 * 0xff);
    Coding<BinaryRangeDecoder> coding{
        BinaryRangeDecoder(bytes.data(), bytes.data() + bytes.size())};
    Model model(starting_weights);
    for (int i = 0; i < 500; ++i) {
      const Model::Counts counts = drawCounts(random);
      const Choice choice = coding.codeChoice(model, counts, {});
      ASSERT_LT(choice.alternative_class, class_count);
      ASSERT_LT(choice.index, counts[choice.alternative_class]);
    }
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;

TEST(IntensityQuantiser, CountsAreExactWithAsManyBitsAsTheyNeed)
{
  Stream stream(settingsOf(0.04));
  struct Case {
    std::size_t count;
    bool may_refit;
    unsigned int bits;
  };
  for (const Case& c : std::vector<Case>{{254, false, 8},
                                         {255, false, 8},
                                         {256, false, 9},
                                         {3, false, 9},
                                         {1000, false, 10},
                                         {600, true, 10},
                                         {400, true, 10},
                                         {250, true, 9},
                                         {65535, true, 16},
                                         {2, true, 8}}) {
    SCOPED_TRACE(c.count);
    Cloud cloud(c.count, Point{0.01f, 0.01f, 0.01f});
    cloud.push_back({0.05f, 0.01f, 0.01f});
    stream.add(withoutIntensities(cloud), c.may_refit);
    EXPECT_EQ(stream.values(),
              (std::map<LatticeIndex, float>{{{0, 0, 0}, static_cast<float>(c.count)},
                                             {{1, 0, 0}, 1.0f}}));
    EXPECT_EQ(stream.statistics.intensities_out_of_range, 0u);
    EXPECT_EQ(stream.frame.intensity_scale, (IntensityScale{0.0f, 1.0f, c.bits, 0}));
  }
}

TEST(IntensityQuantiser, SharesAreRoundedAndCappedAtOne)
{
  Cloud cloud = randomCloud(7, -0.4, 0.4);
  cloud.push_back({0.95f, 0.05f, 0.05f, -3.0f}); // becomes 0
  for (const auto format : {StreamFormat::Version1, StreamFormat::Published}) {
    Stream stream(settingsOf(0.1, format), IntensityUnit::Share);
    stream.add(cloud);
    std::map<LatticeIndex, float> expected;
    std::size_t saturated = 0;
    for (const auto& voxel : naiveVoxels(cloud, 0.1)) {
      const double sum = 255.0 * sumOf(voxel.second);
      const double shown =
          format == StreamFormat::Published ? std::floor(sum) : std::floor(sum + 0.5);
      expected[voxel.first] = static_cast<float>(std::clamp(shown, 0.0, 255.0));
      saturated += shown > 255.0 || shown < 0.0 ? 1 : 0;
    }
    EXPECT_EQ(stream.values(), expected);
    EXPECT_GT(saturated, 1u);
    EXPECT_EQ(stream.statistics.intensities_out_of_range, saturated);
  }
}

TEST(IntensityQuantiser, NativeIntensitiesAreMeansUnlessSumsAreWanted)
{
  const Cloud cloud{{0.1f, 0.1f, 0.1f, 10.0f}, {0.2f, 0.2f, 0.2f, 30.0f}};
  const auto value = [&cloud](Aggregation aggregation, StreamFormat format) {
    IntensityCompressionSettings settings = settingsOf(1.0, format);
    settings.aggregation = aggregation;
    Stream stream(settings, IntensityUnit::Native);
    stream.add(cloud);
    return stream.values().begin()->second;
  };
  EXPECT_EQ(value(Aggregation::Automatic, StreamFormat::Version1), 20.0f);
  EXPECT_EQ(value(Aggregation::Mean, StreamFormat::Version1), 20.0f);
  EXPECT_EQ(value(Aggregation::Sum, StreamFormat::Version1), 40.0f);
  EXPECT_EQ(value(Aggregation::Automatic, StreamFormat::Published), 40.0f);
  EXPECT_EQ(value(Aggregation::Mean, StreamFormat::Published), 20.0f);
}

/** \brief Every value comes back within half a step, which is at most `max_step`. */
void
expectWithinHalfAStep(const Stream& stream, const std::vector<float>& intensities)
{
  const auto values = stream.values();
  ASSERT_EQ(values.size(), intensities.size());
  const double step = double{stream.frame.intensity_scale.step};
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    const double value = double{values.at({static_cast<std::int64_t>(i), 0, 0})};
    EXPECT_LE(std::abs(value - double{intensities[i]}), 0.501 * step) << intensities[i];
  }
  EXPECT_EQ(stream.statistics.intensities_out_of_range, 0u);
}

TEST(IntensityQuantiser, NativeWholeNumbersOf8BitsAreExact)
{
  Stream stream(settingsOf(1.0), IntensityUnit::Native);
  for (const std::size_t count : {3u, 256u}) { // the same scale from the first frame on
    std::vector<float> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0.0f);
    stream.add(row(numbers));
    EXPECT_TRUE(stream.frame.intensity_scale == IntensityScale());
    for (std::size_t i = 0; i < count; ++i)
      EXPECT_EQ(stream.values().at({static_cast<std::int64_t>(i), 0, 0}), numbers[i]);
  }
}

TEST(IntensityQuantiser, NativeScalesFollowTheValues)
{
  struct Case {
    std::vector<float> intensities;
    double largest_step;
    unsigned int bits;
  };
  const std::vector<Case> cases{
      {{0.0f, 300.0f, 511.0f}, 1.0, 9},
      {{0.0f, 65535.0f, 1234.0f}, 1.0, 16},
      {{0.0f, 100000.0f}, 3.0, 16},
      {{0.0f, 0.5f, 1.0f, 0.333f}, 0.001, 10},
      {{0.0f, 0.5f, 1.0f, 0.3333f}, 1.0 / 65535.0, 16},
      {{0.1f, 0.0001f}, 0.2 / 65535.0, 16},
      {{-5.0f, 100.0f}, 1.0, 8},
      {{-90.0f, -20.0f}, 1.0, 8}, // dBm
      {{-0.5f, 0.3f}, 0.1, 8},
      {{-0.5f, 0.33333f}, 1.5 / 65535.0, 16},
      {{-100.5f, 3.0f, -7.0f}, 0.5, 9},
      {{-100.7182f, 3.0f, -7.0f}, 512.0 / 65535.0, 16},
      {{1234.5f, 0.25f}, 0.25, 13},
      {{1234.5671f, 0.25f}, 2048.0 / 65535.0, 16},
      {{0.0f, 0.37f, 0.99f}, 0.01, 8}, // KITTI's reflectance
      {{1.0f, 2.0f / 255.0f, 254.0f / 255.0f}, 1.0 / 255.0, 8},
      {{3.14f, 0.001f}, 0.001, 12},
      {{65.534f, 0.001f}, 0.001, 16},
      {{65.536f, 0.001f}, 128.0 / 65535.0, 16},
      {{3e4f, 1e20f}, 4e20 / 65535.0, 16}, // beyond 64 bits, and whole
      {{1.5f, -2e38f}, 1e36, 16},
      {{1.5f, largest}, 1e36, 16},
      {{1e-30f, 3e-31f}, 2e-30 / 65535.0, 16}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.intensities[1]);
    Stream stream(settingsOf(1.0), IntensityUnit::Native);
    stream.add(row(c.intensities));
    EXPECT_LE(double{stream.frame.intensity_scale.step}, c.largest_step * 1.000001);
    EXPECT_EQ(stream.frame.intensity_scale.bits, c.bits);
    expectWithinHalfAStep(stream, c.intensities);
  }
}

TEST(IntensityQuantiser, MoreBitsThanMultiplesNeedKeepThemExact)
{
  for (const unsigned int bits : {8u, 9u, 12u, 16u})
    for (const auto& [intensities, step] :
         std::vector<std::pair<std::vector<float>, float>>{{{0.0f, 7.0f, 200.0f}, 1.0f},
                                                           {{0.25f, 3.0f}, 0.25f},
                                                           {{-100.0f, 5.0f}, 1.0f}}) {
      SCOPED_TRACE(bits);
      auto settings = settingsOf(1.0);
      settings.intensity_bits = bits;
      Stream stream(settings, IntensityUnit::Native);
      stream.add(row(intensities));
      EXPECT_EQ(stream.frame.intensity_scale.step, step);
      EXPECT_EQ(stream.frame.intensity_scale.bits, bits);
    }
}

TEST(IntensityQuantiser, TheStepIsThatOfAllValuesSinceTheLastIFrame)
{
  Stream stream(settingsOf(1.0), IntensityUnit::Native);
  const auto step = [&](const std::vector<float>& intensities, bool may_refit) {
    stream.add(row(intensities), may_refit);
    expectWithinHalfAStep(stream, intensities);
    return stream.frame.intensity_scale.step;
  };
  EXPECT_EQ(step({0.5f, 1.0f}, true), 0.5f);
  EXPECT_EQ(step({0.2f, 3.0f}, false), 0.1f); // 0.5 is no multiple of 0.2
  EXPECT_EQ(step({2.0f, 3.0f}, false), 0.1f);
  EXPECT_EQ(step({0.7182818f, 3.0f}, false), 4.0f / 65535.0f);
  EXPECT_EQ(step({0.5f, 1.0f}, false), 4.0f / 65535.0f);
  EXPECT_EQ(step({2.0f, 3.0f}, true), 1.0f);
}

TEST(IntensityQuantiser, NativeScalesOfExtremeIntensitiesAreConsistent)
{
  for (const float intensity : {-largest, largest, 1e-42f, -1e-42f, 1e-45f}) {
    SCOPED_TRACE(intensity);
    Stream stream(settingsOf(1.0), IntensityUnit::Native);
    stream.add(row({0.5f * intensity, intensity}));
    Stream sums(settingsOf(1.0), IntensityUnit::Native);
    sums.add(Cloud(300, Point{0.5f, 0.5f, 0.5f, intensity}));
  }
}

TEST(IntensityQuantiser, NativeScalesGrowAndNeverShrink)
{
  Stream stream(settingsOf(1.0), IntensityUnit::Native);
  const std::vector<std::vector<float>> frames{{1, 2},
                                               {200, 7},
                                               {255, 1},
                                               {256, 4},
                                               {3, 4},
                                               {1000, 4},
                                               {0.5, 1000},
                                               {1, 2},
                                               {-3, 5},
                                               {7, 8}};
  double range = 0.0;
  for (const std::vector<float>& intensities : frames) {
    stream.add(row(intensities));
    expectWithinHalfAStep(stream, intensities);
    const IntensityScale& scale = stream.frame.intensity_scale;
    const double new_range = double{scale.step} * scale.maxSymbol();
    EXPECT_GE(new_range, range);
    range = new_range;
  }
  const IntensityScale scale = stream.frame.intensity_scale;
  stream.add(row({1, 2}));
  EXPECT_TRUE(stream.frame.intensity_scale == scale) << "a new scale costs bytes";
}

TEST(IntensityQuantiser, ScalesThatAreFarTooWideAreFittedAnew)
{
  const std::vector<float> fractions{0.1f, 0.7f, 0.3333f, 0.9f, -0.25f};
  for (const float lowest : {0.0f, -1.0f})
    for (const IntensityCurve curve :
         {IntensityCurve::Linear, IntensityCurve::Companded}) {
      IntensityCompressionSettings settings = settingsOf(1.0);
      settings.intensity_curve = curve;
      Stream stream(settings, IntensityUnit::Native);
      stream.add(row({lowest, 0.3f, 1e8f}));
      const IntensityScale wide = stream.frame.intensity_scale;
      stream.add(row({lowest, 0.3f, 3e7f})); // has use for it
      EXPECT_TRUE(stream.frame.intensity_scale == wide);
      stream.add(row({0.0f, 0.0f})); // would be the same in any scale
      EXPECT_TRUE(stream.frame.intensity_scale == wide);
      std::vector<float> values = fractions;
      values.back() = lowest;
      stream.add(row(values));
      EXPECT_LT(stream.frame.intensity_scale.step, 0.01f);
      EXPECT_EQ(stream.statistics.intensities_vanished, 0u);
      if (curve == IntensityCurve::Linear)
        expectWithinHalfAStep(stream, values);
    }
}

TEST(IntensityQuantiser, NegativeValuesThatVanishAreCounted)
{
  Stream stream(settingsOf(1.0), IntensityUnit::Native);
  stream.add(row({-1e8f, 1e8f, 0.0f, 0.3f, -0.3f, 5.0f, -3000.0f}));
  EXPECT_EQ(stream.statistics.intensities_vanished, 3u); // of a step of 4096
}

TEST(IntensityQuantiser, ExplicitBitsAndRanges)
{
  const std::vector<float> intensities{0.0f, 12.5f, 50.0f, 99.0f, 100.0f};
  for (const auto unit :
       {IntensityUnit::Native, IntensityUnit::Share, IntensityUnit::Points})
    for (unsigned int bits = 1; bits <= 16; ++bits) {
      IntensityCompressionSettings settings = settingsOf(1.0);
      settings.intensity_bits = bits;
      settings.intensity_range = 100.0f;
      Stream stream(settings, unit);
      stream.add(row(intensities));
      const double shown = unit == IntensityUnit::Share ? 255.0 : 1.0;
      EXPECT_EQ(stream.frame.intensity_scale.bits, bits);
      EXPECT_NEAR(double{stream.frame.intensity_scale.step} * (std::exp2(bits) - 1.0),
                  100.0 * shown,
                  1e-3);
      EXPECT_EQ(stream.frame.intensities.back(),
                stream.frame.intensity_scale.maxSymbol());
      std::vector<float> expected;
      for (const float intensity : intensities)
        expected.push_back(intensity * static_cast<float>(shown));
      expectWithinHalfAStep(stream, expected);

      stream.add(row({250.0f, 1.0f, 1e30f}));
      EXPECT_EQ(stream.statistics.intensities_out_of_range, 2u);
      EXPECT_EQ(stream.frame.intensities[0], stream.frame.intensity_scale.maxSymbol());
    }
}

TEST(IntensityQuantiser, AnyPositiveRangeMakesAScale)
{
  for (const float range : {std::numeric_limits<float>::denorm_min(),
                            std::numeric_limits<float>::min(),
                            1e-30f,
                            1.0f,
                            1e30f,
                            largest})
    for (const unsigned int bits : {0u, 1u, 8u, 16u})
      for (const auto curve : {IntensityCurve::Linear, IntensityCurve::Companded}) {
        IntensityCompressionSettings settings = settingsOf(1.0);
        settings.intensity_range = range;
        settings.intensity_bits = bits;
        settings.intensity_curve = curve;
        Stream stream(settings, IntensityUnit::Native);
        stream.add(row({range / 2.0f})); // expects a consistent frame
        EXPECT_EQ(stream.frame.size(), 1u) << range << ", " << bits << " bits";
      }
}

TEST(IntensityQuantiser, ExplicitBitsAlone)
{
  IntensityCompressionSettings settings = settingsOf(1.0);
  settings.intensity_bits = 4;
  Stream counts(settings, IntensityUnit::Points);
  counts.add(Cloud(20, Point{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(counts.values().begin()->second, 15.0f);
  EXPECT_EQ(counts.statistics.intensities_out_of_range, 1u);
  Stream shares(settings, IntensityUnit::Share);
  shares.add(row({0.2f, 1.0f, 1.5f}));
  EXPECT_EQ(shares.frame.intensities, (std::vector<std::uint16_t>{3, 15, 15}));
  EXPECT_EQ(shares.values().at({1, 0, 0}), 255.0f);
}

} // namespace

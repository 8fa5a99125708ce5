// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/voxel_frame.h>

#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;
using Values = std::vector<float>;

constexpr double resolution = 0.04;

struct SymbolInterval {
  SymbolInterval(const IntensityScale& scale, std::uint32_t symbol)
  {
    std::uint32_t first = symbol;
    std::uint32_t end = symbol + 1;
    if (scale.companded_range != 0) {
      first = compandedEdge(scale.bits, scale.companded_range, symbol);
      end = compandedEdge(scale.bits, scale.companded_range, symbol + 1);
    }
    // What lies beyond an end of the scale is at that end.
    const auto offset = double{scale.offset};
    const auto step = double{scale.step};
    low = symbol == 0 ? -1e30 : offset + step * (first - 0.501) - 1e-3;
    high = symbol == scale.maxSymbol() ? 1e30 : offset + step * (end - 0.499) + 1e-3;
  }

  double low;
  double high;
};

using Intensities = std::vector<float>;

/** \brief Expects the symbols of all voxels to hold what a function makes of the
 * intensities of the voxel's points, with each number of bits on both scales. */
template <typename IntensityOfVoxel>
void
expectSymbolsToHold(IntensityUnit unit,
                    Aggregation aggregation,
                    const std::vector<Cloud>& clouds,
                    IntensityOfVoxel intensity_of)
{
  for (const auto curve : {IntensityCurve::Linear, IntensityCurve::Companded})
    for (unsigned int bits = 0; bits <= 16; ++bits) {
      SCOPED_TRACE(std::to_string(bits) + " bits" +
                   (curve == IntensityCurve::Companded ? ", companded" : ""));
      IntensityCompressionSettings settings = settingsOf(resolution);
      settings.aggregation = aggregation;
      settings.intensity_bits = bits;
      settings.intensity_curve = curve;
      Stream stream(settings, unit);
      for (const Cloud& cloud : clouds) {
        const VoxelFrame& frame = stream.add(cloud);
        const auto voxels = naiveVoxels(cloud, resolution);
        ASSERT_EQ(frame.size(), voxels.size());
        for (std::size_t i = 0; i < frame.size(); ++i) {
          const Intensities& intensities = voxels.at(latticeIndex(frame, i));
          const SymbolInterval interval(frame.intensity_scale, frame.intensities[i]);
          ASSERT_GE(intensity_of(intensities), interval.low);
          ASSERT_LE(intensity_of(intensities), interval.high);
        }
      }
    }
}

double
meanOf(const Intensities& intensities)
{
  return sumOf(intensities) / static_cast<double>(intensities.size());
}

/** \brief Clouds with up to 300 points in a voxel and intensities of 0 to 1. */
std::vector<Cloud>
clouds()
{
  std::vector<Cloud> clouds;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    clouds.push_back(randomCloud(seed, -0.2, 0.2, 2000));
    std::mt19937_64 random(seed);
    for (int points = 3; points <= 300; points += 11)
      for (int i = 0; i < points; ++i)
        clouds.back().push_back({0.5f + 0.04f * static_cast<float>(points / 11),
                                 0.42f,
                                 0.02f,
                                 uniform(random, 0.0, 0.02)});
  }
  return clouds;
}

TEST(IntensityScales, HoldCounts)
{
  std::vector<Cloud> ones;
  for (const Cloud& cloud : clouds())
    ones.push_back(withoutIntensities(cloud));
  expectSymbolsToHold(IntensityUnit::Points, Aggregation::Automatic, ones, sumOf);
}

TEST(IntensityScales, HoldShares)
{
  expectSymbolsToHold(IntensityUnit::Share,
                      Aggregation::Automatic,
                      clouds(),
                      [](const Intensities& shares) { return 255.0 * sumOf(shares); });
}

TEST(IntensityScales, HoldNativeMeansAndSums)
{
  std::vector<Cloud> native = clouds();
  for (Point& point : native[0])
    point.intensity = std::round(255.0f * point.intensity);
  for (Point& point : native[1])
    point.intensity = std::round(65535.0f * point.intensity);
  for (Point& point : native[2])
    point.intensity = 0.5f - 100.0f * point.intensity; // fractions of both signs
  expectSymbolsToHold(IntensityUnit::Native, Aggregation::Mean, native, meanOf);
  expectSymbolsToHold(IntensityUnit::Native, Aggregation::Sum, native, sumOf);
}

constexpr std::size_t voxels = 1000; // 3 are few

/** \brief Multiples of a step, 0 to 200 of them, and other values after these. */
Values
valuesWith(const Values& others, float step = 1.0f)
{
  Values values;
  for (std::size_t i = 0; i < voxels - others.size(); ++i)
    values.push_back(static_cast<float>(i % 201) * step);
  values.insert(values.end(), others.begin(), others.end());
  return values;
}

void
expectScale(const IntensityCompressionSettings& settings,
            const Values& values,
            const IntensityScale& scale,
            std::size_t out_of_range)
{
  Stream stream(settings, IntensityUnit::Native);
  stream.add(row(values));
  EXPECT_EQ(stream.frame.intensity_scale.offset, scale.offset);
  EXPECT_FLOAT_EQ(stream.frame.intensity_scale.step, scale.step);
  EXPECT_EQ(stream.frame.intensity_scale.bits, scale.bits);
  EXPECT_EQ(stream.frame.intensity_scale.companded_range, scale.companded_range);
  EXPECT_EQ(stream.statistics.intensities_out_of_range, out_of_range);
}

struct Case {
  Values others;
  IntensityScale scale;
  std::size_t out_of_range;
};

void
expectScales(const IntensityCompressionSettings& settings,
             float step,
             const std::vector<Case>& cases)
{
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::PrintToString(c.others));
    expectScale(settings, valuesWith(c.others, step), c.scale, c.out_of_range);
  }
}

TEST(AutomaticScales, FewFarValuesAreLeftOutOfWholeNumbers)
{
  expectScales(settingsOf(1.0),
               1.0f,
               {{{-1}, {-1, 1, 8, 0}, 0},
                {{-15}, {-16, 1, 8, 0}, 0},
                {{-999, -999, -999}, {-1024, 1, 11, 0}, 0},
                {{-4080}, {-4096, 1, 13, 0}, 0},
                {{-4081}, {0, 1, 8, 0}, 1},
                {{-largest, largest}, {0, 1, 8, 0}, 2},
                {{-1, -9999}, {-1, 1, 8, 0}, 1},
                {{65535}, {0, 1, 16, 0}, 0},
                {{65536}, {0, 1, 8, 0}, 1},
                {{-1, 65535}, {-1, 1, 8, 0}, 1},
                {{1000, 1e6f}, {0, 1, 10, 0}, 1}});
}

TEST(AutomaticScales, MoreThanOneIn256AreHeld)
{
  expectScales(settingsOf(1.0),
               1.0f,
               {{{-9999, -9999, -9999, -9999}, {-16384, 1, 15, 0}, 0},
                {{1e6f, 1e6f, 1e6f, 1e6f}, {0, 1048576.0f / 65535.0f, 16, 0}, 0}});
  Values few = valuesWith({-9999});
  few.erase(few.begin(), few.end() - 255);
  expectScale(settingsOf(1.0), few, {-16384, 1, 15, 0}, 0);
}

TEST(AutomaticScales, FewFarValuesDoNotMakeStepsOfFractionsLarger)
{
  // To 0.97.
  expectScales(settingsOf(1.0),
               0.00485f,
               {{{-1}, {-1, 2.0f / 65535.0f, 16, 0}, 0},
                {{-15}, {-16, 32.0f / 65535.0f, 16, 0}, 0},
                {{-16}, {0, 1.0f / 65535.0f, 16, 0}, 1},
                {{15}, {0, 16.0f / 65535.0f, 16, 0}, 0},
                {{65535}, {0, 1.0f / 65535.0f, 16, 0}, 1},
                {{65535, 65535, 65535, 65535}, {0, 65536.0f / 65535.0f, 16, 0}, 0}});
  IntensityCompressionSettings settings = settingsOf(1.0);
  settings.intensity_curve = IntensityCurve::Companded;
  expectScales(settings,
               1.0f,
               {{{-13}, {-16, 1, 4, 255}, 0},
                {{-4000}, {0, 1, 4, 255}, 1},
                {{3000}, {0, 1, 4, 4095}, 0},
                {{4000}, {0, 1, 4, 255}, 1}});
}

TEST(AutomaticScales, EqualValues)
{
  const IntensityCompressionSettings settings = settingsOf(1.0);
  expectScale(settings, Values(voxels, -1.0f), {-1, 1, 8, 0}, 0);
  expectScale(settings, Values(voxels, 7.0f), {0, 1, 8, 0}, 0);
  Values values(voxels, 0.0f); // no width that others could be far from
  values.back() = -999.0f;
  expectScale(settings, values, {-1024, 1, 11, 0}, 0);
  values.back() = nan_value;
  expectScale(settings, values, {0, 1, 8, 0}, 0);
}

TEST(AutomaticScales, WithARangeAllNegativeValuesAreHeld)
{
  IntensityCompressionSettings settings = settingsOf(1.0);
  settings.intensity_range = 255.0f;
  Stream stream(settings, IntensityUnit::Native);
  stream.add(row(valuesWith({-999})));
  EXPECT_EQ(stream.frame.intensity_scale.offset, -1024.0f);
  EXPECT_EQ(stream.statistics.intensities_out_of_range, 0u);
}

TEST(AutomaticScales, LaterFarValuesDoNotChangeTheScaleNorOtherSymbols)
{
  Stream stream(settingsOf(1.0), IntensityUnit::Native);
  stream.add(row(valuesWith({0})));
  const VoxelFrame first = stream.frame;
  stream.add(row(valuesWith({-9999})));
  EXPECT_EQ(stream.frame.intensity_scale, first.intensity_scale);
  EXPECT_EQ(stream.frame.intensities, first.intensities); // it became 0
  EXPECT_EQ(stream.statistics.intensities_out_of_range, 1u);
}

} // namespace

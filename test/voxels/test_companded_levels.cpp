// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_frame.h>

#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;

using Edges = std::vector<std::uint32_t>;

/** \brief All edges of a scale, the one after the last level among them. */
Edges
edgesOf(unsigned int bits, std::uint32_t range)
{
  Edges edges;
  for (std::uint32_t level = 0; level <= std::uint32_t{1} << bits; ++level)
    edges.push_back(compandedEdge(bits, range, level));
  return edges;
}

/** \brief The edges as the specification has them, computed without a product that
 * might overflow: the quotient digit by digit. */
Edges
specifiedEdges(unsigned int bits, std::uint32_t range)
{
  const std::uint64_t levels = std::uint64_t{1} << bits;
  if (levels == 2)
    return {0, 1, range + 1};
  if (levels == 4)
    return {0, 1, 2, 4, range + 1};
  Edges edges{0, 1, 2, 3};
  const std::uint64_t n = levels - 4;
  for (std::uint64_t j = 0; j <= n; ++j) {
    // floor(excess j^2 / n^2): each bit of excess, the highest first.
    const std::uint64_t excess = range - 3 - n;
    const std::uint64_t numerator = j * j;
    const std::uint64_t denominator = n * n;
    std::uint64_t quotient = 0;
    std::uint64_t remainder = 0;
    for (int bit = 16; bit >= 0; --bit) {
      quotient *= 2;
      remainder = 2 * remainder + ((excess >> bit & 1) != 0 ? numerator : 0);
      for (; remainder >= denominator; remainder -= denominator)
        ++quotient;
    }
    edges.push_back(static_cast<std::uint32_t>(4 + j + quotient));
  }
  return edges;
}

/** \brief Ranges that a number of bits can have: the ends, and some between. */
std::set<std::uint32_t>
rangesOf(unsigned int bits)
{
  const std::uint32_t lowest = std::uint32_t{1} << bits;
  std::set<std::uint32_t> ranges{
      lowest, lowest + 1, lowest + 2, lowest + lowest / 2, 65534, 65535};
  std::mt19937_64 random(bits);
  for (int i = 0; i < 20; ++i)
    ranges.insert(lowest + static_cast<std::uint32_t>(random() % (65536 - lowest)));
  for (const std::uint32_t usual : {254u, 255u, 4095u})
    if (usual >= lowest)
      ranges.insert(usual);
  return ranges;
}

TEST(CompandedLevels, EdgesOfCounts)
{
  EXPECT_EQ(edgesOf(1, 254), (Edges{0, 1, 255}));
  EXPECT_EQ(edgesOf(2, 254), (Edges{0, 1, 2, 4, 255}));
  EXPECT_EQ(edgesOf(3, 254), (Edges{0, 1, 2, 3, 4, 20, 67, 145, 255}));
  EXPECT_EQ(edgesOf(4, 254),
            (Edges{0, 1, 2, 3, 4, 6, 12, 21, 34, 50, 69, 92, 118, 147, 179, 215, 255}));
}

TEST(CompandedLevels, EdgesAndMiddlesAreThoseOfTheSpecification)
{
  for (unsigned int bits = 1; bits <= 15; ++bits)
    for (const std::uint32_t range : rangesOf(bits)) {
      SCOPED_TRACE(std::to_string(bits) + " bits, range " + std::to_string(range));
      const Edges edges = specifiedEdges(bits, range);
      ASSERT_EQ(edgesOf(bits, range), edges);
      for (std::uint32_t level = 0; level + 1 < edges.size(); ++level)
        ASSERT_EQ(compandedMiddle(bits, range, level),
                  (edges[level] + edges[level + 1] - 1) / 2);
    }
}

// ---------------------------------------------------------------- quantising

IntensityCompressionSettings
compandedSettings(unsigned int bits, double resolution = 1.0)
{
  IntensityCompressionSettings settings = settingsOf(resolution);
  settings.intensity_curve = IntensityCurve::Companded;
  settings.intensity_bits = bits;
  return settings;
}

Cloud
rowOfCounts(const std::vector<std::size_t>& counts)
{
  Cloud cloud;
  for (std::size_t voxel = 0; voxel < counts.size(); ++voxel)
    cloud.insert(cloud.end(),
                 counts[voxel],
                 Point{0.5f + static_cast<float>(voxel), 0.5f, 0.5f, 1.0f});
  return cloud;
}

std::vector<std::size_t>
countsTo(std::size_t last)
{
  std::vector<std::size_t> counts;
  for (std::size_t count = 1; count <= last; ++count)
    counts.push_back(count);
  return counts;
}

std::vector<float>
rowOf(const Stream& stream)
{
  std::vector<float> intensities;
  for (const auto& voxel : stream.values())
    intensities.push_back(voxel.second);
  return intensities;
}

TEST(CompandedLevels, FourBitsAreAutomatic)
{
  for (const auto unit :
       {IntensityUnit::Points, IntensityUnit::Share, IntensityUnit::Native}) {
    Stream stream(compandedSettings(0), unit);
    stream.add(row({0.1f, 0.7f, 0.9f}));
    EXPECT_EQ(stream.frame.intensity_scale.bits, 4u);
    EXPECT_NE(stream.frame.intensity_scale.companded_range, 0u);
  }
}

/** \brief Counts, or sums of points that carry 1, which the class takes for counts. */
struct CountStream {
  IntensityUnit unit;
  float range;
};

class CompandedCounts : public testing::TestWithParam<CountStream> {
protected:
  static Stream
  streamOf(unsigned int bits)
  {
    IntensityCompressionSettings settings = compandedSettings(bits);
    settings.intensity_range = GetParam().range;
    if (GetParam().unit == IntensityUnit::Native)
      settings.aggregation = Aggregation::Sum;
    return Stream(settings, GetParam().unit);
  }
};

TEST_P(CompandedCounts, DecisionsAtSmallThresholdsNeverChange)
{
  const std::vector<std::size_t> counts = countsTo(300);
  for (unsigned int bits = 1; bits <= 16; ++bits) {
    SCOPED_TRACE(bits);
    Stream stream = streamOf(bits);
    stream.add(rowOfCounts(counts));
    const std::vector<float> intensities = rowOf(stream);
    ASSERT_EQ(intensities.size(), counts.size());
    const std::vector<float> thresholds = bits == 1   ? std::vector<float>{2}
                                          : bits == 2 ? std::vector<float>{2, 3, 5}
                                                      : std::vector<float>{2, 3, 4, 5};
    for (std::size_t i = 0; i < counts.size(); ++i)
      for (const float threshold : thresholds)
        ASSERT_EQ(intensities[i] >= threshold,
                  static_cast<float>(counts[i]) >= threshold)
            << counts[i];
  }
}

TEST_P(CompandedCounts, SmallCountsAreExactAndTheOthersOfTheirLevel)
{
  const std::vector<std::size_t> counts = countsTo(255);
  for (unsigned int bits = 3; bits <= 7; ++bits) {
    SCOPED_TRACE(bits);
    Stream stream = streamOf(bits);
    stream.add(rowOfCounts(counts));
    EXPECT_EQ(stream.frame.intensity_scale, (IntensityScale{1.0f, 1.0f, bits, 254}));
    EXPECT_EQ(stream.statistics.intensities_out_of_range, 0u);
    const std::vector<float> intensities = rowOf(stream);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const auto number = static_cast<std::uint32_t>(counts[i] - 1);
      const std::uint32_t level = stream.frame.intensities[i];
      ASSERT_GE(number, compandedEdge(bits, 254, level));
      ASSERT_LT(number, compandedEdge(bits, 254, level + 1));
      ASSERT_EQ(intensities[i],
                static_cast<float>(1 + compandedMiddle(bits, 254, level)));
      if (counts[i] < 5) {
        ASSERT_EQ(intensities[i], static_cast<float>(counts[i]));
      }
      if (i > 0) {
        ASSERT_GE(intensities[i], intensities[i - 1]);
      }
    }
    stream.add(rowOfCounts({255, 256, 1000}));
    if (GetParam().range == 0.0f) {
      EXPECT_EQ(stream.frame.intensity_scale, (IntensityScale{1.0f, 1.0f, bits, 1022}));
      EXPECT_EQ(stream.statistics.intensities_out_of_range, 0u);
      continue;
    }
    EXPECT_EQ(stream.statistics.intensities_out_of_range, 2u);
    for (const std::uint16_t symbol : stream.frame.intensities)
      EXPECT_EQ(symbol, stream.frame.intensity_scale.maxSymbol());
  }
}

TEST_P(CompandedCounts, BitsThatAreEnoughAreLinear)
{
  for (unsigned int bits = 8; bits <= 16; ++bits) {
    Stream stream = streamOf(bits);
    stream.add(rowOfCounts(countsTo(255)));
    EXPECT_EQ(stream.frame.intensity_scale, (IntensityScale{1.0f, 1.0f, bits, 0}));
    const std::vector<float> intensities = rowOf(stream);
    for (std::size_t i = 0; i < intensities.size(); ++i)
      ASSERT_EQ(intensities[i], static_cast<float>(i + 1));
  }
}

INSTANTIATE_TEST_SUITE_P(CompandedLevels,
                         CompandedCounts,
                         testing::Values(CountStream{IntensityUnit::Points, 0.0f},
                                         CountStream{IntensityUnit::Points, 255.0f},
                                         CountStream{IntensityUnit::Native, 255.0f}));

TEST(CompandedLevels, CountsTakeTheRangeThatIsSet)
{
  for (const float range : {0.5f, 17.0f, 1000.0f, 65536.0f, 1e6f, 1e30f}) {
    SCOPED_TRACE(range);
    IntensityCompressionSettings settings = compandedSettings(4);
    settings.intensity_range = range;
    Stream stream(settings);
    stream.add(rowOfCounts({1, 2, 20}));
    const IntensityScale& scale = stream.frame.intensity_scale;
    EXPECT_EQ(scale.offset, 1.0f);
    EXPECT_GE(scale.step, 1.0f);
    const float top = scale.offset + scale.step * static_cast<float>(scale.maxNumber());
    EXPECT_GE(top, 0.9999f * range);
    EXPECT_EQ(scale.companded_range != 0, range > 16.0f);
  }
}

TEST(CompandedLevels, SharesAreNumbersOf255)
{
  for (const float range : {0.0f, 1.0f, 4.0f}) {
    IntensityCompressionSettings settings = compandedSettings(4);
    settings.intensity_range = range;
    Stream stream(settings, IntensityUnit::Share);
    const float top = range > 0.0f ? range : 1.0f;
    stream.add(
        row({0.0f, top / 255.0f, 2.0f * top / 255.0f, top / 2.0f, top, 2 * top}));
    EXPECT_EQ(stream.frame.intensity_scale, (IntensityScale{0.0f, top, 4, 255}));
    EXPECT_EQ(stream.frame.intensities[0], 0);
    EXPECT_EQ(stream.frame.intensities[1], 1);
    EXPECT_EQ(stream.frame.intensities[2], 2);
    EXPECT_EQ(stream.frame.intensities[4], 15);
    EXPECT_EQ(stream.statistics.intensities_out_of_range, 1u);
  }
}

TEST(CompandedLevels, NativeScalesFollowTheValues)
{
  struct Case {
    std::vector<float> intensities;
    unsigned int bits;
    IntensityScale scale;
  };
  const std::vector<Case> cases{{{0, 200}, 4, {0.0f, 1.0f, 4, 255}},
                                {{5, 200}, 4, {0.0f, 1.0f, 4, 255}},
                                {{0, 300}, 8, {0.0f, 1.0f, 8, 511}},
                                {{0, 300}, 9, {0.0f, 1.0f, 9, 0}},
                                {{0, 65535}, 15, {0.0f, 1.0f, 15, 65535}},
                                {{0, 65535}, 16, {0.0f, 1.0f, 16, 0}},
                                {{-5, 100}, 4, {-8.0f, 1.0f, 4, 255}},
                                {{0.0f, 127.5f}, 4, {0.0f, 128.0f / 255.0f, 4, 255}},
                                {{0.0f, 0.75f}, 8, {0.0f, 1.0f / 65535.0f, 8, 65535}},
                                {{-0.5f, 0.5f}, 3, {-0.5f, 1.0f / 255.0f, 3, 255}}};
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::PrintToString(c.intensities));
    Stream stream(compandedSettings(c.bits), IntensityUnit::Native);
    stream.add(row(c.intensities));
    const IntensityScale& scale = stream.frame.intensity_scale;
    EXPECT_EQ(scale.offset, c.scale.offset);
    EXPECT_FLOAT_EQ(scale.step, c.scale.step);
    EXPECT_EQ(scale.bits, c.scale.bits);
    EXPECT_EQ(scale.companded_range, c.scale.companded_range);
    EXPECT_EQ(stream.statistics.intensities_out_of_range, 0u);
  }
}

TEST(CompandedLevels, SumsBelow1AreNoCountsFromThenOn)
{
  IntensityCompressionSettings settings = compandedSettings(4);
  settings.aggregation = Aggregation::Sum;
  Stream stream(settings, IntensityUnit::Native);
  stream.add(row({1.0f, 2.0f}));
  EXPECT_EQ(stream.frame.intensity_scale.offset, 1.0f);
  stream.add(row({0.0f, 2.0f}));
  EXPECT_EQ(stream.frame.intensity_scale.offset, 0.0f);
  EXPECT_EQ(rowOf(stream), (std::vector<float>{0.0f, 2.0f}));
  stream.add(row({1.0f, 2.0f}), true);
  EXPECT_EQ(stream.frame.intensity_scale.offset, 0.0f);
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The symbol of each voxel holds its intensity, with any number of bits, on
 * linear and companded scales.
 */
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

constexpr double resolution = 0.04;

/** \brief The intensities that a symbol may stand for. */
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

} // namespace

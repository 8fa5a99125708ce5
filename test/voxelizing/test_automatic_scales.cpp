// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Automatic scales hold all values but few that are far from the others.
 */
#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;

using Values = std::vector<float>;

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
                {{-16}, {0, 1, 8, 0}, 1},
                {{-999, -999, -999}, {0, 1, 8, 0}, 3},
                {{-largest, largest}, {0, 1, 8, 0}, 2},
                {{-1, -999}, {-1, 1, 8, 0}, 1},
                {{65535}, {0, 1, 16, 0}, 0},
                {{65536}, {0, 1, 8, 0}, 1},
                {{-1, 65535}, {-1, 1, 8, 0}, 1},
                {{1000, 1e6f}, {0, 1, 10, 0}, 1}});
}

TEST(AutomaticScales, MoreThanOneIn256AreHeld)
{
  expectScales(settingsOf(1.0),
               1.0f,
               {{{-999, -999, -999, -999}, {-1024, 1, 11, 0}, 0},
                {{1e6f, 1e6f, 1e6f, 1e6f}, {0, 1048576.0f / 65535.0f, 16, 0}, 0}});
  Values few = valuesWith({-999});
  few.erase(few.begin(), few.end() - 255);
  expectScale(settingsOf(1.0), few, {-1024, 1, 11, 0}, 0);
}

TEST(AutomaticScales, FewFarValuesDoNotMakeStepsOfFractionsLarger)
{
  // To 0.97.
  expectScales(settingsOf(1.0),
               0.00485f,
               {{{-1}, {0, 1.0f / 65535.0f, 16, 0}, 1},
                {{15}, {0, 16.0f / 65535.0f, 16, 0}, 0},
                {{65535}, {0, 1.0f / 65535.0f, 16, 0}, 1},
                {{65535, 65535, 65535, 65535}, {0, 65536.0f / 65535.0f, 16, 0}, 0}});
  IntensityCompressionSettings settings = settingsOf(1.0);
  settings.intensity_curve = IntensityCurve::Companded;
  expectScales(settings,
               1.0f,
               {{{-13}, {0, 1, 4, 255}, 1},
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
  stream.add(row(valuesWith({-999})));
  EXPECT_EQ(stream.frame.intensity_scale, first.intensity_scale);
  EXPECT_EQ(stream.frame.intensities, first.intensities); // it became 0
  EXPECT_EQ(stream.statistics.intensities_out_of_range, 1u);
}

} // namespace

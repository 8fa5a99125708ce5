// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The log-odds of pixels against their definition (doc/outlier_removal.md, "Points
 * of lidars"), computed pixel by pixel in double precision.
 */
#include "outliers/range_continuity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace {

using pcl_ext::RangeContinuity;

/** \brief An image of u = ln(1 + range / 2 m). */
struct LogImage {
  int width = 0;
  int height = 0;
  std::vector<double> u; ///< negative: no return

  double
  at(int row, int column) const
  {
    return u[static_cast<std::size_t>(row * width + (column + width) % width)];
  }
};

double
support(double distance, double width)
{
  return std::max(0.0, 1.0 - std::max(distance, 0.0) / width);
}

/** \brief The log-odds of a pixel without the last image. */
double
defined(const LogImage& image, int row, int column)
{
  const double own = image.at(row, column);
  // |u_q - u_p|; large without a return.
  const auto distance = [&](int other_row, int other_column) {
    const double other = image.at(other_row, other_column);
    return other < 0.0 ? 100.0 : std::abs(other - own);
  };
  double in_row = 0.0;
  for (const int side : {-4, -3, -2, -1, 1, 2, 3, 4})
    in_row += support(distance(row, column + side), 0.02);
  double in_columns = 0.0;
  double depth = 0.0;
  int around = 0;
  for (int other_row = row - 2; other_row <= row + 2; ++other_row) {
    if (other_row < 0 || other_row >= image.height)
      continue;
    if (other_row != row)
      in_columns += support(std::min({distance(other_row, column - 1),
                                      distance(other_row, column),
                                      distance(other_row, column + 1)}),
                            0.05);
    if (std::abs(other_row - row) > 1)
      continue;
    for (int other_column = column - 2; other_column <= column + 2; ++other_column) {
      if (other_row == row && other_column == column)
        continue;
      ++around;
      const double other = image.at(other_row, other_column);
      depth += other < 0.0 ? 0.3 : std::clamp(other - own, -1.0, 1.0);
    }
  }
  return 2.5 + 2.0 * std::log(0.3 + in_row) + in_columns -
         1.5 * depth / around * (4.0 - in_columns);
}

/** \brief Ranges of surfaces with steps as large as the tolerances, jumps, and gaps; all
 * gaps and jumps also at the ends of rows. */
std::vector<float>
randomRanges(std::uint32_t width, std::uint32_t height, std::mt19937& generator)
{
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  std::vector<float> ranges;
  float surface = 5.0f;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    if (uniform(generator) < 0.1f)
      surface = std::exp(6.0f * uniform(generator));
    const float range = surface * (1.0f + 0.08f * (uniform(generator) - 0.5f));
    ranges.push_back(uniform(generator) < 0.15f ? 0.0f : range);
  }
  // Rows go on in the rows above.
  for (std::uint32_t i = width; i < width * height; ++i)
    if (uniform(generator) < 0.7f)
      ranges[i] = ranges[i - width] * (1.0f + 0.08f * (uniform(generator) - 0.5f));
  return ranges;
}

struct Size {
  std::uint32_t width;
  std::uint32_t height;
};

// Of one chunk and several, whole ones and not; with fewer rows than are looked at.
const Size sizes[] = {{64, 5}, {16, 1}, {17, 2}, {63, 3}, {65, 4}, {150, 9}, {192, 6}};

/** \brief The image of the rounded logarithms of ranges; pixels without a return are
 * -1. */
LogImage
imageOf(const std::vector<float>& ranges, const Size& size)
{
  LogImage image{static_cast<int>(size.width), static_cast<int>(size.height), {}};
  for (const float range : ranges) {
    if (range == 0.0f) {
      image.u.push_back(-1.0);
      continue;
    }
    int exponent = 0;
    // A mantissa of 2^-10 and a half; ranges beyond eight octaves are like those of the
    // last step.
    const double mantissa =
        std::frexp(static_cast<double>(1.0f + range / 2.0f), &exponent);
    const double stepped = (std::floor(2048.0 * mantissa) + 0.5) / 2048.0;
    const double ratio =
        std::min(std::ldexp(stepped, exponent), std::ldexp(2047.5 / 2048.0, 8));
    image.u.push_back(static_cast<double>(std::lround(1000.0 * std::log(ratio))) /
                      1000.0);
  }
  return image;
}

/** \brief How well the best of 3 x 9 pixels of the last image agrees. */
double
seenBefore(const LogImage& last, int row, int column, double own)
{
  double best = 0.0;
  for (int other_row = std::max(row - 1, 0);
       other_row <= std::min(row + 1, last.height - 1);
       ++other_row)
    for (int side = -4; side <= 4; ++side)
      if (const double other = last.at(other_row, column + side); other >= 0.0)
        best = std::max(best, support(std::abs(other - own), 0.05));
  return best;
}

TEST(RangeContinuity, IsWhatIsDefinedWithAndWithoutTheLastImage)
{
  std::mt19937 generator(8);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  std::size_t changed = 0;
  for (const Size& size : sizes) {
    RangeContinuity continuity;
    LogImage last;
    std::vector<float> ranges = randomRanges(size.width, size.height, generator);
    // All goes on in the first row, so that the sensor is known to stand still.
    std::fill(ranges.begin(), ranges.begin() + size.width, 900.0f);
    for (int frame = 0; frame < 3; ++frame) {
      const LogImage image = imageOf(ranges, size);
      std::vector<float> log_odds;
      continuity.score(ranges, size.width, size.height, true, log_odds);
      for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column) {
          const auto i = static_cast<std::size_t>(row * image.width + column);
          if (ranges[i] == 0.0f) {
            EXPECT_EQ(log_odds[i], 0.0f);
            continue;
          }
          double expected = defined(image, row, column);
          // There rounding decides whether the last image is looked at.
          if (std::abs(expected - 6.0) < 1e-4)
            continue;
          if (frame > 0) {
            const double seen = seenBefore(last, row, column, image.at(row, column));
            expected += expected < 6.0 ? 2.5 * seen - 1.5 : 1.0;
            changed += seen < 0.5 ? 1 : 0;
          }
          // Floats of at most 30.
          EXPECT_NEAR(log_odds[i], expected, 3e-5) << size.width << ' ' << i;
        }
      last = image;
      // Flakes, but in the first row.
      for (std::size_t i = size.width; i < ranges.size(); ++i)
        if (uniform(generator) < 0.03f)
          ranges[i] = 1.0f + 3.0f * uniform(generator);
    }
  }
  EXPECT_GT(changed, 20u);
}

TEST(RangeContinuity, NothingIsKnownOfASensorWhoseLastImageWasNearlyEmpty)
{
  std::vector<float> wall(std::size_t{128} * 8, 7.0f);
  std::vector<float> part(wall.size(), 0.0f);
  std::fill_n(part.begin() + 298, 9, 7.0f);
  RangeContinuity continuity;
  std::vector<float> log_odds;
  continuity.score(wall, 128, 8, false, log_odds);
  const std::vector<float> alone = log_odds;
  for (const auto& last : {part, std::vector<float>(wall.size(), 0.0f)}) {
    continuity.score(last, 128, 8, true, log_odds);
    continuity.score(wall, 128, 8, true, log_odds);
    EXPECT_EQ(log_odds, alone);
  }
}

} // namespace

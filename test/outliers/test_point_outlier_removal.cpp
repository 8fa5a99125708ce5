// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/point_outlier_removal.h>

#include "outliers/range_continuity.h"
#include "support/lidar_room.h"
#include "support/test_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using test::failEachAllocation;
using test::Hit;
using test::LidarRoom;
using test::LidarScan;

PointOutlierRemovalSettings
withoutHistory()
{
  PointOutlierRemovalSettings settings;
  settings.use_history = false;
  return settings;
}

std::vector<float>
judgedBy(PointOutlierRemoval& removal, const LidarScan& scan)
{
  std::vector<float> log_odds;
  const OutlierRemovalStatus status = removal.score(scan.view(), log_odds);
  EXPECT_TRUE(status.ok()) << status.message();
  return log_odds;
}

std::vector<float>
judgedAlone(const LidarScan& scan)
{
  PointOutlierRemoval removal(withoutHistory());
  return judgedBy(removal, scan);
}

std::map<Hit, double>
removedShares(const LidarScan& scan, const std::vector<float>& log_odds)
{
  std::map<Hit, double> all;
  std::map<Hit, double> removed;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    all[scan.hits[i]] += 1.0;
    removed[scan.hits[i]] += log_odds[i] < 0.0f ? 1.0 : 0.0;
  }
  for (auto& [hit, count] : removed)
    count /= all[hit];
  return removed;
}

LidarRoom
snowyRoom(unsigned int seed)
{
  LidarRoom room;
  room.snow = 0.04;
  room.has_pole = true;
  room.has_person = true;
  room.seed = seed;
  return room;
}

TEST(PointOutlierRemoval, SnowIsRemovedAndSurfacesStay)
{
  const LidarScan scan = snowyRoom(1).scan();
  PointOutlierRemoval removal;
  const std::vector<float> log_odds = judgedBy(removal, scan);
  std::map<Hit, double> removed = removedShares(scan, log_odds);
  // 98 % in this scan; what is left floats just in front of a wall.
  EXPECT_GT(removed[Hit::Snow], 0.95);
  EXPECT_LT(removed[Hit::Wall], 0.001);
  EXPECT_EQ(removed[Hit::Pole], 0.0);
  EXPECT_EQ(removed[Hit::Person], 0.0);
  std::size_t below = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    below += log_odds[i] < 0.0f ? 1 : 0;
    EXPECT_EQ(std::isinf(log_odds[i]), scan.hits[i] == Hit::None);
  }
  std::vector<float> again;
  EXPECT_EQ(PointOutlierRemoval().score(scan.view(), again).removed, below);
  EXPECT_EQ(again, log_odds);
}

TEST(PointOutlierRemoval, AStandingSensorRemovesMoreSnow)
{
  PointOutlierRemoval removal;
  judgedBy(removal, snowyRoom(1).scan());
  for (unsigned int seed = 2; seed < 5; ++seed) {
    const LidarScan scan = snowyRoom(seed).scan();
    std::map<Hit, double> alone = removedShares(scan, judgedAlone(scan));
    std::map<Hit, double> after = removedShares(scan, judgedBy(removal, scan));
    EXPECT_GT(after[Hit::Snow], alone[Hit::Snow]);
    EXPECT_LT(after[Hit::Wall], 0.001);
    EXPECT_EQ(after[Hit::Person], 0.0);
  }
}

TEST(PointOutlierRemoval, ASensorThatMovesHasNoHistory)
{
  PointOutlierRemoval removal;
  LidarRoom room = snowyRoom(1);
  for (unsigned int frame = 0; frame < 3; ++frame) {
    const LidarScan scan = room.scan();
    EXPECT_EQ(judgedBy(removal, scan), judgedAlone(scan));
    room.x += 1.0;
    ++room.seed;
  }
}

TEST(PointOutlierRemoval, TheHistoryEndsWithResetOtherSizesAndCloudsWithoutRows)
{
  const LidarScan first = snowyRoom(1).scan();
  const LidarScan second = snowyRoom(2).scan();
  LidarRoom other_room = snowyRoom(3);
  other_room.height = 20;
  const LidarScan other = other_room.scan();
  const std::vector<float> alone = judgedAlone(second);
  PointOutlierRemoval removal;
  judgedBy(removal, first);
  EXPECT_NE(judgedBy(removal, second), alone);
  removal.reset();
  EXPECT_EQ(judgedBy(removal, second), alone);
  judgedBy(removal, other);
  EXPECT_EQ(judgedBy(removal, second), alone);
  std::vector<float> log_odds;
  EXPECT_EQ(removal.score(io::PointView(), log_odds).code(),
            OutlierRemovalCode::NoImage);
  EXPECT_EQ(judgedBy(removal, second), alone);
  PointOutlierRemoval moved = std::move(removal);
  EXPECT_NE(judgedBy(moved, first), judgedAlone(first));
}

TEST(PointOutlierRemoval, ThresholdsMustBeFinite)
{
  const LidarScan scan = snowyRoom(1).scan();
  const float endless = std::numeric_limits<float>::infinity();
  const std::pair<float, std::string> cases[] = {
      {std::numeric_limits<float>::quiet_NaN(), "nan"},
      {endless, "inf"},
      {-endless, "-inf"}};
  for (const auto& [value, text] : cases) {
    PointOutlierRemovalSettings settings;
    settings.min_log_odds = value;
    EXPECT_EQ(checkSettings(settings).code(), OutlierRemovalCode::InvalidSettings);
    PointOutlierRemoval removal(settings);
    std::vector<float> log_odds = {1.0f};
    const OutlierRemovalStatus status = removal.score(scan.view(), log_odds);
    EXPECT_EQ(status.code(), OutlierRemovalCode::InvalidSettings);
    EXPECT_EQ(status.message(),
              "min_log_odds is " + text + "; it must be a finite number");
    EXPECT_EQ(status.removed, 0u);
    EXPECT_EQ(log_odds, std::vector<float>(scan.size(), endless));
  }
  // Any other is one.
  PointOutlierRemovalSettings settings;
  settings.min_log_odds = 1e30f;
  std::vector<float> log_odds;
  const OutlierRemovalStatus status =
      PointOutlierRemoval(settings).score(scan.view(), log_odds);
  EXPECT_TRUE(status.ok());
  std::size_t returns = 0;
  for (const Hit hit : scan.hits)
    returns += hit != Hit::None ? 1 : 0;
  EXPECT_EQ(status.removed, returns);
}

TEST(PointOutlierRemoval, MemoryThatRunsOutEndsTheHistory)
{
  LidarRoom room = snowyRoom(1);
  room.width = 80;
  room.height = 10;
  const LidarScan first = room.scan();
  room.width = 90;
  room.height = 12;
  const LidarScan large = room.scan();
  const std::vector<float> large_alone = judgedAlone(large);
  // Without rows and columns, which needs most memory. The image becomes larger.
  const auto unorganised = [](const LidarScan& scan) {
    io::PointView points = scan.view();
    points.image = {};
    return points;
  };
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  const std::size_t failures = failEachAllocation(
      [&] {
        {
          const test::Exemption exemption;
          removal = PointOutlierRemoval();
          EXPECT_TRUE(removal.score(unorganised(first), log_odds).ok());
          log_odds = {};
        }
        removal.score(unorganised(large), log_odds);
      },
      [&] {
        EXPECT_TRUE(removal.score(unorganised(large), log_odds).ok());
        EXPECT_EQ(log_odds, large_alone);
      });
  EXPECT_GT(failures, 10u);
}

// The log-odds of pixels against their definition (doc/outlier_removal.md, "Points of
// lidars"), computed pixel by pixel in double precision.

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

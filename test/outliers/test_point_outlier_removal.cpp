// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/point_outlier_removal.h>

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

} // namespace

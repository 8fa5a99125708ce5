#include "noise/range_filters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::noise;

/** \brief A rough floor around the sensor and points in the air, up to 30 m away. */
Centres::Ptr
floorAndFlakes()
{
  std::mt19937 random(11);
  const auto share = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  Centres::Ptr points(new Centres);
  for (int i = 0; i < 400; ++i) {
    const float range = 1.0f + 29.0f * share();
    const float turn = 0.5f * share();
    const float height = i % 8 == 0 ? 4.0f * share() : -2.0f + 0.02f * share();
    pcl::PointXYZI point;
    point.x = range * std::cos(turn);
    point.y = range * std::sin(turn);
    point.z = height;
    points->push_back(point);
  }
  return points;
}

double
distance(const pcl::PointXYZI& a, const pcl::PointXYZI& b)
{
  const double x = double(a.x) - double(b.x);
  const double y = double(a.y) - double(b.y);
  const double z = double(a.z) - double(b.z);
  return std::sqrt(x * x + y * y + z * z);
}

TEST(RangeFilters, RadiusFollowsTheHorizontalRange)
{
  const Centres::Ptr points = floorAndFlakes();
  RangeRadius radius;
  radius.multiplier = 4.0;
  radius.azimuth_step = 0.7;
  radius.least = 0.25;
  std::vector<float> scores;
  rangeRadiusScores(points, radius, scores);
  ASSERT_EQ(scores.size(), points->size());
  std::size_t with_least = 0;
  std::size_t scored = 0;
  for (std::size_t i = 0; i < points->size(); ++i) {
    const pcl::PointXYZI& point = (*points)[i];
    const double grown = 4.0 * 0.7 * 3.14159265358979 / 180.0 *
                         std::sqrt(double(point.x) * double(point.x) +
                                   double(point.y) * double(point.y));
    const double reach = grown < 0.25 ? 0.25 : grown;
    with_least += grown < 0.25 ? 1 : 0;
    int neighbours = 0;
    for (std::size_t k = 0; k < points->size(); ++k)
      neighbours += k != i && distance(point, (*points)[k]) < reach ? 1 : 0;
    ASSERT_EQ(scores[i], static_cast<float>(neighbours)) << i;
    scored += neighbours > 0 ? 1 : 0;
  }
  // Both branches, and points with and without neighbours, are there.
  EXPECT_GT(with_least, 20u);
  EXPECT_GT(scored, 100u);
  EXPECT_LT(scored, points->size());
}

TEST(RangeFilters, StatisticsFollowTheRange)
{
  const Centres::Ptr points = floorAndFlakes();
  RangeStatistics statistics;
  statistics.neighbours = 4;
  statistics.deviations = 0.7;
  std::vector<float> scores;
  rangeStatisticsScores(points, statistics, scores);
  std::vector<double> means;
  for (const pcl::PointXYZI& point : *points) {
    std::vector<double> distances;
    for (const pcl::PointXYZI& other : *points)
      distances.push_back(distance(point, other));
    std::sort(distances.begin(), distances.end()); // itself is the first
    means.push_back((distances[1] + distances[2] + distances[3] + distances[4]) / 4.0);
  }
  double mean = 0.0;
  for (const double one : means)
    mean += one / static_cast<double>(means.size());
  double variance = 0.0;
  for (const double one : means)
    variance += (one - mean) * (one - mean) / (static_cast<double>(means.size()) - 1.0);
  const double usual = mean + 0.7 * std::sqrt(variance);
  ASSERT_EQ(scores.size(), points->size());
  for (std::size_t i = 0; i < points->size(); ++i) {
    pcl::PointXYZI sensor;
    sensor.x = sensor.y = sensor.z = 0.0f;
    const double wanted = -means[i] / (usual * distance((*points)[i], sensor));
    ASSERT_NEAR(scores[i], wanted, 1e-4 * std::abs(wanted)) << i;
  }
}

TEST(RangeFilters, APointAtTheSensorHasAScore)
{
  const Centres::Ptr points = floorAndFlakes();
  pcl::PointXYZI sensor;
  sensor.x = sensor.y = sensor.z = 0.0f;
  points->push_back(sensor);
  std::vector<float> scores;
  rangeStatisticsScores(points, {}, scores);
  EXPECT_TRUE(std::isfinite(scores.back()));
  EXPECT_EQ(std::min_element(scores.begin(), scores.end()), scores.end() - 1);
  rangeRadiusScores(points, {}, scores);
  EXPECT_EQ(scores.back(), 0.0f);
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "noise/neighbour_scores.h"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;

/** \brief A sheet of voxels with holes, and some that float about it. */
io::VoxelFrame
sheetWithOutliers()
{
  std::mt19937 random(7);
  const auto position = [](std::mt19937& from) {
    // One after the other: compilers differ in the order of arguments.
    io::VoxelPosition place{};
    place.x = static_cast<std::uint32_t>(from() % 64);
    place.y = static_cast<std::uint32_t>(from() % 64);
    place.z = static_cast<std::uint32_t>(from() % 64);
    return place;
  };
  std::set<std::uint64_t> keys;
  for (std::uint32_t x = 0; x < 30; ++x)
    for (std::uint32_t y = 0; y < 30; ++y)
      if (random() % 4 != 0)
        keys.insert(io::mortonKey({x, y, 20}));
  for (int i = 0; i < 60; ++i)
    keys.insert(io::mortonKey(position(random)));
  io::VoxelFrame frame;
  frame.grid.resolution = 0.04;
  frame.grid.depth = 6;
  frame.keys.assign(keys.begin(), keys.end());
  frame.intensities.assign(frame.keys.size(), 1);
  return frame;
}

template <typename FilterT>
std::vector<int>
keptBy(FilterT& filter, const Centres::Ptr& centres)
{
  std::vector<int> kept;
  filter.setInputCloud(centres);
  filter.filter(kept);
  return kept;
}

std::vector<int>
notBelow(float threshold, const std::vector<float>& scores)
{
  std::vector<int> kept;
  for (std::size_t i = 0; i < scores.size(); ++i)
    if (scores[i] >= threshold)
      kept.push_back(static_cast<int>(i));
  return kept;
}

TEST(NeighbourScores, CentresAreTheVoxelsMiddles)
{
  const Centres::Ptr centres = noise::centresOf(sheetWithOutliers());
  const io::VoxelFrame frame = sheetWithOutliers();
  ASSERT_EQ(centres->size(), frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelPosition at = io::voxelPosition(frame.keys[i]);
    EXPECT_FLOAT_EQ((*centres)[i].x, (static_cast<float>(at.x) + 0.5f) * 0.04f);
    EXPECT_FLOAT_EQ((*centres)[i].z, (static_cast<float>(at.z) + 0.5f) * 0.04f);
  }
}

TEST(NeighbourScores, StatisticalScoresDecideAsPclsFilter)
{
  const Centres::Ptr centres = noise::centresOf(sheetWithOutliers());
  std::vector<float> scores;
  noise::statisticalScores(centres, 8, scores);
  for (const double multiplier : {-0.25, 0.5, 1.0, 2.0}) {
    pcl::StatisticalOutlierRemoval<pcl::PointXYZI> filter;
    filter.setMeanK(8);
    filter.setStddevMulThresh(multiplier);
    const std::vector<int> kept = keptBy(filter, centres);
    EXPECT_LT(kept.size(), centres->size());
    EXPECT_EQ(notBelow(static_cast<float>(-multiplier), scores), kept) << multiplier;
  }
}

TEST(NeighbourScores, RadiusScoresDecideAsPclsFilter)
{
  const Centres::Ptr centres = noise::centresOf(sheetWithOutliers());
  for (const double voxels : {1.5, 2.5}) {
    std::vector<float> scores;
    noise::radiusScores(centres, voxels * 0.04, scores);
    for (const int least : {1, 3, 5}) {
      pcl::RadiusOutlierRemoval<pcl::PointXYZI> filter;
      filter.setRadiusSearch(voxels * 0.04);
      filter.setMinNeighborsInRadius(least);
      const std::vector<int> kept = keptBy(filter, centres);
      EXPECT_LT(kept.size(), centres->size());
      EXPECT_EQ(notBelow(static_cast<float>(least), scores), kept) << voxels << least;
    }
  }
}

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

TEST(NeighbourScores, RadiusFollowsTheHorizontalRange)
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

TEST(NeighbourScores, StatisticsFollowTheRange)
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

TEST(NeighbourScores, APointAtTheSensorHasAScore)
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

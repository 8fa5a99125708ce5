// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "advice/setting_choice.h"
#include "advice/surface_closure.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

namespace pcl_ext::tools::test {

using Voxel = std::array<int, 3>;

bool
isClosed(const std::set<Voxel>& occupied, const Voxel& voxel)
{
  const std::array<Voxel, 3> axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const auto isOccupied =
      [&](const Voxel& step, int side, const Voxel& normal, int up) {
        Voxel at{};
        for (std::size_t i = 0; i < 3; ++i)
          at[i] = voxel[i] + side * step[i] + up * normal[i];
        return occupied.count(at) > 0;
      };
  for (const Voxel& normal : axes) {
    int neighbours = 0;
    for (const Voxel& step : axes)
      for (const int side : {-1, 1})
        if (step != normal &&
            (isOccupied(step, side, normal, -1) || isOccupied(step, side, normal, 0) ||
             isOccupied(step, side, normal, 1)))
          ++neighbours;
    if (neighbours == 4)
      return true;
  }
  return false;
}

Voxel
voxelOf(const pcl::PointXYZI& point, double edge)
{
  return {static_cast<int>(std::floor(point.x / edge)),
          static_cast<int>(std::floor(point.y / edge)),
          static_cast<int>(std::floor(point.z / edge))};
}

TEST(SurfaceClosure, FollowsItsDefinitionInARoomWithNoise)
{
  const Points points = roomClouds(1).front();
  ASSERT_LT(points.size(), 8000u); // all are judged
  const std::vector<double> edges = {0.02, 0.05, 0.07, 0.1, 0.3};
  SurfaceClosure closure(edges);
  closure.add(points);
  std::set<std::size_t> closed;
  for (std::size_t number = 0; number < edges.size(); ++number) {
    std::set<Voxel> occupied;
    for (const pcl::PointXYZI& point : points)
      occupied.insert(voxelOf(point, edges[number]));
    EXPECT_EQ(occupiedVoxels(points, edges[number]), occupied.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      if (isClosed(occupied, voxelOf(points[i], edges[number])))
        closed.insert(i);
    EXPECT_EQ(closure.closedAt(number), closed.size()) << edges[number];
  }
  EXPECT_GT(closure.holesAt(1, 4), closure.holesAt(2, 4));
  EXPECT_EQ(closure.holesAt(4, 4), 0.0);
}

TEST(SurfaceClosure, APlaneClosesWhereVoxelsAreAsLargeAsTheSpacing)
{
  Points plane;
  for (int row = 0; row < 40; ++row)
    for (int column = 0; column < 40; ++column)
      plane.emplace_back(0.03f * static_cast<float>(column) + 0.005f,
                         0.03f * static_cast<float>(row) + 0.005f,
                         1.0f);
  SurfaceClosure closure({0.02, 0.04});
  closure.add(plane);
  EXPECT_EQ(closure.closedAt(0), 0u);
  // Of 40 columns three are in the voxels at the border.
  EXPECT_EQ(closure.closedAt(1), 37u * 37u);
  EXPECT_EQ(closure.holesAt(0, 1), 1.0);
  EXPECT_EQ(closure.holesAt(1, 1), 0.0);
}

TEST(SurfaceClosure, PointsApartAreNoSurface)
{
  Points points;
  points.emplace_back(0.0f, 0.0f, 0.0f);
  points.emplace_back(3e38f, -3e38f, 1.0f);
  SurfaceClosure closure({0.001, 10.0});
  closure.add(points);
  EXPECT_EQ(closure.holesAt(1, 1), 1.0);
}

/** \brief Three edges with kbit/s of fast, balanced and small; one has holes. */
std::vector<EdgeTrial>
knownTrials()
{
  const auto trial = [](double edge, double holes, double kilobits, double ms) {
    EdgeTrial made;
    made.edge = edge;
    made.holes = holes;
    made.efforts = {EffortTrial{1.1 * kilobits, 0.5 * ms, 1.1 * kilobits},
                    EffortTrial{kilobits, ms, kilobits},
                    EffortTrial{0.9 * kilobits, 2.0 * ms, 0.9 * kilobits}};
    return made;
  };
  return {trial(0.01, 0.251, 4000, 20),
          trial(0.02, 0.25, 1000, 20),
          trial(0.05, 0.1, 100, 4)};
}

void
expectChoice(const Choice& choice,
             std::size_t edge,
             io::Effort effort,
             ChoiceFault fault)
{
  EXPECT_EQ(choice.edge, edge);
  EXPECT_EQ(choice.effort, effort);
  EXPECT_EQ(choice.fault, fault);
}

TEST(SettingChoice, TheFinestEdgeThatKeepsTheLimits)
{
  using io::Effort;
  const std::vector<EdgeTrial> trials = knownTrials();
  ChoiceLimits limits;
  limits.period = 0.08; // small takes half of it
  expectChoice(choose(trials, limits), 1, Effort::Balanced, ChoiceFault::None);
  limits.kilobits = 1000;
  expectChoice(choose(trials, limits), 1, Effort::Balanced, ChoiceFault::None);
  limits.kilobits = 999;
  expectChoice(choose(trials, limits), 1, Effort::Small, ChoiceFault::None);
  limits.period = 0.079;
  expectChoice(choose(trials, limits), 2, Effort::Balanced, ChoiceFault::None);
  limits = {};
  limits.period = 0.02;
  expectChoice(choose(trials, limits), 1, Effort::Fast, ChoiceFault::None);
  limits.period = 1.0;
  limits.most_holes = 1.0;
  expectChoice(choose(trials, limits), 0, Effort::Balanced, ChoiceFault::None);
}

TEST(SettingChoice, LimitsAreGivenUpWhereNothingKeepsThem)
{
  using io::Effort;
  std::vector<EdgeTrial> trials = knownTrials();
  ChoiceLimits limits;
  limits.period = 0.001;
  limits.kilobits = 89;
  expectChoice(choose(trials, limits), 2, Effort::Small, ChoiceFault::Rate);
  limits.kilobits = 1000;
  expectChoice(choose(trials, limits), 2, Effort::Fast, ChoiceFault::Time);
  limits.kilobits = 105;
  expectChoice(choose(trials, limits), 2, Effort::Balanced, ChoiceFault::Time);
  limits = {};
  limits.period = 1.0;
  limits.most_holes = 0.05;
  expectChoice(choose(trials, limits), 2, Effort::Balanced, ChoiceFault::Holes);
}

} // namespace pcl_ext::tools::test

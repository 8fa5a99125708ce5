// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "shown/shown_quality.h"
#include "shown/simulated_link.h"
#include "simulator/robot_cell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace pcl_ext;
using shown::QualityJudge;
using shown::RateTrace;
using shown::SimulatedLink;

TEST(SimulatedLink, SendsOneFrameAfterTheOther)
{
  const RateTrace trace = RateTrace::steady("slow", 8000.0); // 1000 bytes a second
  SimulatedLink link(trace);
  EXPECT_DOUBLE_EQ(link.send(1.0, 500), 1.5);
  EXPECT_DOUBLE_EQ(link.waitAt(1.25), 0.25);
  EXPECT_DOUBLE_EQ(link.send(1.25, 250), 1.75);
  EXPECT_DOUBLE_EQ(link.waitAt(2.0), 0.0);
}

/** \brief The integral of the rate from begin to end is what was sent, also where it
 * begins before a drop of the rate, and within one. */
TEST(SimulatedLink, FollowsItsTrace)
{
  constexpr std::size_t bytes = 100'000;
  const RateTrace trace = RateTrace::wireless("wireless", 1e6, 20.0, 7);
  EXPECT_FALSE(trace.isSteady());
  bool drops = false;
  for (const double begin : {0.0, 1.9, 5.0, 7.775, 19.0}) {
    const double end = trace.endOf(begin, bytes);
    constexpr int steps = 1'000'000;
    double bits = 0.0;
    for (int i = 0; i < steps; ++i) {
      const double rate = trace.at(begin + (i + 0.5) * (end - begin) / steps);
      bits += rate * (end - begin) / steps;
      drops |= rate < 20'000.0;
    }
    EXPECT_NEAR(bits, 8.0 * bytes, 20.0);
  }
  EXPECT_TRUE(drops);
}

/** \brief The surfaces of a cloud with two points of them and a flying pixel. */
std::vector<shown::SurfacePoint>
cloudOfThree()
{
  cell::CellFrame frame;
  frame.cloud.push_back({1.01f, 1.01f, 1.01f});
  frame.cloud.push_back({2.01f, 1.01f, 1.01f});
  frame.cloud.push_back({3.01f, 1.01f, 1.01f});
  frame.truth = {cell::PointTruth::Surface,
                 cell::PointTruth::Surface,
                 cell::PointTruth::FlyingPixel};
  return shown::surfacePoints(frame, [](std::size_t) { return false; });
}

io::VoxelFrame
voxelsAround(double edge, std::initializer_list<double> xs)
{
  io::VoxelFrame frame;
  frame.grid.resolution = edge;
  frame.grid.depth = 12;
  for (const double x : xs) {
    const auto index = [edge](double at) {
      return static_cast<std::uint32_t>(std::floor(at / edge));
    };
    frame.keys.push_back(io::mortonKey({index(x), index(1.01), index(1.01)}));
  }
  return frame;
}

TEST(ShownQuality, CountsSurfacesNearVoxelsAndVoxelsWithoutSurfaces)
{
  QualityJudge judge(0.02);
  judge.add(cloudOfThree());
  // The first surface's own voxel and one that is noise; then a neighbour of it.
  shown::ShownQuality quality = judge.judge(voxelsAround(0.02, {1.01, 3.01}));
  EXPECT_EQ(quality.surface_percent, 50.0);
  EXPECT_EQ(quality.noise_percent, 50.0);
  quality = judge.judge(voxelsAround(0.02, {1.03, 2.01}));
  EXPECT_EQ(quality.surface_percent, 100.0);
  EXPECT_EQ(quality.noise_percent, 0.0);
  EXPECT_EQ(judge.judge(voxelsAround(0.02, {1.05})).surface_percent, 0.0);
}

TEST(ShownQuality, LargeVoxelsShowWhatIsNearTheirCentres)
{
  QualityJudge judge(0.02);
  judge.add(cloudOfThree());
  EXPECT_EQ(judge.judge(voxelsAround(0.04, {1.01, 2.01})).surface_percent, 100.0);
  // The centre is at 1, 1, 1.
  EXPECT_EQ(judge.judge(voxelsAround(0.08, {1.01})).surface_percent, 50.0);
  // The centre is at 1.04, 1.04, 1.04.
  EXPECT_EQ(judge.judge(voxelsAround(0.16, {1.01})).surface_percent, 0.0);
  EXPECT_EQ(judge.judge(voxelsAround(0.16, {1.01})).noise_percent, 0.0);
}

TEST(ShownQuality, SurfacesOfTheLastTenFramesAreNoNoise)
{
  QualityJudge judge(0.02);
  judge.add(cloudOfThree());
  const io::VoxelFrame shown = voxelsAround(0.02, {1.01});
  for (int i = 0; i < 9; ++i)
    judge.add({});
  EXPECT_EQ(judge.judge(shown).noise_percent, 0.0);
  judge.add({});
  EXPECT_EQ(judge.judge(shown).noise_percent, 100.0);
}

TEST(ShownQuality, ThePersonIsJudgedWhereItHasEnoughVoxels)
{
  QualityJudge judge(0.02);
  std::vector<shown::SurfacePoint> points;
  for (int i = 0; i < 19; ++i)
    points.push_back({{1.01 + 0.04 * i, 1.01, 1.01}, true});
  judge.add(points);
  EXPECT_FALSE(judge.judge(voxelsAround(0.02, {1.01})).person_percent);
  // A voxel with a point of another surface, too, is not the person's.
  points.push_back({{3.01, 1.01, 1.01}, true});
  points.push_back({{3.015, 1.01, 1.01}, false});
  judge.add(points);
  EXPECT_FALSE(judge.judge(voxelsAround(0.02, {1.01})).person_percent);
  points.push_back({{4.01, 1.01, 1.01}, true});
  judge.add(points);
  // That of its own, and its neighbour on the other side of the gap.
  EXPECT_EQ(judge.judge(voxelsAround(0.02, {1.01, 4.01, 3.01})).person_percent, 10.0);
}

} // namespace

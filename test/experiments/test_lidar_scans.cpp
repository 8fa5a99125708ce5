// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "noise/lidar_scans.h"
#include "noise/scores.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace {

using namespace pcl_ext::noise;

struct LinePoint {
  float x;
  VoxelTruth truth;
};

/** \brief Points on a line ahead of the sensor, in voxels of 10 cm; the intensity is ten
 * times the range. */
LabelledScan
lineScan(const std::vector<LinePoint>& points)
{
  LabelledScan scan;
  for (const LinePoint& point : points) {
    pcl::PointXYZI at;
    at.x = point.x;
    at.y = at.z = 0.05f;
    at.intensity = 10.0f * point.x;
    scan.returns->push_back(at);
    scan.truth.push_back(point.truth);
  }
  voxelizeReturns(0.1, scan);
  return scan;
}

TEST(LidarScans, OneSurfacePointMakesASurface)
{
  const LabelledScan scan = lineScan({{1.02f, VoxelTruth::Noise},
                                      {1.05f, VoxelTruth::Noise},
                                      {-2.02f, VoxelTruth::Noise},
                                      {-2.05f, VoxelTruth::Still},
                                      {3.02f, VoxelTruth::Person},
                                      {3.05f, VoxelTruth::Noise},
                                      {4.02f, VoxelTruth::Still},
                                      {4.05f, VoxelTruth::Person}});
  const auto& counts = scan.voxels.of(Law::Count);
  EXPECT_EQ(counts.keys.size(), 4u);
  std::vector<VoxelTruth> of_points;
  for (const std::uint32_t voxel : scan.voxel_of_return)
    of_points.push_back(scan.voxels.truth[voxel]);
  EXPECT_EQ(of_points,
            (std::vector<VoxelTruth>{VoxelTruth::Noise,
                                     VoxelTruth::Noise,
                                     VoxelTruth::Still,
                                     VoxelTruth::Still,
                                     VoxelTruth::Person,
                                     VoxelTruth::Person,
                                     VoxelTruth::Still,
                                     VoxelTruth::Still}));
  EXPECT_EQ(counts.intensities, (std::vector<std::uint16_t>{2, 2, 2, 2}));
}

TEST(LidarScans, EveryPointIsInItsVoxel)
{
  std::mt19937 random(3);
  LabelledScan scan;
  for (int i = 0; i < 20000; ++i) {
    pcl::PointXYZI point;
    for (int axis = 0; axis < 3; ++axis)
      point.data[axis] =
          static_cast<float>(static_cast<int>(random() % 4001) - 2000) * 0.0437f;
    scan.returns->push_back(point);
    scan.truth.push_back(VoxelTruth::Still);
  }
  voxelizeReturns(0.1, scan);
  const auto& counts = scan.voxels.of(Law::Count);
  std::vector<std::uint16_t> points_of(counts.size(), 0);
  for (std::size_t i = 0; i < scan.returns->size(); ++i) {
    const std::uint32_t voxel = scan.voxel_of_return[i];
    ++points_of[voxel];
    const Eigen::Vector3d centre = centreOf(counts.grid, counts.keys[voxel]);
    const Eigen::Vector3d point = (*scan.returns)[i].getVector3fMap().cast<double>();
    ASSERT_LE((point - centre).cwiseAbs().maxCoeff(), 0.0500001) << i;
  }
  EXPECT_EQ(points_of, counts.intensities);
}

TEST(LidarScans, AScanWithoutReturnsHasNoVoxels)
{
  EXPECT_TRUE(lineScan({}).voxels.of(Law::Count).keys.empty());
}

TEST(LidarScans, TheCellsLidarHasNoiseAndThePerson)
{
  pcl_ext::cell::RobotCell cell(1);
  pcl_ext::cell::LidarWeather weather;
  weather.kind = pcl_ext::cell::Weather::Snow;
  cell.setLidarWeather(weather);
  LabelledScan scan;
  readScan(cell, 45, 0.1, scan);
  EXPECT_GT(scan.returns->size(), 20000u);
  std::array<std::size_t, voxel_truth_count> numbers{};
  for (std::size_t i = 0; i < scan.truth.size(); ++i) {
    ++numbers[static_cast<std::size_t>(scan.truth[i])];
    const auto truth = scan.frame.truth[scan.index_of_return[i]];
    ASSERT_NE(truth, pcl_ext::cell::PointTruth::None);
    ASSERT_EQ(truth == pcl_ext::cell::PointTruth::Surface,
              scan.truth[i] != VoxelTruth::Noise);
  }
  EXPECT_GT(numbers[static_cast<std::size_t>(VoxelTruth::Noise)], 500u);
  EXPECT_GT(numbers[static_cast<std::size_t>(VoxelTruth::Person)], 20u);
}

/** \brief Two points of noise in one voxel, surfaces at 2 and 3 m. */
const LabelledScan four_points = lineScan({{1.02f, VoxelTruth::Noise},
                                           {1.05f, VoxelTruth::Noise},
                                           {2.05f, VoxelTruth::Still},
                                           {3.05f, VoxelTruth::Still}});

TEST(Scores, AVoxelHasTheHighestScoreOfItsPoints)
{
  MethodRun run;
  run.method.score_points = [](const LabelledScan&, std::vector<float>& scores) {
    scores = {1.0f, 4.0f, 2.0f, 5.0f};
  };
  score(four_points, run);
  // Noise, surface, noise, surface; and of voxels surface, noise, surface.
  EXPECT_DOUBLE_EQ(JudgedVoxels(run.points).averagePrecision(),
                   (1.0 + 2.0 / 3.0) / 2.0);
  EXPECT_DOUBLE_EQ(JudgedVoxels(run.voxels).averagePrecision(), 0.5);
  EXPECT_EQ(run.ms.count(), 1u);
}

TEST(Scores, APointHasItsVoxelsScore)
{
  MethodRun run;
  run.method.score_voxels = [](const LabelledFrame& frame, std::vector<float>& scores) {
    scores.clear();
    for (const VoxelTruth truth : frame.truth)
      scores.push_back(truth == VoxelTruth::Noise ? 1.0f : 0.0f);
  };
  score(four_points, run);
  EXPECT_DOUBLE_EQ(JudgedVoxels(run.points).averagePrecision(), 0.5);
  EXPECT_DOUBLE_EQ(JudgedVoxels(run.voxels).averagePrecision(), 1.0 / 3.0);
  run.method.score_voxels = [](const LabelledFrame& frame, std::vector<float>& scores) {
    scores.assign(frame.truth.size(), std::numeric_limits<float>::quiet_NaN());
  };
  EXPECT_THROW(score(four_points, run), std::invalid_argument);
}

TEST(Scores, MethodsAreChosenByTheirNames)
{
  EXPECT_EQ(methodsNamed({"filter on points"}, lidarMethods()).size(), 1u);
  EXPECT_EQ(methodsNamed({"DSOR", "DROR"}, lidarMethods()).size(), 4u);
  EXPECT_EQ(methodsNamed({}, cameraMethods(0.04)).size(), cameraMethods(0.04).size());
  EXPECT_THROW(methodsNamed({"foo"}, lidarMethods()), std::invalid_argument);
}

} // namespace

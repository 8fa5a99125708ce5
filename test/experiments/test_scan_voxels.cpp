#include "noise/scan_voxels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::noise;

struct LinePoint {
  float x;
  PointClass point_class;
};

/** \brief A scan of points on a line to the right of the sensor, each with a return. */
LabelledScan
lineScan(const std::vector<LinePoint>& points)
{
  LabelledScan scan;
  for (const LinePoint& point : points) {
    pcl::PointXYZI at;
    at.x = point.x;
    at.y = at.z = 0.05f;
    at.intensity = 10.0f * point.x;
    scan.cloud.push_back(at);
    scan.classes.push_back(point.point_class);
  }
  scan.collectReturns();
  return scan;
}

VoxelizedScan
voxelized(const LabelledScan& scan, double resolution = 0.1)
{
  VoxelizedScan voxels;
  ScanVoxelizer(resolution).voxelize(scan, voxels);
  return voxels;
}

TEST(ScanVoxels, OneSurfacePointMakesASurface)
{
  const LabelledScan scan = lineScan({{1.02f, PointClass::Noise},
                                      {1.05f, PointClass::Noise},
                                      {2.02f, PointClass::Noise},
                                      {2.05f, PointClass::Surface},
                                      {3.02f, PointClass::Person},
                                      {3.05f, PointClass::Noise},
                                      {4.02f, PointClass::Person},
                                      {4.05f, PointClass::Surface},
                                      {5.05f, PointClass::Pole},
                                      {6.02f, PointClass::Pole},
                                      {6.05f, PointClass::Person}});
  const VoxelizedScan voxels = voxelized(scan);
  EXPECT_EQ(voxels.judged.truth,
            (std::vector<VoxelTruth>{VoxelTruth::Noise,
                                     VoxelTruth::Still,
                                     VoxelTruth::Person,
                                     VoxelTruth::Still,
                                     VoxelTruth::Pole,
                                     VoxelTruth::Person}));
  ASSERT_EQ(voxels.judged.range.size(), 6u);
  EXPECT_NEAR(voxels.judged.range[5], 6.05f, 0.01f);
}

TEST(ScanVoxels, WhatIsIgnoredIsNotJudgedUnlessASurfaceIsThere)
{
  const LabelledScan scan = lineScan({{1.02f, PointClass::Noise},
                                      {1.05f, PointClass::Ignored},
                                      {2.02f, PointClass::Ignored},
                                      {2.05f, PointClass::Surface},
                                      {3.05f, PointClass::Noise}});
  const VoxelizedScan voxels = voxelized(scan);
  EXPECT_EQ(voxels.frame.truth.size(), 3u);
  EXPECT_EQ(voxels.judged.indices, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(voxels.judged.truth,
            (std::vector<VoxelTruth>{VoxelTruth::Still, VoxelTruth::Noise}));
  EXPECT_EQ(judgedPoints(scan).indices, (std::vector<std::size_t>{0, 3, 4}));
}

TEST(ScanVoxels, AVoxelHasTheHighestScoreOfItsPoints)
{
  LabelledScan scan = lineScan({{1.02f, PointClass::Noise},
                                {2.02f, PointClass::Noise}, // becomes missing
                                {3.02f, PointClass::Noise},
                                {1.05f, PointClass::Noise}});
  scan.classes[1] = PointClass::Missing;
  scan.collectReturns();
  const VoxelizedScan voxels = voxelized(scan);
  std::vector<float> scores;
  highestScores(scan, voxels, {-4.0f, 100.0f, -2.0f, -3.0f}, scores);
  EXPECT_EQ(scores, (std::vector<float>{-3.0f, -2.0f}));
}

TEST(ScanVoxels, EveryPointIsInItsVoxelAlsoOnFacesAndFarAway)
{
  std::mt19937 random(3);
  LabelledScan scan;
  for (int i = 0; i < 20000; ++i) {
    pcl::PointXYZI point;
    for (int axis = 0; axis < 3; ++axis) {
      const auto step = static_cast<float>(static_cast<int>(random() % 4001) - 2000);
      // Half of them on faces between voxels, as those of sensors with steps are.
      point.data[axis] = i % 2 == 0 ? step * 0.05f : step * 0.0437f;
    }
    point.intensity = 1.0f;
    scan.cloud.push_back(point);
    scan.classes.push_back(PointClass::Surface);
  }
  scan.collectReturns();
  for (const double resolution : {0.05, 0.1, 0.2}) {
    const VoxelizedScan voxels = voxelized(scan, resolution);
    const auto& counts = voxels.frame.of(Law::Count);
    std::vector<float> points_of(counts.size(), 0.0f);
    for (std::size_t i = 0; i < scan.returns->size(); ++i) {
      const std::uint32_t voxel = voxels.voxel_of_return[i];
      points_of[voxel] += 1.0f;
      const Eigen::Vector3d centre = centreOf(counts.grid, counts.keys[voxel]);
      const Eigen::Vector3d point = (*scan.returns)[i].getVector3fMap().cast<double>();
      ASSERT_LT((point - centre).cwiseAbs().maxCoeff(), 0.5002 * resolution) << i;
    }
    // A point on a face may be counted on its other side only where that is occupied, too.
    std::size_t others = 0;
    for (std::size_t i = 0; i < counts.size(); ++i)
      others += points_of[i] != counts.intensity_scale.value(counts.intensities[i]);
    EXPECT_LT(others, counts.size() / 100) << resolution;
  }
}

} // namespace

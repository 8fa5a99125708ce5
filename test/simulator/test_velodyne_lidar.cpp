// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/robot_cell.h"
#include "simulator/scene.h"
#include "simulator/velodyne_lidar.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>

namespace {

using pcl_ext::cell::Box;
using pcl_ext::cell::LidarErrorModel;
using pcl_ext::cell::LidarFrame;
using pcl_ext::cell::LidarRays;
using pcl_ext::cell::Material;
using pcl_ext::cell::PointTruth;
using pcl_ext::cell::RobotCell;
using pcl_ext::cell::SurfaceImage;
using pcl_ext::cell::uprightBox;

constexpr double degree = 3.14159265358979323846 / 180.0;

LidarFrame
capture(RobotCell& cell, std::uint32_t revolution)
{
  LidarFrame frame;
  cell.captureLidar(revolution, frame);
  return frame;
}

TEST(VelodyneLidar, RaysAreThoseOfTheManual)
{
  const LidarRays rays;
  for (std::size_t ring = 0; ring < LidarRays::rings; ++ring)
    for (std::size_t column = 0; column < LidarRays::columns; ++column) {
      const Eigen::Vector3d ray = rays.direction(ring * LidarRays::columns + column);
      ASSERT_NEAR(ray.norm(), 1.0, 1e-12);
      ASSERT_NEAR(std::asin(ray.z()) / degree, -15.0 + 2.0 * double(ring), 1e-9);
      const double turn = std::remainder(
          std::atan2(-ray.y(), ray.x()) / degree - 0.2 * double(column), 360.0);
      ASSERT_NEAR(turn, 0.0, 1e-9);
    }
}

TEST(VelodyneLidar, SeesAFloorAndWallsAllAroundWhereTheyAre)
{
  const Eigen::Isometry3d pose(Eigen::Translation3d(1.0, 2.0, 1.5) *
                               Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
  pcl_ext::cell::Solids solids;
  solids.emplace_back(uprightBox({0, 0, -0.5}, {100, 100, 1}, Material::Concrete));
  solids.emplace_back(uprightBox({0, 30, 5}, {100, 1, 20}, Material::Plaster));
  solids.emplace_back(uprightBox({0, -30, 5}, {100, 1, 20}, Material::Plaster));
  const LidarRays rays;
  SurfaceImage image(LidarRays::size);
  rays.trace(solids, pose.inverse(), image);
  for (std::size_t pixel = 0; pixel < LidarRays::size; ++pixel) {
    const Eigen::Vector3d ray = pose.linear() * rays.direction(pixel);
    const double to_floor = ray.z() < 0.0 ? -1.5 / ray.z() : 1e9;
    const double to_wall =
        ray.y() > 0.0 ? (29.5 - 2.0) / ray.y() : (-29.5 - 2.0) / ray.y();
    const double range = std::min(to_floor, to_wall);
    const Eigen::Vector3d point = pose.translation() + range * ray;
    if (std::abs(point.x()) > 49.9 || point.z() > 14.9)
      continue;
    ASSERT_NEAR(image.depth[pixel], range, 1e-4 * range) << pixel;
    const double cosine = to_floor < to_wall ? -ray.z() : std::abs(ray.y());
    ASSERT_NEAR(image.cos_incidence[pixel], cosine, 1e-5) << pixel;
    ASSERT_EQ(image.material[pixel],
              to_floor < to_wall ? Material::Concrete : Material::Plaster);
  }
}

TEST(VelodyneLidar, ARevolutionDependsOnSeedAndNumberAlone)
{
  RobotCell cell(1);
  RobotCell again(1);
  RobotCell other(2);
  const LidarFrame frame = capture(cell, 5);
  capture(again, 9);
  const LidarFrame same = capture(again, 5);
  ASSERT_EQ(frame.cloud.size(), LidarRays::size);
  EXPECT_EQ(std::memcmp(frame.cloud.points.data(),
                        same.cloud.points.data(),
                        frame.cloud.size() * sizeof(pcl::PointXYZI)),
            0);
  EXPECT_EQ(frame.truth, same.truth);
  EXPECT_EQ(frame.cloud.header.stamp, 500000u);
  EXPECT_EQ(frame.cloud.header.frame_id, "velodyne_7");
  EXPECT_NE(frame.truth, capture(other, 5).truth);
}

TEST(VelodyneLidar, PointsLieOnTheirRaysWithTheRangesNoise)
{
  RobotCell cell;
  const LidarErrorModel model;
  const LidarRays rays;
  const SurfaceImage surfaces = cell.lidarSurfaces(3);
  const LidarFrame frame = capture(cell, 3);
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    if (frame.truth[i] == PointTruth::None) {
      ASSERT_TRUE(std::isnan(frame.cloud[i].x));
      continue;
    }
    const Eigen::Vector3d point = frame.cloud[i].getVector3fMap().cast<double>();
    ASSERT_LT((point - point.norm() * rays.direction(i)).norm(), 1e-5);
    const double steps = point.norm() / model.range_step;
    ASSERT_NEAR(steps, std::round(steps), 0.01);
    const double error = point.norm() - surfaces.depth[i];
    if (frame.truth[i] == PointTruth::Surface) {
      squares += error * error;
      count += 1.0;
    }
    else {
      ASSERT_EQ(frame.truth[i], PointTruth::FlyingPixel);
      ASSERT_LT(std::abs(error), model.largest_mixed_step + 0.1);
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), model.range_noise, 0.0003);
}

TEST(VelodyneLidar, IntensityFallsWithAngleAndRangeAndTellsMaterials)
{
  const LidarErrorModel model;
  EXPECT_NEAR(model.intensity(Material::Plaster, 1.0, 0.0), 75.0, 1e-9);
  EXPECT_GT(model.intensity(Material::Plaster, 1.0, 5.0),
            model.intensity(Material::Plaster, 0.5, 5.0));
  EXPECT_GT(model.intensity(Material::Plaster, 1.0, 5.0),
            model.intensity(Material::Plaster, 1.0, 10.0));
  EXPECT_GT(model.intensity(Material::Plaster, 1.0, 5.0),
            model.intensity(Material::DarkPlastic, 1.0, 5.0));

  RobotCell cell;
  const SurfaceImage surfaces = cell.lidarSurfaces(0);
  const LidarFrame frame = capture(cell, 0);
  double difference = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    if (frame.truth[i] != PointTruth::Surface)
      continue;
    ASSERT_EQ(frame.cloud[i].intensity, std::floor(frame.cloud[i].intensity));
    ASSERT_LE(frame.cloud[i].intensity, 100.0f);
    difference += frame.cloud[i].intensity - model.intensity(surfaces.material[i],
                                                             surfaces.cos_incidence[i],
                                                             surfaces.depth[i]);
    count += 1.0;
  }
  // Those near 0 are held there, which moves the mean a little up.
  EXPECT_NEAR(difference / count, 0.0, 0.3);
}

TEST(VelodyneLidar, SeesTheCellAndMostOfItWell)
{
  RobotCell cell;
  const Eigen::Isometry3d pose = cell.lidarPose();
  EXPECT_TRUE((pose.translation().array() > RobotCell::cropMin().array()).all());
  EXPECT_TRUE((pose.translation().array() < RobotCell::cropMax().array()).all());
  const LidarFrame frame = capture(cell, 0);
  std::array<double, 4> count{};
  double inside = 0.0;
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    count[static_cast<std::size_t>(frame.truth[i])] += 1.0;
    if (frame.truth[i] == PointTruth::None)
      continue;
    const Eigen::Array3d point =
        (pose * frame.cloud[i].getVector3fMap().cast<double>()).array();
    inside += (point >= RobotCell::cropMin().array()).all() &&
                      (point <= RobotCell::cropMax().array()).all()
                  ? 1.0
                  : 0.0;
  }
  EXPECT_GT(count[static_cast<std::size_t>(PointTruth::Surface)],
            0.8 * LidarRays::size);
  EXPECT_GT(count[static_cast<std::size_t>(PointTruth::FlyingPixel)], 20.0);
  EXPECT_LT(count[static_cast<std::size_t>(PointTruth::FlyingPixel)], 1000.0);
  EXPECT_EQ(count[static_cast<std::size_t>(PointTruth::Speckle)], 0.0);
  EXPECT_GT(inside, 2000.0);
}

TEST(VelodyneLidar, SeesWhatMovesAndRepeatsAfterTheWorkCycle)
{
  RobotCell cell;
  const auto moved = [](const SurfaceImage& one, const SurfaceImage& other) {
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < one.depth.size(); ++i)
      pixels += std::abs(one.depth[i] - other.depth[i]) > 0.05f;
    return pixels;
  };
  const SurfaceImage start = cell.lidarSurfaces(0);
  EXPECT_GT(moved(start, cell.lidarSurfaces(40)), 50u);
  const auto cycle =
      static_cast<std::uint32_t>(pcl_ext::cell::work_cycle * RobotCell::lidar_rate);
  EXPECT_LT(moved(start, cell.lidarSurfaces(cycle)), 5u);
}

} // namespace

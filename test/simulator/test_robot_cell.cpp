// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/robot_cell.h"
#include "simulator/scene.h"
#include "support/cell_frames.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

namespace {

using pcl_ext::cell::CellFrame;
using pcl_ext::cell::ErrorModel;
using pcl_ext::cell::PointTruth;
using pcl_ext::cell::RayGrid;
using pcl_ext::cell::RobotCell;
using pcl_ext::cell::SurfaceImage;
using pcl_ext::cell::test::capture;
using pcl_ext::cell::test::sameBytes;

constexpr double pi = 3.14159265358979323846;

std::size_t
pixelAt(std::size_t column, std::size_t row)
{
  return row * RayGrid::columns + column;
}

struct Workload {
  double points = 0.0;
  double voxels_4cm = 0.0;
  double voxels_2cm = 0.0;
};

Workload
workloadOf(const CellFrame& frame, const Eigen::Isometry3d& pose)
{
  using Key = std::tuple<long, long, long>;
  std::array<std::set<Key>, 2> voxels;
  const std::array<double, 2> resolutions = {0.04, 0.02};
  Workload workload;
  for (const pcl::PointXYZ& point : frame.cloud) {
    if (std::isnan(point.x))
      continue;
    const Eigen::Vector3d world = pose * point.getVector3fMap().cast<double>();
    if ((world.array() < RobotCell::cropMin().array()).any() ||
        (world.array() > RobotCell::cropMax().array()).any())
      continue;
    workload.points += 1.0;
    for (std::size_t i = 0; i < voxels.size(); ++i)
      voxels[i].emplace(std::lround(std::floor(world.x() / resolutions[i])),
                        std::lround(std::floor(world.y() / resolutions[i])),
                        std::lround(std::floor(world.z() / resolutions[i])));
  }
  workload.voxels_4cm = static_cast<double>(voxels[0].size());
  workload.voxels_2cm = static_cast<double>(voxels[1].size());
  return workload;
}

TEST(RobotCell, SeedsSensorsAndFramesDiffer)
{
  RobotCell one(1);
  RobotCell two(2);
  const CellFrame frame = capture(one, 1, 0);
  EXPECT_FALSE(sameBytes(frame, capture(two, 1, 0)));
  EXPECT_FALSE(sameBytes(frame, capture(one, 2, 0)));
  EXPECT_FALSE(sameBytes(frame, capture(one, 1, 1)));
}

TEST(RobotCell, EachSensorLooksAtTheFloorOfTheCell)
{
  const RobotCell cell;
  for (unsigned int sensor = 1; sensor <= RobotCell::sensor_count; ++sensor) {
    const Eigen::Isometry3d pose = cell.sensorPose(sensor);
    const Eigen::Vector3d axis = pose.linear().col(2);
    const Eigen::Vector3d floor =
        pose * Eigen::Vector3d(0, 0, -pose.translation().z() / axis.z());
    EXPECT_NEAR(floor.z(), 0.0, 1e-9);
    EXPECT_TRUE(floor.x() > 0 && floor.x() < 10 && floor.y() > 0 && floor.y() < 10)
        << sensor;
  }
}

TEST(RobotCell, RefusesSensorsThatAreNotThere)
{
  RobotCell cell;
  CellFrame frame;
  EXPECT_THROW(cell.sensorPose(0), std::out_of_range);
  EXPECT_THROW(cell.sensorPose(7), std::out_of_range);
  EXPECT_THROW(cell.capture(0, 0, frame), std::out_of_range);
  EXPECT_THROW(cell.capture(7, 0, frame), std::out_of_range);
}

TEST(RobotCell, CloudIsOrganisedInMillimetresWithTheTruthOfEachPoint)
{
  RobotCell cell;
  const RayGrid rays;
  const double half_x = std::tan(35.3 * pi / 180.0);
  const double half_y = std::tan(30.0 * pi / 180.0);
  for (unsigned int sensor = 1; sensor <= RobotCell::sensor_count; ++sensor) {
    const CellFrame frame = capture(cell, sensor, 30);
    EXPECT_EQ(frame.cloud.header.stamp, 1500000u);
    EXPECT_EQ(frame.cloud.header.frame_id, "kinect_" + std::to_string(sensor));
    ASSERT_EQ(frame.cloud.width, 512u);
    ASSERT_EQ(frame.cloud.height, 424u);
    ASSERT_EQ(frame.cloud.size(), frame.truth.size());
    std::array<std::size_t, 4> count{};
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      const pcl::PointXYZ& point = frame.cloud[i];
      ++count[static_cast<std::size_t>(frame.truth[i])];
      const bool missing = frame.truth[i] == PointTruth::None;
      ASSERT_EQ(std::isnan(point.x), missing);
      ASSERT_EQ(std::isnan(point.y), missing);
      ASSERT_EQ(std::isnan(point.z), missing);
      if (missing)
        continue;
      const double millimetres = 1000.0 * point.z;
      ASSERT_NEAR(millimetres, std::round(millimetres), 1e-3);
      const double column = static_cast<double>(i % 512);
      const double row = static_cast<double>(i / 512);
      ASSERT_NEAR(point.x, point.z * half_x * ((2.0 * column + 1.0) / 512 - 1.0), 1e-5);
      ASSERT_NEAR(point.y, point.z * half_y * ((2.0 * row + 1.0) / 424 - 1.0), 1e-5);
    }
    EXPECT_GT(count[static_cast<std::size_t>(PointTruth::Surface)], 100000u) << sensor;
    EXPECT_GT(count[static_cast<std::size_t>(PointTruth::FlyingPixel)], 100u) << sensor;
    EXPECT_GT(count[static_cast<std::size_t>(PointTruth::Speckle)], 10u) << sensor;
  }
}

/** \brief Standard deviation of depth over frames in a window of bare floor around a
 * pixel, and what the published figure says; millimetres. */
struct AxialNoise {
  double measured;
  double published;
};

AxialNoise
axialNoiseAt(RobotCell& cell, std::size_t column, std::size_t row)
{
  constexpr std::size_t reach = 5;
  constexpr std::uint32_t frames = 80;
  const SurfaceImage surfaces = cell.surfaces(1, 0);
  double squares = 0.0;
  double count = 0.0;
  CellFrame frame;
  for (std::uint32_t number = 0; number < frames; ++number) {
    cell.capture(1, number, frame);
    for (std::size_t j = row - reach; j <= row + reach; ++j)
      for (std::size_t i = column - reach; i <= column + reach; ++i) {
        const std::size_t pixel = pixelAt(i, j);
        if (frame.truth[pixel] != PointTruth::Surface)
          continue;
        const double error = frame.cloud[pixel].z - surfaces.depth[pixel];
        squares += error * error;
        count += 1.0;
      }
  }
  EXPECT_GT(count, 0.9 * frames * (2 * reach + 1) * (2 * reach + 1));

  // The floor's depth and angle of incidence from the pose alone.
  const RayGrid rays;
  const Eigen::Isometry3d pose = cell.sensorPose(1);
  const Eigen::Vector3d ray =
      pose.linear() * Eigen::Vector3d(rays.x(column), rays.y(row), 1.0);
  const double z = -pose.translation().z() / ray.z();
  EXPECT_NEAR(surfaces.depth[pixelAt(column, row)], z, 1e-4);
  const double theta = std::acos(-ray.z() / ray.norm());
  const double angle_term = theta * theta / ((pi / 2 - theta) * (pi / 2 - theta));
  const double u = rays.x(column) / std::tan(35.3 * pi / 180.0);
  const double v = rays.y(row) / std::tan(30.0 * pi / 180.0);
  const double border =
      1.0 + cell.errorModel().corner_noise_growth * (u * u + v * v) / 2.0;
  return {1000.0 * std::sqrt(squares / count),
          border * (1.5 - 0.5 * z + 0.3 * z * z + 0.1 * std::pow(z, 1.5) * angle_term)};
}

TEST(RobotCell, AxialNoiseIsThePublishedFigureAtTwoDepths)
{
  RobotCell cell;
  const AxialNoise near_floor = axialNoiseAt(cell, 200, 400);
  const AxialNoise far_floor = axialNoiseAt(cell, 120, 240);
  EXPECT_NEAR(near_floor.measured, near_floor.published, 0.03 * near_floor.published);
  EXPECT_NEAR(far_floor.measured, far_floor.published, 0.03 * far_floor.published);
  EXPECT_GT(far_floor.measured, 1.5 * near_floor.measured);
}

TEST(RobotCell, NothingButNoiseChangesInAStandstill)
{
  RobotCell cell;
  const auto first = static_cast<std::uint32_t>(
      std::ceil(pcl_ext::cell::standstill_start * RobotCell::frame_rate));
  const auto last = static_cast<std::uint32_t>(
      std::floor(pcl_ext::cell::standstill_end * RobotCell::frame_rate));
  ASSERT_GT(last, first + 10);
  const SurfaceImage early = cell.surfaces(1, first);
  const SurfaceImage late = cell.surfaces(1, last);
  EXPECT_EQ(early.depth, late.depth);
  EXPECT_FALSE(sameBytes(capture(cell, 1, first), capture(cell, 1, last)));
}

TEST(RobotCell, EverySensorSeesMotionOutsideOfTheStandstill)
{
  RobotCell cell;
  for (unsigned int sensor = 1; sensor <= RobotCell::sensor_count; ++sensor) {
    const SurfaceImage before = cell.surfaces(sensor, 80);
    const SurfaceImage after = cell.surfaces(sensor, 95);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < before.depth.size(); ++i)
      moved += std::abs(before.depth[i] - after.depth[i]) > 0.05f;
    EXPECT_GT(moved, 500u) << sensor;
    EXPECT_LT(moved, RayGrid::size / 4) << sensor;
  }
}

TEST(RobotCell, MotionRepeatsAfterTheWorkCycle)
{
  RobotCell cell;
  const auto cycle =
      static_cast<std::uint32_t>(pcl_ext::cell::work_cycle * RobotCell::frame_rate);
  const SurfaceImage first = cell.surfaces(1, 33);
  const SurfaceImage second = cell.surfaces(1, 33 + cycle);
  std::size_t different = 0;
  for (std::size_t i = 0; i < first.depth.size(); ++i)
    different += std::abs(first.depth[i] - second.depth[i]) > 1e-4f;
  EXPECT_LT(different, 20u); // rounding of the time may move an outline by a pixel
}

TEST(RobotCell, FlyingPixelsHangAtDepthEdgesAndSpecklesAreNear)
{
  RobotCell cell;
  const ErrorModel& model = cell.errorModel();
  const SurfaceImage surfaces = cell.surfaces(1, 0);
  const CellFrame frame = capture(cell, 1, 0);
  for (std::size_t pixel = 0; pixel < RayGrid::size; ++pixel) {
    if (frame.truth[pixel] == PointTruth::Speckle) {
      ASSERT_GE(frame.cloud[pixel].z, model.speckle_nearest - 0.001);
      ASSERT_LE(frame.cloud[pixel].z, model.speckle_farthest + 0.001);
    }
    if (frame.truth[pixel] != PointTruth::FlyingPixel)
      continue;
    const std::size_t column = pixel % RayGrid::columns;
    const std::size_t row = pixel / RayGrid::columns;
    float widest = 0.0f;
    for (const std::size_t neighbour :
         {column > 0 ? pixel - 1 : pixel,
          column + 1 < RayGrid::columns ? pixel + 1 : pixel,
          row > 0 ? pixel - RayGrid::columns : pixel,
          row + 1 < RayGrid::rows ? pixel + RayGrid::columns : pixel})
      widest =
          std::max(widest, std::abs(surfaces.depth[pixel] - surfaces.depth[neighbour]));
    ASSERT_GT(widest, model.edge_step);
  }
}

TEST(RobotCell, LossesGrowWithRange)
{
  RobotCell cell;
  const SurfaceImage surfaces = cell.surfaces(1, 0);
  const CellFrame frame = capture(cell, 1, 0);
  std::array<double, 2> seen{};
  std::array<double, 2> lost{};
  for (std::size_t i = 0; i < RayGrid::size; ++i) {
    const std::size_t far = surfaces.depth[i] > 7.0f ? 1 : 0;
    seen[far] += 1.0;
    lost[far] += frame.truth[i] == PointTruth::None ? 1.0 : 0.0;
  }
  EXPECT_GT(lost[1] / seen[1], lost[0] / seen[0] + 0.2);
}

TEST(RobotCell, WorkloadOfSensor1IsThePapers)
{
  RobotCell cell;
  const Eigen::Isometry3d pose = cell.sensorPose(1);
  constexpr std::uint32_t step = 50;
  Workload mean;
  for (std::uint32_t frame = 0; frame < 300; frame += step) {
    const Workload workload = workloadOf(capture(cell, 1, frame), pose);
    mean.points += workload.points / (300 / step);
    mean.voxels_4cm += workload.voxels_4cm / (300 / step);
    mean.voxels_2cm += workload.voxels_2cm / (300 / step);
  }
  EXPECT_NEAR(mean.points, 37100, 0.03 * 37100);
  EXPECT_NEAR(mean.voxels_4cm, 17800, 0.03 * 17800);
  EXPECT_NEAR(mean.voxels_2cm, 33300, 0.03 * 33300);
}

} // namespace

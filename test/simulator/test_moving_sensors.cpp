// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/robot_cell.h"
#include "simulator/scene.h"
#include "simulator/sensor_motion.h"
#include "support/cell_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using pcl_ext::cell::Box;
using pcl_ext::cell::Capsule;
using pcl_ext::cell::CellFrame;
using pcl_ext::cell::ErrorModel;
using pcl_ext::cell::handCamera;
using pcl_ext::cell::LidarErrorModel;
using pcl_ext::cell::LidarFrame;
using pcl_ext::cell::mobileLidar;
using pcl_ext::cell::PointTruth;
using pcl_ext::cell::RobotCell;
using pcl_ext::cell::Solid;
using pcl_ext::cell::Solids;
using pcl_ext::cell::test::capture;
using pcl_ext::cell::test::sameBytes;

constexpr double pi = 3.14159265358979323846;

LidarFrame
captureLidar(RobotCell& cell, std::uint32_t revolution)
{
  LidarFrame captured;
  cell.captureLidar(revolution, captured);
  return captured;
}

/** \brief Same coordinates (NaN included), truth and pose. */
template <typename FrameT>
bool
sameFrame(const FrameT& one, const FrameT& other)
{
  return sameBytes(one, other) && one.pose.matrix() == other.pose.matrix();
}

double
distanceFrom(const Solid& solid, const Vector3d& point)
{
  if (const auto* box = std::get_if<Box>(&solid)) {
    const Vector3d outside =
        (box->pose.inverse() * point).cwiseAbs() - box->half_extents;
    return outside.maxCoeff() > 0.0 ? outside.cwiseMax(0.0).norm()
                                    : -outside.maxCoeff();
  }
  const auto& capsule = std::get<Capsule>(solid);
  const Vector3d axis = capsule.to - capsule.from;
  const double share =
      axis.squaredNorm() > 0.0
          ? std::clamp((point - capsule.from).dot(axis) / axis.squaredNorm(), 0.0, 1.0)
          : 0.0;
  return std::abs((point - capsule.from - share * axis).norm() - capsule.radius);
}

Solids
allSolids(double time)
{
  Solids solids = pcl_ext::cell::staticEquipment();
  for (const Solids& movers :
       {pcl_ext::cell::movingMachines(time), pcl_ext::cell::walkingPerson(time)})
    solids.insert(solids.end(), movers.begin(), movers.end());
  return solids;
}

double
distanceFromNearest(const Solids& solids, const Vector3d& point)
{
  double nearest = std::numeric_limits<double>::infinity();
  for (const Solid& solid : solids)
    nearest = std::min(nearest, distanceFrom(solid, point));
  return nearest;
}

/** \brief Mean distance of a frame's surface points from the surfaces.
 * \param[in] pose that moves the points into the world
 * \param[in] most the distance that the noise of a point can make, of the point in the
 * sensor's frame
 */
template <typename FrameT, typename MostT>
double
meanDistance(const FrameT& frame,
             const Isometry3d& pose,
             const Solids& solids,
             const MostT& most)
{
  constexpr std::size_t step = 23; // of the points, for time
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < frame.cloud.size(); i += step) {
    if (frame.truth[i] != PointTruth::Surface)
      continue;
    const Vector3d point = frame.cloud[i].getVector3fMap().template cast<double>();
    const double distance = distanceFromNearest(solids, pose * point);
    EXPECT_LT(distance, most(point)) << i;
    sum += distance;
    count += 1.0;
  }
  EXPECT_GT(count, 1000.0);
  return sum / count;
}

double
anyDistance(const Vector3d&)
{
  return std::numeric_limits<double>::infinity();
}

TEST(MovingSensors, TheGripperIsAtRestInTheHandsFrame)
{
  for (const double time : {0.0, 0.7, 4.1, 9.3, 13.9}) {
    const Isometry3d to_hand = pcl_ext::cell::handPose(time).inverse();
    std::size_t fingers = 0;
    for (const Solid& solid : pcl_ext::cell::movingMachines(time)) {
      const auto* capsule = std::get_if<Capsule>(&solid);
      if (capsule == nullptr || capsule->radius != 0.025 || fingers == 2)
        continue; // the first two fingers are those of this arm
      const double side = fingers++ == 0 ? 0.15 : -0.15;
      EXPECT_LT((to_hand * capsule->from - Vector3d(side, 0, 0)).norm(), 1e-9);
      EXPECT_LT((to_hand * capsule->to - Vector3d(side, 0, 0.18)).norm(), 1e-9);
    }
    EXPECT_EQ(fingers, 2u);
  }
}

TEST(MovingSensors, TheMobileLidarDrivesAheadAtConstantSpeed)
{
  constexpr double lap = 2.0 * (5.6 + pi * 0.6); // seconds at 1 m/s
  constexpr double h = 1e-5;
  EXPECT_LT((mobileLidar(0.0).translation() - Vector3d(6.2, 0.7, 1.0)).norm(), 1e-12);
  // The end of the half circle, where the way back begins.
  const Isometry3d turned = mobileLidar(1.6 + pi * 0.6);
  EXPECT_LT((turned.translation() - Vector3d(7.8, 1.9, 1.0)).norm(), 1e-9);
  EXPECT_LT((turned.linear().col(0) + Vector3d::UnitX()).norm(), 1e-9);
  for (double time = 0.01; time < 1.2 * lap; time += 0.037) {
    const Isometry3d pose = mobileLidar(time);
    const Isometry3d next = mobileLidar(time + h);
    const Vector3d velocity =
        (next.translation() - mobileLidar(time - h).translation()) / (2.0 * h);
    ASSERT_LT((velocity - pose.linear().col(0)).norm(), 1e-4) << time;
    ASSERT_LT((pose.linear().col(2) - Vector3d::UnitZ()).norm(), 1e-12);
    const double rate =
        AngleAxisd(pose.linear().transpose() * next.linear()).angle() / h;
    ASSERT_LT(rate, 1.0 / 0.6 + 1e-4) << time;
    ASSERT_LT((mobileLidar(time + lap).matrix() - pose.matrix()).norm(), 1e-9) << time;
  }
}

TEST(MovingSensors, NoSensorMovesThroughASolid)
{
  for (double time = 0.0; time < 30.0; time += 0.1) {
    const Solids solids = allSolids(time);
    ASSERT_GT(distanceFromNearest(solids, mobileLidar(time).translation()), 0.1);
    ASSERT_GT(distanceFromNearest(solids, handCamera(time).translation()), 0.1);
  }
}

TEST(MovingSensors, FramesHaveThePoseOfTheirTime)
{
  RobotCell cell;
  cell.moveSensor(2, handCamera);
  cell.moveSensor(RobotCell::lidar, mobileLidar);
  for (const std::uint32_t frame : {0u, 7u, 90u}) {
    const Isometry3d camera = handCamera(frame / 20.0);
    EXPECT_EQ(capture(cell, 2, frame).pose.matrix(), camera.matrix());
    EXPECT_EQ(cell.sensorPose(2, frame).matrix(), camera.matrix());
    const Isometry3d lidar = mobileLidar(frame / 10.0);
    EXPECT_EQ(captureLidar(cell, frame).pose.matrix(), lidar.matrix());
    EXPECT_EQ(cell.lidarPose(frame).matrix(), lidar.matrix());
  }
  EXPECT_EQ(capture(cell, 1, 7).pose.matrix(), RobotCell().sensorPose(1).matrix());
}

TEST(MovingSensors, PointsOfTheHandCameraLieOnTheSurfaces)
{
  RobotCell cell;
  cell.moveSensor(1, handCamera);
  const ErrorModel& model = cell.errorModel();
  // Six standard deviations at the steepest angle, in a corner, and half a millimetre.
  const auto noise = [&](const Vector3d& point) {
    const double sigma =
        (1.0 + model.corner_noise_growth) *
        ErrorModel::axialNoise(point.z(), model.steepest_modelled_angle);
    return (6.0 * sigma + 0.0006) * point.norm() / point.z();
  };
  for (const std::uint32_t number : {0u, 21u, 100u}) {
    const CellFrame frame = capture(cell, 1, number);
    const Solids solids = allSolids(number / 20.0);
    const double mean = meanDistance(frame, frame.pose, solids, noise);
    EXPECT_LT(mean, 0.01) << number;
    // With the pose of another frame they do not.
    EXPECT_GT(meanDistance(frame, handCamera(number / 20.0 + 0.5), solids, anyDistance),
              3.0 * mean)
        << number;
  }
}

TEST(MovingSensors, PointsOfTheMobileLidarLieOnTheSurfaces)
{
  RobotCell cell;
  cell.moveSensor(RobotCell::lidar, mobileLidar);
  const LidarErrorModel model;
  const double most = 6.0 * model.range_noise + model.range_step;
  for (const std::uint32_t number : {0u, 25u, 63u}) {
    const LidarFrame frame = captureLidar(cell, number);
    const Solids solids = allSolids(number / 10.0);
    const double mean = meanDistance(
        frame, frame.pose, solids, [most](const Vector3d&) { return most; });
    EXPECT_LT(mean, model.range_noise) << number;
    EXPECT_GT(
        meanDistance(frame, mobileLidar(number / 10.0 + 0.5), solids, anyDistance),
        3.0 * mean)
        << number;
  }
}

TEST(MovingSensors, AMotionThatRestsGivesTheFixedSensorsFrames)
{
  RobotCell fixed(3);
  RobotCell resting(3);
  const Isometry3d camera = fixed.sensorPose(5);
  const Isometry3d lidar = fixed.lidarPose();
  resting.moveSensor(5, [camera](double) { return camera; });
  resting.moveSensor(RobotCell::lidar, [lidar](double) { return lidar; });
  for (const std::uint32_t frame : {0u, 31u, 95u}) {
    EXPECT_TRUE(sameFrame(capture(resting, 5, frame), capture(fixed, 5, frame)));
    const LidarFrame revolution = captureLidar(fixed, frame);
    const LidarFrame same = captureLidar(resting, frame);
    EXPECT_TRUE(sameFrame(revolution, same));
    for (std::size_t i = 0; i < same.cloud.size(); ++i)
      ASSERT_EQ(same.cloud[i].intensity, revolution.cloud[i].intensity);
  }
}

TEST(MovingSensors, FramesDependOnSeedMotionAndNumberAlone)
{
  RobotCell forwards(7);
  RobotCell backwards(7);
  for (RobotCell* cell : {&forwards, &backwards}) {
    cell->moveSensor(1, handCamera);
    cell->moveSensor(RobotCell::lidar, mobileLidar);
  }
  const CellFrame first = capture(forwards, 1, 4);
  const LidarFrame revolution = captureLidar(forwards, 4);
  const CellFrame later = capture(forwards, 1, 57);
  EXPECT_TRUE(sameFrame(later, capture(backwards, 1, 57)));
  captureLidar(backwards, 57);
  EXPECT_TRUE(sameFrame(first, capture(backwards, 1, 4)));
  EXPECT_TRUE(sameFrame(revolution, captureLidar(backwards, 4)));

  RobotCell other_seed(8);
  other_seed.moveSensor(1, handCamera);
  EXPECT_FALSE(sameFrame(first, capture(other_seed, 1, 4)));
}

TEST(MovingSensors, OtherSensorsStayAndASensorCanBeFixedAgain)
{
  RobotCell fixed;
  RobotCell cell;
  const CellFrame before = capture(cell, 1, 12);
  cell.moveSensor(1, handCamera);
  EXPECT_FALSE(sameFrame(capture(cell, 1, 12), before));
  EXPECT_TRUE(sameFrame(capture(cell, 2, 12), capture(fixed, 2, 12)));
  EXPECT_TRUE(sameFrame(captureLidar(cell, 12), captureLidar(fixed, 12)));
  cell.moveSensor(1, nullptr);
  EXPECT_TRUE(sameFrame(capture(cell, 1, 12), before));
}

TEST(MovingSensors, RefusesSensorsThatAreNotThere)
{
  RobotCell cell;
  EXPECT_THROW(cell.moveSensor(0, handCamera), std::out_of_range);
  EXPECT_THROW(cell.moveSensor(RobotCell::lidar + 1, mobileLidar), std::out_of_range);
}

} // namespace

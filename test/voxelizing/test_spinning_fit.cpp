// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
// The rays of lidars whose points come as their lasers are fired.
#include "voxelizing/firing_columns.h"
#include "voxelizing/scan_locator.h"
#include "voxelizing/spinning_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

using namespace pcl_ext;
using namespace pcl_ext::io;

namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;

/** \brief Rows of a lidar, in the order in which they are fired. */
const std::vector<std::uint32_t> fired = {0, 4, 1, 5, 2, 6, 3, 7};

/** \brief A turn of a lidar of 8 rows in a room: its columns are 0.18 or 0.21 degrees
 * apart, each row is turned against them, ranges are multiples of 4 mm, as floats. A
 * tenth of the points is missing.
 * \param[in] velocity metres a turn
 * \param[in] spin radians a turn
 */
std::vector<PixelPoint>
makeTurn(std::vector<std::uint32_t>& rows,
         const Eigen::Vector3d& velocity = Eigen::Vector3d::Zero(),
         const Eigen::Vector3d& spin = Eigen::Vector3d::Zero())
{
  std::mt19937 random(17);
  std::vector<PixelPoint> points;
  double angle = 0.0;
  for (std::uint32_t column = 0; column < 1800; ++column) {
    angle += column % 3 == 0 ? 0.21 : 0.18;
    for (const std::uint32_t row : fired) {
      if (random() % 10 == 0)
        continue;
      const double azimuth = (angle + 0.7 * std::sin(row)) * degree;
      const double elevation = (2.0 * row - 9.0) * degree;
      const double wall =
          3.0 / std::max(std::abs(std::cos(azimuth)), std::abs(std::sin(azimuth)));
      const double range = 0.004 * std::round(wall / std::cos(elevation) / 0.004 +
                                              static_cast<double>(random() % 3));
      const double distance = range * std::cos(elevation);
      const Eigen::Vector3d still(distance * std::cos(azimuth),
                                  distance * std::sin(azimuth),
                                  range * std::sin(elevation));
      const double time = timeOf(column, 1800);
      const Eigen::Vector3d moved = still + time * spin.cross(still) + time * velocity;
      points.push_back({row, column, moved.cast<float>().cast<double>()});
      rows.push_back(row);
    }
  }
  return points;
}

TEST(FiringColumns, FindsTheOrderOfRowsAndTheColumns)
{
  std::vector<std::uint32_t> rows;
  const std::vector<PixelPoint> points = makeTurn(rows);
  const std::vector<std::uint32_t> ranks = firingRanks(rows, 8);
  for (std::uint32_t rank = 0; rank < fired.size(); ++rank)
    EXPECT_EQ(ranks[fired[rank]], rank);
  const std::vector<std::uint32_t> found = firingColumns(rows, ranks);
  for (std::size_t i = 0; i < points.size(); ++i)
    ASSERT_EQ(found[i], points[i].column);
}

TEST(SpinningFit, FindsRowsDepthsAndAngles)
{
  std::vector<std::uint32_t> rows;
  const std::vector<PixelPoint> points = makeTurn(rows);
  const auto fit = fitSpinning(points, 8, 1800, 0.001);
  ASSERT_TRUE(fit.has_value());
  EXPECT_DOUBLE_EQ(fit->depth_step, 0.004);
  EXPECT_NEAR(fit->turn_step, 0.01 * degree, 1e-12);
  for (std::uint32_t row = 0; row < 8; ++row) {
    EXPECT_NEAR(std::atan2(fit->rows[row].rise, fit->rows[row].run),
                (2.0 * row - 9.0) * degree,
                1e-6);
    EXPECT_NEAR(std::remainder(fit->rows[row].angle - fit->rows[0].angle -
                                   0.7 * std::sin(row) * degree,
                               0.01 * degree),
                0.0,
                1e-6);
  }
}

TEST(SpinningFit, NeedsNoPointsInTheColumnsThatMotionIsFoundInFirst)
{
  // Each third firing, of which the motion is found first, is too near the sensor.
  std::vector<PixelPoint> points;
  for (std::uint32_t column = 0; column < 60; ++column)
    for (std::uint32_t row = 0; row < 16; ++row) {
      const double angle = 0.1 * column;
      const double distance =
          column % 3 == 0 ? 0.2 : 5.0 + 0.3 * ((column * 7 + row * 3) % 11);
      const double off = column % 3 == 0 ? 0.0 : 0.003 * ((column * 13 + row * 5) % 7);
      points.push_back({row,
                        column,
                        Eigen::Vector3d(distance * std::cos(angle),
                                        distance * std::sin(angle),
                                        distance * (-0.2 + 0.02 * row) + off)});
    }
  const auto fit = fitSpinning(points, 16, 60, 0.01);
  ASSERT_TRUE(fit.has_value());
  EXPECT_EQ(fit->rows.size(), 16u);
}

/** \brief Puts points on the rays of a fit, in a grid of 1 mm, with the sensor
 * somewhere. */
scan::ScanFrame
locate(const SpinningFit& fit, const std::vector<PixelPoint>& points)
{
  WorldPose pose = WorldPose::Identity();
  pose.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
  pose.pretranslate(Eigen::Vector3d(1.0, -2.0, 0.5));
  scan::ScanFrame frame;
  frame.grid.resolution = 0.001;
  frame.grid.depth = 16;
  frame.grid.first_index = {-(1 << 15), -(1 << 15), -(1 << 15)};
  frame.width = 1800;
  frame.height = 8;
  EXPECT_TRUE(setSpinningRays(fit, pose, frame.grid, frame));
  frame.rays.columns.resize(frame.width);
  for (const PixelPoint& point : points) {
    const Eigen::Vector3d still =
        fit.motion.stillPosition(point.position, timeOf(point.column, frame.width));
    const double angle = std::atan2(still.y(), still.x()) - fit.rows[point.row].angle;
    frame.rays.columns[point.column] =
        static_cast<std::int32_t>(std::lround(angle / fit.turn_step));
  }
  ScanLocator locator(frame);
  std::vector<std::array<double, 3>> positions;
  for (const PixelPoint& point : points) {
    const Eigen::Vector3d position = pose * point.position;
    positions.push_back({position.x(), position.y(), position.z()});
  }
  for (std::uint32_t row = 0; row < frame.height; ++row) {
    std::vector<std::uint32_t> columns;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < points.size(); ++i)
      if (points[i].row == row) {
        columns.push_back(points[i].column);
        indices.push_back(i);
      }
    EXPECT_TRUE(locator.append(row, columns, positions, indices.data()));
  }
  return frame;
}

TEST(SpinningFit, PointsAreOnItsRays)
{
  std::vector<std::uint32_t> rows;
  const std::vector<PixelPoint> points = makeTurn(rows);
  const auto fit = fitSpinning(points, 8, 1800, 0.001);
  ASSERT_TRUE(fit.has_value());
  EXPECT_FALSE(fit->has_motion);
  EXPECT_TRUE(fit->motion.velocity.isZero());
  const scan::ScanFrame frame = locate(*fit, points);
  EXPECT_EQ(frame.pixels.size(), points.size());
  EXPECT_TRUE(frame.beside.empty());
}

TEST(SpinningFit, FindsHowTheSensorMoved)
{
  std::vector<std::uint32_t> rows;
  const Eigen::Vector3d velocity(0.4, -0.1, 0.02);
  const Eigen::Vector3d spin(0.002, -0.001, 0.0);
  const std::vector<PixelPoint> points = makeTurn(rows, velocity, spin);
  const auto fit = fitSpinning(points, 8, 1800, 0.001);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT((fit->motion.velocity - velocity).norm(), 0.001);
  EXPECT_LT((fit->motion.spin - spin).head<2>().norm(), 0.0002);
  EXPECT_DOUBLE_EQ(fit->depth_step, 0.004);
  const scan::ScanFrame frame = locate(*fit, points);
  EXPECT_LT(frame.beside.size(), points.size() / 20);
}

TEST(SpinningFit, FollowsHowTheSensorMoves)
{
  std::vector<std::uint32_t> rows;
  auto fit = fitSpinning(
      makeTurn(rows, {0.4, -0.1, 0.02}, {0.002, -0.001, 0.0}), 8, 1800, 0.001);
  ASSERT_TRUE(fit.has_value());
  ASSERT_TRUE(fit->has_motion);
  const Eigen::Vector3d velocity(0.3, 0.2, 0.02);
  const std::vector<PixelPoint> points = makeTurn(rows, velocity, {0.001, 0.001, 0.0});
  followMotion(points, 1800, *fit);
  EXPECT_LT((fit->motion.velocity - velocity).norm(), 0.001);
  EXPECT_LT(locate(*fit, points).beside.size(), points.size() / 20);
}

TEST(SpinningFit, FewPointsAreNoLidar)
{
  EXPECT_FALSE(fitSpinning({{0, 0, {1.0, 0.0, 0.0}}}, 8, 1800, 0.001).has_value());
}

} // namespace

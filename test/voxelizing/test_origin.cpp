// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/point_view.h>

#include "support/point_views.h"
#include "support/voxel_frames.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using Points = std::vector<std::array<float, 3>>;

Points
pointsAt(const std::array<double, 3>& place, std::size_t count, double width)
{
  std::mt19937_64 random(23);
  Points points(count);
  for (auto& point : points)
    for (std::size_t axis = 0; axis < 3; ++axis)
      point[axis] = uniform(random, place[axis] - width, place[axis] + width);
  return points;
}

/** \brief Largest distance, metres, from a point to the centre of its voxel on an
 * axis. */
double
largestError(const Points& points, const VoxelFrame& frame)
{
  double largest = 0.0;
  for (const auto& point : points) {
    double nearest = 1e30;
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
      const VoxelPosition at = voxelPosition(frame.keys[voxel]);
      double error = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        error = std::max(error,
                         std::abs(static_cast<double>(point[axis]) -
                                  frame.grid.centre(axis,
                                                    axis == 0   ? at.x
                                                    : axis == 1 ? at.y
                                                                : at.z)));
      nearest = std::min(nearest, error);
    }
    largest = std::max(largest, nearest);
  }
  return largest;
}

VoxelizationStatistics
voxelize(Voxelizer& voxelizer, const Points& points, VoxelFrame& frame)
{
  return voxelizer.voxelize(viewOf(points), false, frame);
}

// UTM coordinates of a town: 20 km and more beyond the lattice of 1 cm at the origin.
constexpr std::array<double, 3> town{600123.0, 6643210.0, 120.0};

TEST(Origin, OfFarCloudsIsAmidTheirPointsAtACornerOfAVoxelOfTheWorld)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.01;
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  const Points points = pointsAt(town, 300, 30.0);
  VoxelFrame frame;
  const VoxelizationStatistics statistics = voxelize(voxelizer, points, frame);
  EXPECT_EQ(statistics.points_used, points.size());
  EXPECT_EQ(statistics.points_outside_grid, 0u);
  ASSERT_TRUE(isConsistent(frame));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(frame.grid.origin[axis], town[axis], 30.0);
    const double voxels = frame.grid.origin[axis] / settings.resolution;
    EXPECT_NEAR(voxels, std::round(voxels), 1e-4);
  }
  EXPECT_LE(largestError(points, frame), settings.resolution / 2.0 + 1e-6);
}

TEST(Origin, OfNearCloudsIsThatOfTheWorld)
{
  IntensityCompressionSettings settings;
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  Points points = pointsAt({10.0, -20.0, 3.0}, 100, 30.0);
  points[5] = {1e6f, 0.0f, 0.0f}; // one far outlier does not matter
  VoxelFrame frame;
  const VoxelizationStatistics statistics = voxelize(voxelizer, points, frame);
  EXPECT_EQ(statistics.points_outside_grid, 1u);
  EXPECT_EQ(frame.grid.origin, VoxelGrid().origin);
}

TEST(Origin, FollowsASensorThatLeavesTheLattice)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.01; // the lattice ends at 10486 m
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  std::array<double, 3> origin{};
  unsigned int origins = 1;
  for (double x = 10400.0; x < 10700.0; x += 20.0) {
    const Points points = pointsAt({x, 0.0, 0.0}, 200, 20.0);
    VoxelFrame frame;
    const VoxelizationStatistics statistics = voxelize(voxelizer, points, frame);
    EXPECT_EQ(statistics.points_used, points.size()) << x;
    origins += frame.grid.origin != origin ? 1 : 0;
    origin = frame.grid.origin;
  }
  EXPECT_EQ(origins, 2u);
}

TEST(Origin, IsInTheMiddleOfWideCloudsWhereAnIFrameIsDue)
{
  // Most points are at the sensor, a few up to 200 m from it on one side.
  IntensityCompressionSettings settings;
  settings.resolution = 0.0001; // the lattice ends at 105 m
  Points points = pointsAt({0.0, 0.0, 0.0}, 2000, 3.0);
  points.push_back({199.0f, 0.0f, 0.0f});
  points.push_back({std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f});
  VoxelFrame frame;
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  EXPECT_EQ(voxelize(voxelizer, points, frame).points_outside_grid, 1u);
  const VoxelizationStatistics statistics =
      voxelizer.voxelize(viewOf(points), true, frame);
  EXPECT_EQ(statistics.points_outside_grid, 0u);
  EXPECT_NEAR(frame.grid.origin[0], 98.0, 0.01);
  // But not for a cloud that no origin has on its lattice.
  points.push_back({-500.0f, 0.0f, 0.0f});
  Voxelizer other(settings, pcl_ext::IntensityUnit::Points);
  EXPECT_EQ(other.voxelize(viewOf(points), true, frame).points_outside_grid, 2u);
  EXPECT_EQ(frame.grid.origin, VoxelGrid().origin);
}

TEST(Origin, DoesNotMoveForAFewPointsMore)
{
  // Clouds wider than the lattice: no origin has all of their points.
  IntensityCompressionSettings settings;
  settings.resolution = 0.0001; // the lattice ends at 105 m
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  VoxelFrame frame;
  std::array<double, 3> origin{};
  unsigned int origins = 0;
  for (int cloud = 0; cloud < 20; ++cloud) {
    const double wander = 0.5 * (cloud % 3);
    const Points points = pointsAt({wander, -wander, 0.0}, 2000, 150.0);
    EXPECT_GT(voxelize(voxelizer, points, frame).points_outside_grid, 0u);
    origins += cloud == 0 || frame.grid.origin != origin ? 1 : 0;
    origin = frame.grid.origin;
  }
  EXPECT_LE(origins, 2u);
}

TEST(Origin, OfTheSettingsIsKept)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.01;
  settings.origin = {600000.0, 6640000.0, 0.0};
  ASSERT_TRUE(checkSettings(settings).ok());
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  VoxelFrame frame;
  voxelize(voxelizer, pointsAt(town, 100, 5.0), frame);
  EXPECT_EQ(frame.grid.origin, *settings.origin);
  EXPECT_EQ(frame.size(), 100u);
  // Points off its lattice are counted, not followed.
  const VoxelizationStatistics statistics =
      voxelize(voxelizer, pointsAt({0.0, 0.0, 0.0}, 100, 5.0), frame);
  EXPECT_EQ(statistics.points_outside_grid, 100u);
  EXPECT_EQ(frame.grid.origin, *settings.origin);
}

TEST(Origin, OfAFarBoxIsInTheBox)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.01;
  settings.bounding_box = BoundingBox{{town[0] - 10.0, town[1] - 10.0, town[2] - 10.0},
                                      {town[0] + 10.0, town[1] + 10.0, town[2] + 10.0}};
  ASSERT_TRUE(checkSettings(settings).ok());
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  const Points points = pointsAt(town, 100, 9.0);
  VoxelFrame frame;
  EXPECT_EQ(voxelize(voxelizer, points, frame).points_used, points.size());
  EXPECT_LE(largestError(points, frame), settings.resolution / 2.0 + 1e-6);
}

TEST(Origin, DoublesKeepThePrecisionOfFarCoordinates)
{
  // Floats are 0.5 m apart there.
  const std::array<double, 3> place{600000.0, 5200000.0, 400.0};
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> offset(0.0, 100.0);
  std::vector<std::array<double, 3>> points(150000); // enough for two threads
  std::set<std::array<double, 3>> voxels;
  IntensityCompressionSettings settings;
  for (auto& point : points) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      point[axis] = place[axis] + offset(random);
    voxels.insert({std::floor(point[0] / settings.resolution),
                   std::floor(point[1] / settings.resolution),
                   std::floor(point[2] / settings.resolution)});
  }
  const PointView view = viewOf(points);
  for (settings.threads = 1; settings.threads <= 2; ++settings.threads) {
    Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
    VoxelFrame frame;
    EXPECT_EQ(voxelizer.voxelize(view, false, frame).points_used, points.size());
    ASSERT_EQ(frame.size(), voxels.size());
    EXPECT_TRUE(frame.grid.needsDoubles());
    forEachPreciseCentre(frame, [&](double x, double y, double z, float) {
      const double edge = settings.resolution;
      ASSERT_EQ(voxels.count(
                    {std::floor(x / edge), std::floor(y / edge), std::floor(z / edge)}),
                1u);
    });
  }
}

/** \brief Expects that doubles are in the voxels that division in double precision
 * says. */
void
expectVoxelsOfDivision(const std::vector<std::array<double, 3>>& points,
                       const IntensityCompressionSettings& settings)
{
  const PointView view = viewOf(points);
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  VoxelFrame frame;
  voxelizer.voxelize(view, false, frame);
  std::set<std::array<double, 3>> expected;
  for (const auto& point : points) {
    std::array<double, 3> index;
    bool is_in_box = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      index[axis] =
          std::floor((point[axis] - frame.grid.origin[axis]) / settings.resolution);
      if (settings.bounding_box)
        is_in_box = is_in_box && point[axis] >= settings.bounding_box->min[axis] &&
                    point[axis] <= settings.bounding_box->max[axis];
    }
    if (is_in_box)
      expected.insert(index);
  }
  std::set<std::array<double, 3>> voxels;
  for (const std::uint64_t key : frame.keys) {
    const VoxelPosition at = voxelPosition(key);
    voxels.insert({static_cast<double>(frame.grid.first_index[0]) + at.x,
                   static_cast<double>(frame.grid.first_index[1]) + at.y,
                   static_cast<double>(frame.grid.first_index[2]) + at.z});
  }
  EXPECT_TRUE(voxels == expected);
}

TEST(Origin, DoublesAtFacesAreInTheVoxelsOfDivision)
{
  std::mt19937_64 random(43);
  for (const std::array<double, 3>& place :
       {std::array<double, 3>{0.0, 0.0, 0.0}, {600000.0, -5200000.0, 400.0}})
    for (const double resolution : {0.01, 0.04, 1.0 / 3.0}) {
      std::vector<std::array<double, 3>> points(3000);
      for (auto& point : points)
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto index = static_cast<double>(random() % 200) - 100.0;
          point[axis] = place[axis] + index * resolution;
          const std::uint64_t choice = random() % 4;
          if (choice < 2)
            point[axis] = std::nextafter(point[axis], choice == 0 ? 1e300 : -1e300);
          else if (choice == 2)
            point[axis] += static_cast<double>(uniform(random, 0.0, 1.0)) * resolution;
        }
      IntensityCompressionSettings settings;
      settings.resolution = resolution;
      expectVoxelsOfDivision(points, settings);
      settings.bounding_box = BoundingBox{points[0], points[0]};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        settings.bounding_box->min[axis] -= 20.0 * resolution;
        settings.bounding_box->max[axis] += 20.0 * resolution;
      }
      expectVoxelsOfDivision(points, settings);
    }
}

TEST(Origin, DoublesMayHaveAnyMagnitude)
{
  constexpr double highest = std::numeric_limits<double>::max();
  const std::vector<std::array<double, 3>> points{
      {highest, -highest, 1e300},
      {0.0, std::numeric_limits<double>::denorm_min(), -0.0},
      {std::numeric_limits<double>::infinity(), 0.0, 0.0}};
  const PointView view = viewOf(points);
  Voxelizer voxelizer(IntensityCompressionSettings(), pcl_ext::IntensityUnit::Points);
  VoxelFrame frame;
  const VoxelizationStatistics statistics = voxelizer.voxelize(view, true, frame);
  EXPECT_EQ(statistics.points_used, 1u);
  EXPECT_EQ(statistics.points_outside_grid, 1u);
  EXPECT_EQ(statistics.points_not_finite, 1u);
  EXPECT_FALSE(frame.grid.needsDoubles());
}

float
anyFloat(std::mt19937_64& random)
{
  const auto bits = static_cast<std::uint32_t>(random());
  float number;
  std::memcpy(&number, &bits, sizeof(number));
  return number;
}

TEST(Origin, OfAPointAtTheEndOfTheLatticeIsFoundAtOnce)
{
  // The lattice of the new origin ends at 0, around which are a billion floats.
  IntensityCompressionSettings settings;
  for (const double resolution : {0.001, 0.01, 0.04, 0.05}) {
    settings.resolution = resolution;
    const auto end = static_cast<float>(std::exp2(20) * resolution);
    for (const float at : {end, -end}) {
      Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
      VoxelFrame frame;
      const Points points{{at, -at, std::nextafter(at, 2.0f * at)}};
      EXPECT_EQ(voxelize(voxelizer, points, frame).points_used, 1u) << at;
    }
  }
}

TEST(Origin, IsFoundAtOnceForCoordinatesOfAllMagnitudes)
{
  // With a walk from float to float this would take minutes.
  std::mt19937_64 random(31);
  IntensityCompressionSettings settings;
  for (int i = 0; i < 2000; ++i) {
    settings.resolution = std::exp2(uniform(random, -19.0, 19.0));
    // A whole number of voxels away, as far as the lattice reaches and around it.
    const double end = std::exp2(20) * settings.resolution;
    Points points{{anyFloat(random), anyFloat(random), anyFloat(random)}};
    for (const double off : {0.0, 0.5, -0.5, 1.0})
      points.push_back({static_cast<float>(end + off * settings.resolution),
                        static_cast<float>(-end + off * settings.resolution),
                        anyFloat(random)});
    if (i % 2 != 0)
      settings.origin = {end, -end, static_cast<double>(points[1][0])};
    else
      settings.origin.reset();
    ASSERT_TRUE(checkSettings(settings).ok());
    Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
    VoxelFrame frame;
    const VoxelizationStatistics statistics = voxelize(voxelizer, points, frame);
    ASSERT_TRUE(isConsistent(frame));
    EXPECT_EQ(statistics.points_used + statistics.points_not_finite +
                  statistics.points_outside_grid,
              points.size());
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief VoxelOutlierRemoval with the unit Rays, against the formula of
 * doc/outlier_removal.md computed voxel by voxel.
 */
#include "support/outlier_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext;
using Vector = std::array<double, 3>;

struct Lidar {
  Vector position{};
  Vector up = {0.0, 0.0, 1.0};
  double azimuth_step = 0.0035;
  double elevation_step = 0.007;
};

enum class Counts { None, Points, Intensities };

double
dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

std::int64_t
coarseWidth(double edge)
{
  std::int64_t width = 1;
  while (static_cast<double>(width) * edge < 0.0199999)
    width *= 2;
  return width;
}

double
scoreAt(const LatticeIndex& at,
        const std::map<LatticeIndex, std::int64_t>& points,
        const io::VoxelGrid& grid,
        const Lidar& lidar,
        double most)
{
  const double edge =
      grid.resolution * static_cast<double>(coarseWidth(grid.resolution));
  Vector ray;
  for (std::size_t axis = 0; axis < 3; ++axis)
    ray[axis] = (static_cast<double>(at[axis]) + 0.5) * edge + grid.origin[axis] -
                lidar.position[axis];
  const double range = std::max(std::sqrt(dot(ray, ray)), 0.001);
  const double elevation = std::asin(std::clamp(dot(ray, lidar.up) / range, -1.0, 1.0));
  const double cosine = std::max(0.1, std::cos(elevation));
  const auto hits = [&](double width) {
    return std::max(1.0, width / (range * lidar.azimuth_step * cosine)) *
           std::max(1.0, width / (range * lidar.elevation_step));
  };
  double near = 0.0;
  for (std::int64_t x = -2; x <= 2; ++x)
    for (std::int64_t y = -2; y <= 2; ++y)
      for (std::int64_t z = -2; z <= 2; ++z) {
        const auto found = points.find({at[0] + x, at[1] + y, at[2] + z});
        if (found != points.end() && (x != 0 || y != 0 || z != 0))
          near += static_cast<double>(found->second);
      }
  near /= std::min(hits(5.0 * edge), 25.0 * most);
  const double own = static_cast<double>(points.at(at)) / std::min(hits(edge), most);
  return 2.0 + 3.2 * std::log(0.05 + 1.4 * own + 18.0 * near);
}

/** \brief Log-odds of the voxels of a frame, by the formula. */
std::vector<double>
bruteForce(const io::VoxelFrame& frame, const Lidar& lidar, Counts counts)
{
  const std::int64_t width = coarseWidth(frame.grid.resolution);
  const auto coarse = [&](std::size_t voxel) {
    LatticeIndex index = io::test::latticeIndex(frame, voxel);
    for (std::int64_t& coordinate : index)
      coordinate = (coordinate - (coordinate % width + width) % width) / width;
    return index;
  };
  std::map<LatticeIndex, std::int64_t> points;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    std::int64_t& sum = points[coarse(i)];
    std::int64_t number = 1;
    if (counts == Counts::Points)
      number = frame.point_counts[i];
    else if (counts == Counts::Intensities)
      number = std::llround(frame.intensity_scale.value(frame.intensities[i]));
    sum = std::min<std::int64_t>(sum + std::max<std::int64_t>(number, 1), 2047);
  }
  const double most = counts == Counts::None
                          ? std::min(16.0 * static_cast<double>(width * width), 2047.0)
                          : 2047.0;
  std::vector<double> scores;
  for (std::size_t i = 0; i < frame.size(); ++i)
    scores.push_back(scoreAt(coarse(i), points, frame.grid, lidar, most));
  return scores;
}

/** \brief Some walls, clumps and single voxels, with one point or very many. */
io::VoxelFrame
randomFrame(std::mt19937_64& random, double edge, Counts counts)
{
  Voxels voxels;
  for (int wall = 0; wall < 3; ++wall)
    for (int i = 0; i < 700; ++i)
      voxels[{static_cast<std::int64_t>(30 * wall + random() % 2),
              static_cast<std::int64_t>(random() % 40),
              static_cast<std::int64_t>(random() % 40)}] = 0;
  for (int i = 0; i < 200; ++i)
    voxels[{static_cast<std::int64_t>(random() % 120),
            static_cast<std::int64_t>(random() % 120),
            static_cast<std::int64_t>(random() % 120)}] = 0;
  const std::array<std::int32_t, 3> first = {-static_cast<std::int32_t>(random() % 70),
                                             -static_cast<std::int32_t>(random() % 70),
                                             static_cast<std::int32_t>(random() % 70)};
  Voxels moved;
  for (const auto& [index, symbol] : voxels)
    moved[{index[0] + first[0], index[1] + first[1], index[2] + first[2]}] =
        static_cast<std::uint16_t>(random() % 8 == 0 ? random() % 4000 : random() % 6);
  io::VoxelFrame frame =
      frameOf(moved, gridAt(first[0], first[1], first[2]), {1.0f, 1.0f, 12});
  frame.grid.resolution = edge;
  if (counts == Counts::Points) {
    frame.has_point_counts = true;
    for (const std::uint16_t symbol : frame.intensities)
      frame.point_counts.push_back(std::uint32_t{1} + symbol);
  }
  if (counts != Counts::Intensities) { // of no meaning then
    for (std::uint16_t& symbol : frame.intensities)
      symbol = static_cast<std::uint16_t>(random() % 4096);
  }
  EXPECT_TRUE(io::isConsistent(frame));
  return frame;
}

VoxelOutlierRemovalSettings
settingsOf(const Lidar& lidar, Counts counts)
{
  return {RaysUnit{lidar.position,
                   lidar.azimuth_step,
                   lidar.elevation_step,
                   counts == Counts::Intensities}};
}

void
expectScores(VoxelOutlierRemoval& removal,
             const io::VoxelFrame& frame,
             const Lidar& lidar,
             Counts counts)
{
  std::vector<float> log_odds;
  const OutlierRemovalStatus status = removal.score(frame, log_odds);
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.message(), "");
  EXPECT_EQ(removal.unit(), DensityUnit::Rays);
  EXPECT_EQ(removal.rememberedBlocks(), 0u);
  const std::vector<double> expected = bruteForce(frame, lidar, counts);
  ASSERT_EQ(log_odds.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(log_odds[i], expected[i], 2e-4) << i;
}

TEST(RayOutlierRemoval, LogOddsAreThoseOfTheFormula)
{
  std::mt19937_64 random(31);
  for (const double edge : {0.002, 0.005, 0.012, 0.02, 0.04, 0.1, 0.2})
    for (const Counts counts : {Counts::None, Counts::Points, Counts::Intensities}) {
      SCOPED_TRACE(edge);
      Lidar lidar;
      for (double& coordinate : lidar.position)
        coordinate = io::test::uniform(random, -400.0, 400.0) * edge;
      lidar.azimuth_step = io::test::uniform(random, 0.001, 0.01);
      lidar.elevation_step = io::test::uniform(random, 0.001, 0.05);
      VoxelOutlierRemoval removal(settingsOf(lidar, counts));
      for (int i = 0; i < 3; ++i) // frames before do not matter
        expectScores(removal, randomFrame(random, edge, counts), lidar, counts);
    }
}

TEST(RayOutlierRemoval, SensorIsAtTheOriginUnlessSetAndMayMove)
{
  std::mt19937_64 random(32);
  io::VoxelFrame frame = randomFrame(random, 0.1, Counts::Points);
  frame.grid.origin = {1000.0, -2000.0, 30.0};
  VoxelOutlierRemoval at_origin(pcl_ext::settingsOf(DensityUnit::Rays));
  expectScores(at_origin, frame, Lidar{}, Counts::Points);
  Lidar lidar;
  lidar.position = {1001.0, -1999.0, 31.0};
  VoxelOutlierRemoval removal(settingsOf(lidar, Counts::Points));
  expectScores(removal, frame, lidar, Counts::Points);
  lidar.position = {4.0, -3.0, 1.0};
  removal.setSensorPosition(lidar.position);
  expectScores(removal, frame, lidar, Counts::Points);
  // One that is not finite is refused until it is.
  removal.setSensorPosition({3.0, std::nan(""), 3.0});
  io::VoxelFrame filtered = frame;
  const OutlierRemovalStatus status = removal.filter(filtered);
  EXPECT_EQ(status.code(), OutlierRemovalCode::InvalidSettings);
  EXPECT_EQ(status.message(), "sensor_position has nan; it must be finite numbers");
  EXPECT_EQ(status.removed, 0u);
  removal.setSensorPosition(lidar.position);
  expectScores(removal, frame, lidar, Counts::Points);
}

TEST(RayOutlierRemoval, SensorMayBeInTheMiddleOfAVoxelOrFarAway)
{
  for (const double edge : {0.005, 0.1}) {
    std::mt19937_64 random(33);
    const io::VoxelFrame frame = randomFrame(random, edge, Counts::Points);
    const std::int64_t width = coarseWidth(edge);
    Lidar inside;
    const LatticeIndex index = io::test::latticeIndex(frame, 77);
    for (std::size_t axis = 0; axis < 3; ++axis)
      inside.position[axis] =
          (std::floor(static_cast<double>(index[axis]) / static_cast<double>(width)) +
           0.5) *
          static_cast<double>(width) * edge;
    Lidar far;
    far.position = {1e200, 0.0, -1e300};
    VoxelOutlierRemoval from_inside(settingsOf(inside, Counts::Points));
    expectScores(from_inside, frame, inside, Counts::Points);
    std::vector<float> log_odds;
    VoxelOutlierRemoval from_afar(settingsOf(far, Counts::Points));
    EXPECT_TRUE(from_afar.score(frame, log_odds).ok());
    for (const float score : log_odds)
      EXPECT_GT(score, 0.0f); // a point is all that there can be
  }
}

TEST(RayOutlierRemoval, GridsMayMoveAndBeEmpty)
{
  std::mt19937_64 random(34);
  const io::VoxelFrame frame = randomFrame(random, 0.01, Counts::Points);
  Lidar lidar;
  lidar.position = {0.3, -0.2, 0.5};
  VoxelOutlierRemoval removal(settingsOf(lidar, Counts::Points));
  // Also by one voxel, half a coarse one, and too far for one map of positions.
  for (const std::int32_t step : {0, 1, -3, 100, 5000000, -90}) {
    io::VoxelFrame moved = frame;
    moved.grid.first_index[0] += step;
    expectScores(removal, moved, lidar, Counts::Points);
    moved.clearVoxels();
    const OutlierRemovalStatus status = removal.filter(moved);
    EXPECT_TRUE(status.ok());
    EXPECT_EQ(status.removed, 0u);
  }
}

/** \brief A wall 8 m from the origin in voxels of 10 cm, the sensor's rays on a pole 70 m
 * away, and single flakes. */
io::VoxelFrame
snowyFrame(std::mt19937_64& random, std::set<LatticeIndex>& flakes)
{
  Voxels voxels;
  for (std::int64_t y = -30; y < 30; ++y)
    for (std::int64_t z = -8; z < 8; ++z)
      if (random() % 8 != 0)
        voxels[{80, y, z}] = 5;
  for (std::int64_t z = -30; z < 30; z += 5)
    voxels[{700, 20, z}] = 1;
  while (flakes.size() < 60)
    flakes.insert({static_cast<std::int64_t>(15 + random() % 55),
                   static_cast<std::int64_t>(random() % 60) - 30,
                   static_cast<std::int64_t>(random() % 16) - 8});
  for (const LatticeIndex& flake : flakes)
    voxels[flake] = 1;
  io::VoxelFrame frame = frameOf(voxels, gridAt(0, -100, -100, 10));
  frame.grid.resolution = 0.1;
  frame.has_point_counts = true;
  frame.point_counts.assign(frame.intensities.begin(), frame.intensities.end());
  return frame;
}

TEST(RayOutlierRemoval, FlakesGoAndSurfacesStayFromTheFirstFrameOn)
{
  std::mt19937_64 random(36);
  for (const bool has_counts : {true, false}) {
    std::set<LatticeIndex> flakes;
    io::VoxelFrame frame = snowyFrame(random, flakes);
    if (!has_counts) {
      frame.has_point_counts = false;
      frame.point_counts.clear();
    }
    const std::size_t before = frame.size();
    VoxelOutlierRemoval removal(pcl_ext::settingsOf(DensityUnit::Rays));
    const OutlierRemovalStatus status = removal.filter(frame);
    EXPECT_EQ(status.removed, before - frame.size());
    std::size_t left = 0;
    for (std::size_t i = 0; i < frame.size(); ++i)
      left += flakes.count(io::test::latticeIndex(frame, i));
    EXPECT_LE(left, 6u); // that happen to be close to each other
    EXPECT_EQ(frame.size() - left, before - flakes.size());
  }
}

/** \brief A frame with the points of a lidar that turns, which is tilted. */
io::VoxelFrame
lidarFrame(std::mt19937_64& random, double edge)
{
  io::VoxelFrame frame = randomFrame(random, edge, Counts::Points);
  io::FramePoints& points = frame.points;
  points.sensor = io::SpinningSensor{
      {50.0, 60.25, -1.5}, {0.8, 0.0, 0.6}, 6.283185307179586 / 64.0, 0.03};
  for (std::size_t i = 0; i < frame.size(); ++i) {
    frame.point_counts[i] = 1 + frame.point_counts[i] % 3;
    const io::VoxelPosition at = io::voxelPosition(frame.keys[i]);
    for (std::uint32_t point = 0; point < frame.point_counts[i]; ++point) {
      points.indices.push_back(static_cast<std::uint32_t>(points.indices.size()));
      points.positions.push_back({frame.grid.centre(0, at.x),
                                  frame.grid.centre(1, at.y),
                                  frame.grid.centre(2, at.z)});
      points.intensities.push_back(frame.intensities[i]);
    }
  }
  points.width = 64;
  points.height = 1 + static_cast<std::uint32_t>(points.indices.size() / 64);
  EXPECT_TRUE(io::isConsistent(frame));
  return frame;
}

/** \brief The sensor of a lidarFrame() in the world. */
Lidar
lidarOf(const io::VoxelFrame& frame)
{
  const io::SpinningSensor& sensor = frame.points.sensor.value();
  Lidar lidar;
  lidar.up = sensor.up;
  lidar.azimuth_step = sensor.azimuth_step;
  lidar.elevation_step = sensor.elevation_step;
  for (std::size_t axis = 0; axis < 3; ++axis)
    lidar.position[axis] =
        (sensor.origin[axis] + frame.grid.first_index[axis]) * frame.grid.resolution;
  return lidar;
}

TEST(RayOutlierRemoval, AutomaticTakesTheRaysOfTheSensor)
{
  for (const double edge : {0.005, 0.1}) {
    std::mt19937_64 random(37);
    VoxelOutlierRemoval removal;
    EXPECT_EQ(removal.unit(), DensityUnit::Automatic);
    io::VoxelFrame frame = randomFrame(random, edge, Counts::Points);
    std::vector<float> log_odds;
    EXPECT_TRUE(removal.score(frame, log_odds).ok());
    EXPECT_EQ(removal.unit(), DensityUnit::Voxels);
    const io::VoxelFrame first = lidarFrame(random, edge);
    const Lidar lidar = lidarOf(first);
    expectScores(removal, first, lidar, Counts::Points);
    // A frame without has the rays of the last one, wherever its grid begins.
    expectScores(removal, frame, lidar, Counts::Points);
    io::VoxelFrame moved = frame;
    moved.grid.first_index[1] -= 7;
    expectScores(removal, moved, lidar, Counts::Points);
    removal.reset();
    EXPECT_TRUE(removal.score(frame, log_odds).ok());
    EXPECT_EQ(removal.unit(), DensityUnit::Voxels);
    // Those of a frame go before those of the settings.
    VoxelOutlierRemoval set(settingsOf(Lidar{{3.0, 4.0, 5.0}}, Counts::None));
    expectScores(set, frame, Lidar{{3.0, 4.0, 5.0}}, Counts::Points);
    expectScores(set, first, lidar, Counts::Points);
  }
}

TEST(RayOutlierRemoval, OtherFramesChooseOtherUnits)
{
  std::mt19937_64 random(39);
  const io::VoxelFrame frame = lidarFrame(random, 0.1);
  const auto unitOf = [&frame](const auto& change) {
    io::VoxelFrame changed = frame;
    change(changed);
    VoxelOutlierRemoval removal;
    std::vector<float> log_odds;
    EXPECT_TRUE(removal.score(changed, log_odds).ok());
    return removal.unit();
  };
  using Frame = io::VoxelFrame;
  EXPECT_EQ(unitOf([](Frame&) {}), DensityUnit::Rays);
  // A camera; one column; one ring.
  EXPECT_EQ(unitOf([](Frame& other) { other.points.sensor.reset(); }),
            DensityUnit::Voxels);
  EXPECT_EQ(unitOf([](Frame& other) { other.points.sensor->azimuth_step = 0.0; }),
            DensityUnit::Voxels);
  EXPECT_EQ(unitOf([](Frame& other) { other.points.sensor->elevation_step = 0.0; }),
            DensityUnit::Voxels);
  EXPECT_EQ(
      unitOf([](Frame& other) {
        other.intensity_scale.offset = 0.0f;
        other.depth_model = io::depthModelOf(
            {2, 14.57, 255.0}, {}, {1.0, 0.0, 0.0}, other.grid, other.intensity_scale);
        EXPECT_TRUE(other.depth_model);
      }),
      DensityUnit::Faces);
}

TEST(RayOutlierRemoval, FramesOfPointsGetTheirVoxels)
{
  std::mt19937_64 random(42);
  io::VoxelFrame with_voxels = lidarFrame(random, 0.1);
  io::VoxelFrame frame = with_voxels;
  frame.keys.clear();
  frame.intensities.clear();
  frame.point_counts.clear();
  std::shuffle(frame.points.positions.begin(), frame.points.positions.end(), random);
  VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = 4.0f;
  VoxelOutlierRemoval removal(settings);
  VoxelOutlierRemoval other_removal(settings);
  const std::size_t removed = removal.filter(with_voxels).removed;
  EXPECT_GT(removed, 0u);
  EXPECT_EQ(other_removal.filter(frame).removed, removed);
  EXPECT_EQ(frame.keys, with_voxels.keys);
  EXPECT_EQ(frame.point_counts, with_voxels.point_counts);
  EXPECT_TRUE(io::isConsistent(frame));
}

} // namespace

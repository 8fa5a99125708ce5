// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/outlier_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;

/** \brief The header's formulas, voxel by voxel. */
class BruteForce {
public:
  using Density = std::function<int(const LatticeIndex&, std::uint16_t)>;

  BruteForce(DensityUnit unit, Density density)
  : unit_(unit), density_(std::move(density))
  {}

  void
  setDensity(Density density)
  {
    density_ = std::move(density);
  }

  Scores
  score(const Voxels& voxels)
  {
    field_.clear();
    for (auto& [index, mean] : means_) {
      mean -= mean / 4;
      mean = mean < 16 ? 0 : mean;
      field_[index] = mean / 32;
    }
    std::map<LatticeIndex, int> steps; // of the history
    for (const auto& [index, symbol] : voxels) {
      const int density = density_(index, symbol);
      steps[index] = means_[index] / 64;
      means_[index] += 16 * density;
      field_[index] = 4 * density;
    }
    Scores scores;
    for (const auto& [index, symbol] : voxels)
      scores[index] = static_cast<float>(
          scoreAt(index) +
          (unit_ == DensityUnit::Voxels ? 1.25 * std::log(rankOf(index, steps)) : 0.0));
    return scores;
  }

private:
  static double
  rankOf(const LatticeIndex& index, const std::map<LatticeIndex, int>& steps)
  {
    double not_above = 0.0;
    for (const auto& [other, step] : steps)
      not_above += step <= steps.at(index) ? 1.0 : 0.0;
    return not_above / static_cast<double>(steps.size());
  }

  double
  scoreAt(const LatticeIndex& index) const
  {
    std::array<double, 3> shells{};
    double all = 0.0;
    double occupied = 0.0;
    for (std::int64_t x = -2; x <= 2; ++x)
      for (std::int64_t y = -2; y <= 2; ++y)
        for (std::int64_t z = -2; z <= 2; ++z) {
          const auto found = field_.find({index[0] + x, index[1] + y, index[2] + z});
          if (found == field_.end())
            continue;
          const std::int64_t steps = std::abs(x) + std::abs(y) + std::abs(z);
          const bool is_rim = std::max({std::abs(x), std::abs(y), std::abs(z)}) == 2;
          shells[steps < 2 ? 0
                 : is_rim  ? 2
                           : 1] += (steps == 0 ? 2.0 : 1.0) * found->second;
          all += found->second;
          occupied += found->second > 0 ? 1.0 : 0.0;
        }
    const double one = unit_ == DensityUnit::Points ? all / occupied : 4.0 * 255.0;
    const double least = unit_ == DensityUnit::Voxels ? 0.3 : 0.02;
    const auto logarithm = [&](double sum) { return std::log(sum / one + least); };
    return 3.0 * logarithm(shells[0]) +
           (logarithm(shells[1]) + logarithm(shells[2])) / 2.0 +
           (unit_ == DensityUnit::Faces    ? 2.4
            : unit_ == DensityUnit::Points ? -2.5
                                           : 2.9); // at 4 cm
  }

  DensityUnit unit_;
  Density density_;
  std::map<LatticeIndex, int> means_; // in 2^-6
  std::map<LatticeIndex, int> field_; // in 2^-2
};

TEST(VoxelOutlierRemoval, LogOddsAreThoseOfTheFormula)
{
  for (const DensityUnit unit :
       {DensityUnit::Faces, DensityUnit::Points, DensityUnit::Voxels}) {
    std::mt19937_64 random(3);
    VoxelOutlierRemoval removal(settingsOf(unit));
    BruteForce brute_force(unit, [unit](const LatticeIndex&, std::uint16_t symbol) {
      return unit == DensityUnit::Voxels ? 255 : symbol;
    });
    for (std::int32_t frame = 0; frame < 16; ++frame) {
      Voxels voxels = wall(random, 15 + frame);
      // From many points to one or two, whose means are soon forgotten.
      for (auto& [index, symbol] : voxels)
        symbol = static_cast<std::uint16_t>((symbol >> (frame % 3) * 3) + 1);
      for (auto& [index, symbol] : voxels)
        symbol = std::min(symbol, std::uint16_t{255});
      // The grid may move on its lattice.
      const io::VoxelGrid grid = gridAt(
          -frame * 5, 3 - frame, -frame * frame, 8 + static_cast<unsigned>(frame) / 2);
      expectSame(
          scoresOf(removal, frameOf(voxels, grid)), brute_force.score(voxels), 1e-4f);
    }
  }
}

TEST(VoxelOutlierRemoval, LogOddsDependOnTheVoxelEdge)
{
  std::mt19937_64 random(4);
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  const auto scores = [&](DensityUnit unit, double edge) {
    frame.grid.resolution = edge;
    VoxelOutlierRemoval removal(settingsOf(unit));
    std::vector<float> log_odds;
    removal.score(frame, log_odds);
    return log_odds;
  };
  // Of Points they stay where they are above 4 cm.
  for (const auto& [edge, faces, points, voxels] :
       {std::tuple(0.02, -2.0794415, 2.0794415, 0.5198604),
        std::tuple(0.03, -0.8630462, 0.8630462, 0.2157616),
        std::tuple(0.08, 2.0794415, 0.0, -0.5198604),
        std::tuple(0.2, 4.8283137, 0.0, -1.2070784)})
    for (const auto& [unit, change] : {std::pair(DensityUnit::Faces, faces),
                                       std::pair(DensityUnit::Points, points),
                                       std::pair(DensityUnit::Voxels, voxels)}) {
      const std::vector<float> at_4_cm = scores(unit, 0.04);
      const std::vector<float> moved = scores(unit, edge);
      for (std::size_t i = 0; i < moved.size(); ++i)
        ASSERT_NEAR(moved[i] - at_4_cm[i], change, 1e-4) << edge;
    }
}

struct Sensor {
  std::array<double, 3> origin;
  std::array<double, 3> axis;
  io::DepthLaw law;
};

/** \brief Density as it is documented, from a voxel's place in the world. */
BruteForce::Density
densityBefore(const Sensor& sensor)
{
  return [sensor](const LatticeIndex& index, std::uint16_t symbol) {
    double depth = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      depth += sensor.axis[axis] *
               ((static_cast<double>(index[axis]) + 0.5) * 0.04 - sensor.origin[axis]);
    const double share = depth / sensor.law.cut_off_depth;
    double faces = symbol / sensor.law.full_intensity;
    if (sensor.law.exponent == 1)
      faces *= share;
    const double points_that_fit = 1.0 / (share * share);
    faces *= std::max(1.0, points_that_fit / (5625.0 * 0.04 * 0.04));
    return static_cast<int>(std::clamp(std::round(255.0 * faces), 1.0, 255.0));
  };
}

TEST(VoxelOutlierRemoval, DensitiesFollowTheDepthModel)
{
  for (const unsigned int exponent : {1u, 2u}) {
    const Sensor first{{-2.5, 1.0, 1.0}, {0.8, 0.6, 0.0}, {exponent, 14.6, 255.0}};
    // Elsewhere, and with other intensities.
    const Sensor second{{4.0, 1.0, 3.5}, {-0.6, 0.0, -0.8}, {exponent, 14.6, 120.0}};
    VoxelOutlierRemoval removal;
    BruteForce brute_force(DensityUnit::Faces, densityBefore(first));
    std::mt19937_64 random(14);
    for (int i = 0; i < 9; ++i) {
      Voxels voxels = wall(random, 15);
      for (auto& [index, symbol] : voxels)
        symbol = static_cast<std::uint16_t>(6 + symbol % (exponent == 1 ? 110 : 50));
      const io::VoxelGrid grid = gridAt(-i, 2 * i - 30, i - 9, 8);
      io::VoxelFrame frame = frameOf(voxels, grid);
      const Sensor& sensor = i < 5 ? first : second;
      brute_force.setDensity(densityBefore(sensor));
      // Of the others it is left out.
      if (i % 5 == 0 || i == 2)
        frame.depth_model = io::depthModelOf(
            sensor.law, sensor.origin, sensor.axis, grid, frame.intensity_scale);
      ASSERT_EQ(frame.depth_model.has_value(), i == 0 || i == 2 || i == 5);
      // Depths are rounded down to 2^-10 of the cut-off depth; the nearest are an
      // eighth.
      expectSame(scoresOf(removal, frame), brute_force.score(voxels), 0.2f);
    }
  }
}

TEST(VoxelOutlierRemoval, OneVoxelIsNoiseAtAnyPlace)
{
  const double expected =
      3.0 * std::log(2.0 * 100.0 / 255.0 + 0.02) + std::log(0.02) + 2.4;
  // Up to the corners of the largest grid, and of the lattice.
  for (const unsigned int depth : {1u, 2u, 12u, 21u})
    for (const std::int32_t first : {std::numeric_limits<std::int32_t>::min(),
                                     -(1 << 20),
                                     -1,
                                     3,
                                     std::numeric_limits<std::int32_t>::max()})
      for (const std::uint64_t key :
           {std::uint64_t{0}, (std::uint64_t{1} << 3 * depth) - 1}) {
        io::VoxelFrame frame;
        frame.grid = gridAt(first, first, first, depth);
        frame.keys = {key};
        frame.intensities = {100};
        VoxelOutlierRemoval removal(settingsOf(DensityUnit::Faces));
        std::vector<float> log_odds;
        removal.score(frame, log_odds);
        ASSERT_EQ(log_odds.size(), 1u);
        EXPECT_NEAR(log_odds[0], expected, 0.01);
        EXPECT_EQ(removal.filter(frame).removed, 1u);
        EXPECT_TRUE(frame.keys.empty());
      }
}

constexpr double cell_edge = 0.02;

/** \brief The same points in voxels of half the edge, in as many of them as there can
 * be. */
Voxels
halved(const Voxels& voxels, std::mt19937_64& random)
{
  Voxels fine;
  for (const auto& [index, points] : voxels) {
    auto part = static_cast<std::int64_t>(random() % 8);
    for (int i = 0; i < points; ++i) {
      ++fine[{2 * index[0] + (part & 1),
              2 * index[1] + (part >> 1 & 1),
              2 * index[2] + (part >> 2)}];
      part = (part + 3) % 8;
    }
  }
  return fine;
}

io::VoxelFrame
frameAt(double edge, const Voxels& voxels, const io::VoxelGrid& grid)
{
  io::VoxelFrame frame = frameOf(voxels, grid);
  frame.grid.resolution = edge;
  return frame;
}

void
expectThoseOfCells(const Scores& scores, const Scores& cells)
{
  ASSERT_GE(scores.size(), cells.size());
  for (const auto& [index, score] : scores) {
    LatticeIndex cell = index;
    for (std::int64_t& coordinate : cell)
      coordinate = coordinate >= 0 ? coordinate / 2 : (coordinate - 1) / 2;
    ASSERT_EQ(score, cells.at(cell));
  }
}

TEST(VoxelOutlierRemovalUnits, FineVoxelsHaveTheScoresOfTheirCells)
{
  for (const DensityUnit unit : {DensityUnit::Points, DensityUnit::Voxels}) {
    VoxelOutlierRemoval coarse(settingsOf(unit));
    VoxelOutlierRemoval fine(settingsOf(unit));
    std::mt19937_64 random(21);
    for (std::int32_t i = 0; i < 5; ++i) {
      Voxels voxels = wall(random, 15);
      for (auto& [index, points] : voxels)
        points = static_cast<std::uint16_t>(1 + points / 20);
      // Grids that begin within a cell, too, and below zero.
      const io::VoxelGrid grid = gridAt(7 - 3 * i, -5 * i, i - 1, 8);
      expectThoseOfCells(
          scoresOf(fine, frameAt(cell_edge / 2.0, halved(voxels, random), grid)),
          scoresOf(coarse, frameAt(cell_edge, voxels, gridAt(0, 0, 0))));
    }
  }
}

TEST(VoxelOutlierRemovalUnits, FineFacesHaveTheScoresOfTheirCells)
{
  // A camera at the origin that looks along x; a point fills a voxel of 1 cm from
  // 3.64 m on, and one of 2 cm from 7.29 m on.
  const auto frameOfPoints = [](double edge,
                                const Voxels& points,
                                double cut_off_depth) {
    Voxels shares;
    for (const auto& [index, number] : points) {
      const double depth = (static_cast<double>(index[0]) + 0.5) * edge / cut_off_depth;
      shares[index] = static_cast<std::uint16_t>(std::min(
          65535.0, std::round(65535.0 * number * std::min(1.0, depth * depth))));
    }
    io::VoxelGrid grid = gridAt(0, 0, 0, 10);
    grid.resolution = edge;
    io::VoxelFrame frame = frameOf(shares, grid, {0.0f, 255.0f / 65535.0f, 16});
    frame.depth_model = io::depthModelOf({2, cut_off_depth, 255.0},
                                         {},
                                         {1.0, 0.0, 0.0},
                                         frame.grid,
                                         frame.intensity_scale);
    EXPECT_TRUE(frame.depth_model);
    return frame;
  };
  std::mt19937_64 random(22);
  for (const std::int32_t place : {60, 150, 300}) { // 1.2, 3 and 6 m
    Voxels points = wall(random, place);
    for (auto& [index, number] : points)
      number = static_cast<std::uint16_t>(1 + number / 100);
    const Voxels fine_points = halved(points, random);
    VoxelOutlierRemoval coarse;
    VoxelOutlierRemoval fine;
    const Scores cells = scoresOf(coarse, frameOfPoints(cell_edge, points, 7.286));
    const Scores scores =
        scoresOf(fine, frameOfPoints(cell_edge / 2.0, fine_points, 3.643));
    for (const auto& [index, score] : scores)
      // But for the depth, which is that of voxels in one and of cells in the other.
      ASSERT_NEAR(score, cells.at({index[0] / 2, index[1] / 2, index[2] / 2}), 0.25f);
  }
}

TEST(VoxelOutlierRemovalUnits, NumbersOfPointsAreUsedWithoutIntensities)
{
  std::mt19937_64 random(23);
  VoxelOutlierRemoval on_counts(settingsOf(DensityUnit::Points));
  VoxelOutlierRemoval on_numbers(settingsOf(DensityUnit::Points));
  for (int i = 0; i < 4; ++i) {
    const io::VoxelFrame counts = frameOf(wall(random, 15), gridAt(0, 0, 0));
    io::VoxelFrame frame = counts;
    frame.intensity_scale.bits = 0;
    frame.intensities.clear();
    frame.has_point_counts = true;
    frame.point_counts.assign(counts.intensities.begin(), counts.intensities.end());
    ASSERT_TRUE(io::isConsistent(frame));
    expectSame(scoresOf(on_numbers, frame), scoresOf(on_counts, counts), 0.0f);
  }
}

TEST(VoxelOutlierRemovalUnits, IntensitiesOfUnknownMeaningAreNotUsed)
{
  std::mt19937_64 random(24);
  VoxelOutlierRemoval automatic;
  VoxelOutlierRemoval other;
  VoxelOutlierRemoval without;
  for (int i = 0; i < 4; ++i) {
    const io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
    io::VoxelFrame bright = frame;
    for (std::uint16_t& symbol : bright.intensities)
      symbol = static_cast<std::uint16_t>(random() % 256);
    io::VoxelFrame none = frame;
    none.intensity_scale.bits = 0;
    none.intensities.clear();
    const Scores scores = scoresOf(automatic, frame);
    expectSame(scoresOf(other, bright), scores, 0.0f);
    expectSame(scoresOf(without, none), scores, 0.0f);
  }
}

/** \brief Rings of a lidar on a wall, whose voxels do not touch those of the next ring,
 * and an echo between them that is elsewhere each time. */
Voxels
ringsAndEcho(std::int64_t frame, const LatticeIndex& echo)
{
  Voxels voxels;
  for (std::int64_t z = 10; z < 100; z += 9)
    for (std::int64_t y = 20; y < 80; ++y)
      if ((y + frame + z) % 4 != 0) // a part of the rays has no return
        voxels[{30, y, z}] = 10;
  voxels[echo] = 10;
  return voxels;
}

TEST(VoxelOutlierRemovalUnits, AMovingLidarLosesNothing)
{
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Voxels));
  for (std::int64_t frame = 0; frame < 6; ++frame) {
    Voxels moved;
    for (const auto& [index, symbol] : ringsAndEcho(frame, {20, 30, 23}))
      moved[{index[0] + 7 * frame, index[1], index[2]}] = symbol;
    for (const auto& [index, score] :
         scoresOf(removal, frameOf(moved, gridAt(0, 0, 0))))
      if (index[0] == 30 + 7 * frame) {
        EXPECT_GE(score, 0.0f);
      }
  }
}

} // namespace

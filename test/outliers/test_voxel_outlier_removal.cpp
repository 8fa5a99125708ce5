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

TEST(VoxelOutlierRemoval, SparseSurfacesNearTheSensorAreNotNoise)
{
  // 1.2 m away 147 points cover a face of 4 cm; a limb has 9 at a grazing angle.
  Voxels voxels;
  for (std::int64_t y = 20; y < 22; ++y)
    for (std::int64_t z = 20; z < 40; ++z)
      voxels[{30, y, z}] = 16;
  const LatticeIndex flying = {30, 50, 50}; // one point
  voxels[flying] = 2;
  io::VoxelFrame frame = frameOf(voxels, gridAt(0, 0, 0));
  const Scores without_model = [&] {
    VoxelOutlierRemoval removal(settingsOf(DensityUnit::Faces));
    return scoresOf(removal, frame);
  }();
  frame.depth_model =
      io::depthModelOf({2, 14.57, 255.0}, {}, {1.0, 0.0, 0.0}, frame.grid, {});
  ASSERT_TRUE(frame.depth_model);
  VoxelOutlierRemoval removal;
  for (const auto& [index, score] : scoresOf(removal, frame)) {
    EXPECT_EQ(score < 0.0f, index == flying) << score;
    EXPECT_LT(without_model.at(index), 0.0f);
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

TEST(VoxelOutlierRemoval, NewSurfacesAreNotNoise)
{
  // A plate of full faces that moves by its thickness in each frame: nothing of it was
  // where it is before. Its rim has a third of its neighbours, and is no noise either.
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Faces));
  for (std::int32_t frame = 0; frame < 6; ++frame) {
    Voxels voxels;
    for (std::int64_t y = 20; y < 30; ++y)
      for (std::int64_t z = 20; z < 30; ++z)
        voxels[{10 + 5 * frame, y, z}] = 200;
    // A flying pixel, of a ray that covers a tenth of a face.
    const LatticeIndex flying = {10 + 5 * frame, 40, 40};
    voxels[flying] = 25;
    for (const auto& [index, score] :
         scoresOf(removal, frameOf(voxels, gridAt(0, 0, 0))))
      EXPECT_EQ(score < 0.0f, index == flying) << score;
  }
}

} // namespace

#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;

/** \brief Of a voxel; of any grid, whose voxels may lie beyond 32 bits. */
using LatticeIndex = std::array<std::int64_t, 3>;

/** \brief Voxels by their index on the lattice, with symbols. */
using Voxels = std::map<LatticeIndex, std::uint16_t>;

io::VoxelGrid
gridAt(std::int32_t x, std::int32_t y, std::int32_t z, unsigned int depth = 7)
{
  io::VoxelGrid grid;
  grid.resolution = 0.04;
  grid.first_index = {x, y, z};
  grid.depth = depth;
  return grid;
}

io::VoxelFrame
frameOf(const Voxels& voxels, const io::VoxelGrid& grid)
{
  std::map<std::uint64_t, std::uint16_t> by_key;
  for (const auto& [index, symbol] : voxels)
    by_key[io::mortonKey(
        {static_cast<std::uint32_t>(index[0] - grid.first_index[0]),
         static_cast<std::uint32_t>(index[1] - grid.first_index[1]),
         static_cast<std::uint32_t>(index[2] - grid.first_index[2])})] = symbol;
  io::VoxelFrame frame;
  frame.grid = grid;
  for (const auto& [key, symbol] : by_key) {
    frame.keys.push_back(key);
    frame.intensities.push_back(symbol);
  }
  EXPECT_TRUE(io::isConsistent(frame));
  return frame;
}

/** \brief Log-odds by the voxels' index on the lattice. */
using Scores = std::map<LatticeIndex, float>;

Scores
scoresOf(VoxelOutlierRemoval& removal, const io::VoxelFrame& frame)
{
  std::vector<float> log_odds;
  removal.score(frame, log_odds);
  EXPECT_EQ(log_odds.size(), frame.size());
  Scores scores;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelPosition at = io::voxelPosition(frame.keys[i]);
    scores[{std::int64_t{at.x} + frame.grid.first_index[0],
            std::int64_t{at.y} + frame.grid.first_index[1],
            std::int64_t{at.z} + frame.grid.first_index[2]}] = log_odds[i];
  }
  return scores;
}

VoxelOutlierRemovalSettings
settingsOf(DensityUnit unit)
{
  VoxelOutlierRemovalSettings settings;
  settings.unit = unit;
  return settings;
}

/** \brief A wall at x with some holes, and noise before it. */
Voxels
wall(std::mt19937_64& random, std::int32_t x)
{
  Voxels voxels;
  for (std::int64_t y = 20; y < 45; ++y)
    for (std::int64_t z = 20; z < 45; ++z)
      if (random() % 8 != 0)
        voxels[{x + static_cast<std::int32_t>(random() % 2), y, z}] =
            static_cast<std::uint16_t>(30 + random() % 226);
  for (int i = 0; i < 40; ++i)
    voxels[{static_cast<std::int32_t>(10 + random() % 50),
            static_cast<std::int32_t>(10 + random() % 50),
            static_cast<std::int32_t>(10 + random() % 50)}] =
        static_cast<std::uint16_t>(30 + random() % 60);
  return voxels;
}

/** \brief The header's formulas, in real numbers and voxel by voxel. */
class BruteForce {
public:
  explicit BruteForce(DensityUnit unit) : are_faces_(unit == DensityUnit::Faces) {}

  Scores
  score(const Voxels& voxels)
  {
    for (auto& [index, mean] : means_)
      mean *= 0.75;
    for (const auto& [index, symbol] : voxels)
      means_[index] += symbol / 4.0;
    field_.clear();
    for (const auto& [index, mean] : means_)
      field_[index] = mean / 2.0;
    for (const auto& [index, symbol] : voxels)
      field_[index] += symbol;
    Scores scores;
    for (const auto& [index, symbol] : voxels)
      scores[index] = static_cast<float>(scoreAt(index));
    return scores;
  }

private:
  double
  scoreAt(const LatticeIndex& index) const
  {
    std::array<double, 3> shells{};
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
          // Below a quarter of a density, a mean is forgotten.
          occupied += found->second > 0.125 ? 1.0 : 0.0;
        }
    const double own = field_.at(index);
    const double unit =
        are_faces_ ? 255.0 : (shells[0] - own + shells[1] + shells[2]) / occupied;
    const auto logarithm = [&](double sum) { return std::log(sum / unit + 0.02); };
    return 3.0 * logarithm(shells[0]) +
           (logarithm(shells[1]) + logarithm(shells[2])) / 2.0 +
           (are_faces_ ? 1.7 : -2.5); // at 4 cm
  }

  bool are_faces_;
  std::map<LatticeIndex, double> means_;
  std::map<LatticeIndex, double> field_;
};

void
expectSame(const Scores& scores, const Scores& expected, float tolerance)
{
  ASSERT_EQ(scores.size(), expected.size());
  for (const auto& [index, score] : expected)
    ASSERT_NEAR(scores.at(index), score, tolerance)
        << index[0] << ' ' << index[1] << ' ' << index[2];
}

TEST(VoxelOutlierRemoval, ScoresAreThoseOfTheFormula)
{
  // Fixed point: a rounding of 1/4 of a density where means are small.
  constexpr float tolerance = 0.06f;
  for (const DensityUnit unit : {DensityUnit::Faces, DensityUnit::Points}) {
    std::mt19937_64 random(3);
    VoxelOutlierRemoval removal(settingsOf(unit));
    BruteForce brute_force(unit);
    for (std::int32_t frame = 0; frame < 8; ++frame) {
      const Voxels voxels = wall(random, 15 + 2 * frame);
      expectSame(scoresOf(removal, frameOf(voxels, gridAt(0, 0, 0))),
                 brute_force.score(voxels),
                 unit == DensityUnit::Faces ? tolerance : 4 * tolerance);
    }
  }
}

TEST(VoxelOutlierRemoval, GridMayMoveOnItsLattice)
{
  std::mt19937_64 random(4);
  VoxelOutlierRemoval moving(settingsOf(DensityUnit::Faces));
  VoxelOutlierRemoval resting(settingsOf(DensityUnit::Faces));
  for (std::int32_t frame = 0; frame < 10; ++frame) {
    const Voxels voxels = wall(random, 15);
    const io::VoxelGrid grid =
        gridAt(-frame * 5, 3 - frame, -frame * frame, 7 + static_cast<unsigned>(frame));
    expectSame(scoresOf(moving, frameOf(voxels, grid)),
               scoresOf(resting, frameOf(voxels, gridAt(0, 0, 0))),
               0.0f);
  }
}

TEST(VoxelOutlierRemoval, OtherLatticesAndUnitsBeginAnew)
{
  std::mt19937_64 random(5);
  const Voxels voxels = wall(random, 15);
  const io::VoxelFrame frame = frameOf(voxels, gridAt(0, 0, 0));
  io::VoxelFrame finer = frame;
  finer.grid.resolution = 0.02;
  io::VoxelFrame elsewhere = frame;
  elsewhere.grid.anchor[1] = 0.01;
  io::VoxelFrame with_model = frame;
  with_model.depth_model =
      io::depthModelOf({2, 15.0, 255.0}, {}, {1, 0, 0}, frame.grid, {});
  ASSERT_TRUE(with_model.depth_model);
  for (const io::VoxelFrame& other : {finer, elsewhere, with_model}) {
    VoxelOutlierRemoval used;
    VoxelOutlierRemoval fresh;
    scoresOf(used, frame);
    expectSame(scoresOf(used, other), scoresOf(fresh, other), 0.0f);
  }
}

TEST(VoxelOutlierRemoval, ResetAndNoHistoryForget)
{
  std::mt19937_64 random(6);
  const io::VoxelFrame first = frameOf(wall(random, 15), gridAt(0, 0, 0));
  const io::VoxelFrame second = frameOf(wall(random, 15), gridAt(0, 0, 0));
  VoxelOutlierRemoval fresh(settingsOf(DensityUnit::Faces));
  const Scores expected = scoresOf(fresh, second);

  VoxelOutlierRemoval reset(settingsOf(DensityUnit::Faces));
  scoresOf(reset, first);
  reset.reset();
  EXPECT_EQ(reset.rememberedBlocks(), 0u);
  expectSame(scoresOf(reset, second), expected, 0.0f);

  VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Faces);
  settings.use_history = false;
  VoxelOutlierRemoval alone(settings);
  scoresOf(alone, first);
  EXPECT_EQ(alone.rememberedBlocks(), 0u);
  expectSame(scoresOf(alone, second), expected, 0.0f);

  VoxelOutlierRemoval remembering(settingsOf(DensityUnit::Faces));
  scoresOf(remembering, first);
  EXPECT_NE(scoresOf(remembering, second), expected);
}

TEST(VoxelOutlierRemoval, RemembersNoMoreThanItMay)
{
  std::mt19937_64 random(7);
  VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Faces);
  settings.max_blocks = 300;
  VoxelOutlierRemoval removal(settings);
  std::vector<float> log_odds;
  const auto scattered = [&](std::size_t voxels) {
    io::VoxelFrame frame;
    frame.grid = gridAt(0, 0, 0, 12);
    for (std::size_t i = 0; i < voxels; ++i)
      frame.keys.push_back(random() % (std::uint64_t{1} << 36));
    std::sort(frame.keys.begin(), frame.keys.end());
    frame.intensities.assign(voxels, 255);
    return frame;
  };
  for (int frame = 0; frame < 50; ++frame) {
    removal.score(scattered(100), log_odds);
    EXPECT_LE(removal.rememberedBlocks(), 300u);
    EXPECT_GE(removal.rememberedBlocks(), 100u);
  }
  // A frame that is larger alone is judged, and not remembered.
  removal.score(scattered(1000), log_odds);
  EXPECT_EQ(log_odds.size(), 1000u);
  EXPECT_EQ(removal.rememberedBlocks(), 0u);
}

TEST(VoxelOutlierRemoval, ForgetsWithinASecond)
{
  std::mt19937_64 random(8);
  VoxelOutlierRemoval removal;
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  EXPECT_GT(removal.filter(frame), 0u);
  EXPECT_GT(removal.rememberedBlocks(), 0u);
  for (int i = 0; i < 20; ++i) {
    frame.keys.clear();
    frame.intensities.clear();
    EXPECT_EQ(removal.filter(frame), 0u);
  }
  EXPECT_EQ(removal.rememberedBlocks(), 0u);
}

TEST(VoxelOutlierRemoval, OneVoxelIsNoiseAtAnyPlace)
{
  const double expected =
      3.0 * std::log(2.0 * 1.125 * 100.0 / 255.0 + 0.02) + std::log(0.02) + 1.7;
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
        EXPECT_EQ(removal.filter(frame), 1u);
        EXPECT_TRUE(frame.keys.empty());
      }
}

TEST(VoxelOutlierRemoval, GridsFarApartDoNotMeet)
{
  VoxelOutlierRemoval removal(settingsOf(DensityUnit::Faces));
  VoxelOutlierRemoval fresh(settingsOf(DensityUnit::Faces));
  io::VoxelFrame frame;
  frame.keys = {5};
  frame.intensities = {200};
  frame.grid = gridAt(std::numeric_limits<std::int32_t>::min(), 0, 0, 21);
  scoresOf(removal, frame);
  frame.grid = gridAt(std::numeric_limits<std::int32_t>::max(), 0, 0, 21);
  expectSame(scoresOf(removal, frame), scoresOf(fresh, frame), 0.0f);
}

TEST(VoxelOutlierRemoval, FilterRemovesWhatScoresLower)
{
  std::mt19937_64 random(9);
  std::vector<io::VoxelFrame> frames;
  for (int i = 0; i < 4; ++i)
    frames.push_back(frameOf(wall(random, 15), gridAt(0, 0, 0)));
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float least : {-infinity, -3.0f, 0.0f, 4.0f, infinity, std::nanf("")}) {
    VoxelOutlierRemovalSettings settings = settingsOf(DensityUnit::Points);
    settings.min_log_odds = least;
    VoxelOutlierRemoval filtering(settings);
    VoxelOutlierRemoval scoring(settings);
    for (const io::VoxelFrame& frame : frames) {
      std::vector<float> log_odds;
      scoring.score(frame, log_odds);
      io::VoxelFrame filtered = frame;
      const std::size_t removed = filtering.filter(filtered);
      EXPECT_EQ(removed + filtered.size(), frame.size());
      EXPECT_EQ(filtered.keys.size(), filtered.intensities.size());
      std::size_t next = 0;
      for (std::size_t i = 0; i < frame.size(); ++i)
        if (!(log_odds[i] < least)) {
          ASSERT_LT(next, filtered.size());
          EXPECT_EQ(filtered.keys[next], frame.keys[i]);
          EXPECT_EQ(filtered.intensities[next++], frame.intensities[i]);
        }
      EXPECT_EQ(next, filtered.size());
    }
  }
}

TEST(VoxelOutlierRemoval, TwoOfThemAgreeToTheBit)
{
  // Hash tables differ from one to the next.
  std::mt19937_64 random(10);
  VoxelOutlierRemoval one;
  VoxelOutlierRemoval other;
  for (int i = 0; i < 6; ++i) {
    const io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
    expectSame(scoresOf(one, frame), scoresOf(other, frame), 0.0f);
  }
  VoxelOutlierRemoval moved = std::move(one);
  const io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  expectSame(scoresOf(moved, frame), scoresOf(other, frame), 0.0f);
}

TEST(VoxelOutlierRemoval, CountsMayBeOfAnyDepth)
{
  // Three times the points in each voxel, as nearer to the sensor.
  std::mt19937_64 random(11);
  Voxels voxels = wall(random, 15);
  for (auto& [index, symbol] : voxels)
    symbol = static_cast<std::uint16_t>(20 + symbol / 4);
  VoxelOutlierRemoval far;
  const Scores expected = scoresOf(far, frameOf(voxels, gridAt(0, 0, 0)));
  for (auto& [index, symbol] : voxels)
    symbol = static_cast<std::uint16_t>(3 * symbol);
  VoxelOutlierRemoval near;
  expectSame(scoresOf(near, frameOf(voxels, gridAt(0, 0, 0))), expected, 0.02f);
}

TEST(VoxelOutlierRemoval, WhatHasJustComeIsNoNoise)
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

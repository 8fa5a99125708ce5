#include "noise/temporal_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::noise;

// A camera at the origin that looks along z, and voxels of 4 cm before it.
const io::VoxelGrid grid{0.04, {0.0, 0.0, 0.0}, {-64, -64, 0}, 7};

/** \brief A voxel on the camera's axis, or some voxels beside it. */
std::uint64_t
voxelAt(double depth, std::uint32_t beside = 0)
{
  return io::mortonKey({64 + beside, 64, static_cast<std::uint32_t>(depth / 0.04)});
}

/** \brief The view onto a wall; 0: onto nothing. */
TrueView
viewOfWall(float depth)
{
  cell::SurfaceImage surfaces(cell::RayGrid::size);
  surfaces.depth.assign(cell::RayGrid::size, depth);
  return {Eigen::Isometry3d::Identity(), surfaces};
}

io::VoxelFrame
frameOf(std::vector<std::uint64_t> keys, std::uint16_t intensity = 4)
{
  io::VoxelFrame frame;
  frame.grid = grid;
  std::sort(keys.begin(), keys.end());
  frame.intensities.assign(keys.size(), intensity);
  frame.keys = std::move(keys);
  return frame;
}

/** \brief Adds a frame that has surfaces alone. */
void
addSurfaces(const std::vector<std::uint64_t>& keys,
            SurfaceHistory& truth,
            float wall_depth = 3.0f)
{
  truth.add(frameOf(keys),
            std::vector<VoxelTruth>(keys.size(), VoxelTruth::Still),
            viewOfWall(wall_depth));
}

TEST(NearbyVoxels, NeighboursOfABlockAndOfTheGridsEndAreMarked)
{
  NearbyVoxels near;
  near.mark(grid, {io::mortonKey({8, 0, 127})}, 3);
  for (const auto& position : {io::VoxelPosition{7, 1, 126}, {9, 0, 127}, {8, 0, 127}})
    EXPECT_EQ(near.lastTime(io::mortonKey(position)), 3);
  for (const auto& position : {io::VoxelPosition{6, 0, 127}, {8, 2, 127}, {8, 0, 125}})
    EXPECT_EQ(near.lastTime(io::mortonKey(position)), NearbyVoxels::never);
  near.mark(grid, {io::mortonKey({9, 0, 127})}, 4);
  EXPECT_EQ(near.lastTime(io::mortonKey({7, 0, 127})), 3);
  EXPECT_EQ(near.lastTime(io::mortonKey({8, 0, 127})), 4);
}

TEST(TrueView, RaysMustEndTwoEdgesBehindAVoxel)
{
  // Cubes begin at multiples of 4 cm: that of 2.0 m ends at 2.04 m.
  EXPECT_FALSE(viewOfWall(2.10f).seesThrough(grid, voxelAt(2.001)));
  EXPECT_TRUE(viewOfWall(2.13f).seesThrough(grid, voxelAt(2.001)));
  EXPECT_TRUE(viewOfWall(0.0f).seesThrough(grid, voxelAt(2.001)));
  EXPECT_FALSE(viewOfWall(1.0f).seesThrough(grid, voxelAt(2.001)));
}

TEST(TrueView, OneRayThatEndsAtAVoxelIsEnough)
{
  cell::SurfaceImage surfaces(cell::RayGrid::size);
  surfaces.depth.assign(cell::RayGrid::size, 4.0f);
  // The first pixel right of the axis and below it.
  surfaces.depth[212 * cell::RayGrid::columns + 256] = 2.02f;
  const TrueView view(Eigen::Isometry3d::Identity(), surfaces);
  EXPECT_FALSE(view.seesThrough(grid, voxelAt(2.001)));
  EXPECT_TRUE(view.seesThrough(grid, voxelAt(2.001, 1)));
}

TEST(TrueView, WhatNoRayMeetsIsNotSeenThrough)
{
  EXPECT_FALSE(viewOfWall(0.0f).seesThrough(grid, voxelAt(0.401, 30)));
  // The camera turned by half a circle: the voxel is behind it.
  const Eigen::Isometry3d turned(
      Eigen::AngleAxisd(3.14159265, Eigen::Vector3d::UnitY()));
  cell::SurfaceImage nothing(cell::RayGrid::size);
  EXPECT_FALSE(TrueView(turned, nothing).seesThrough(grid, voxelAt(2.001)));
}

TEST(TrueView, ALidarHasItsOwnRays)
{
  // The lidar's x is the world's z, and up is -x. Ring 8 is 1 degree up: 3.5 cm at 2 m,
  // ring 9 is at 10.5 cm. The last column is 0.2 degrees to the left, 0.7 cm.
  cell::SurfaceImage surfaces(cell::LidarRays::size);
  const Eigen::Isometry3d ahead(
      Eigen::AngleAxisd(-3.14159265 / 2.0, Eigen::Vector3d::UnitY()));
  const std::uint64_t met =
      io::mortonKey({64 - 1, 64, static_cast<std::uint32_t>(2.001 / 0.04)});
  EXPECT_TRUE(TrueView(ahead, surfaces).seesThrough(grid, met));
  surfaces.depth[9 * cell::LidarRays::columns - 1] = 2.02f;
  EXPECT_FALSE(TrueView(ahead, surfaces).seesThrough(grid, met));
  EXPECT_FALSE(
      TrueView(ahead, surfaces).seesThrough(grid, io::mortonKey({64 - 2, 64, 50})));
}

TEST(SurfaceHistory, NewSurfacesHaveNeighboursAndNoSurfaceBefore)
{
  SurfaceHistory truth;
  const std::vector<std::uint64_t> old = {voxelAt(1.001)};
  for (int i = 0; i < 5; ++i)
    addSurfaces(old, truth);
  // Each of a square of four has three neighbours; two more have none, or were there.
  const std::uint64_t left = io::mortonKey({30, 30, 50});
  const std::uint64_t left_below = io::mortonKey({30, 31, 50});
  const std::uint64_t right = io::mortonKey({31, 30, 50});
  const std::uint64_t right_below = io::mortonKey({31, 31, 50});
  std::vector<std::uint64_t> square = {left, left_below, right, right_below};
  std::sort(square.begin(), square.end());
  std::vector<std::uint64_t> keys = square;
  keys.push_back(io::mortonKey({80, 80, 50}));
  keys.push_back(voxelAt(1.041));
  addSurfaces(keys, truth);
  EXPECT_EQ(truth.newSurfaces(), square);
  EXPECT_TRUE(truth.earlierNewSurfaces().empty());
  addSurfaces(square, truth);
  EXPECT_TRUE(truth.newSurfaces().empty());
  addSurfaces({io::mortonKey({32, 30, 50})}, truth);
  std::vector<std::uint64_t> still_there = {right, right_below};
  std::sort(still_there.begin(), still_there.end());
  EXPECT_EQ(truth.earlierNewSurfaces(), still_there);
}

TEST(SurfaceHistory, NoiseHasNoSurfaceForTenFrames)
{
  SurfaceHistory truth;
  addSurfaces({voxelAt(2.001)}, truth);
  for (int i = 0; i < 9; ++i) {
    EXPECT_FALSE(truth.isNoise(voxelAt(2.041)));
    addSurfaces({}, truth);
  }
  EXPECT_FALSE(truth.isNoise(voxelAt(2.041)));
  EXPECT_TRUE(truth.isNoise(voxelAt(2.081)));
  addSurfaces({}, truth);
  EXPECT_TRUE(truth.isNoise(voxelAt(2.041)));
}

TEST(SurfaceHistory, GhostsAreSeenThroughInFourFrames)
{
  SurfaceHistory truth;
  const std::uint64_t key = voxelAt(2.001);
  addSurfaces({key}, truth, 2.0f);
  for (int i = 0; i < 4; ++i) {
    EXPECT_FALSE(truth.isGhost(key));
    EXPECT_FALSE(truth.hasBeenLeft(key));
    addSurfaces({}, truth);
  }
  EXPECT_TRUE(truth.isGhost(key));
  EXPECT_TRUE(truth.hasBeenLeft(key));
  EXPECT_FALSE(truth.hasBeenLeft(voxelAt(2.081)));
}

TEST(ShownJudge, SharesOfWhatIsNearAShownVoxel)
{
  SurfaceHistory truth;
  ShownJudge judge(1);
  const io::VoxelFrame measured = frameOf({voxelAt(1.001), voxelAt(2.001)});
  for (int i = 0; i < 2; ++i) {
    addSurfaces(measured.keys, truth, 2.0f);
    judge.add(truth, measured, frameOf({voxelAt(1.041), voxelAt(1.501)}));
  }
  EXPECT_EQ(judge.surface_percent.count(), 1u);
  EXPECT_DOUBLE_EQ(judge.surface_percent.mean(), 50.0);
  EXPECT_DOUBLE_EQ(judge.noise.percent(), 50.0);
  EXPECT_EQ(judge.person_percent.count(), 0u);
}

TEST(IntensityErrors, AgainstTheMeanOfAllFrames)
{
  IntensityErrors errors;
  const std::uint64_t usual = voxelAt(1.001);
  const std::uint64_t rare = voxelAt(2.001);
  errors.add(frameOf({usual, rare}, 2), frameOf({usual, rare}, 200), false);
  // The mean is 4; the shown ones are off by 1, the measured ones by 2.
  errors.add(frameOf({usual}, 2), frameOf({usual}, 3), true);
  errors.add(frameOf({usual}, 6), frameOf({usual}, 5), true);
  errors.add(frameOf({usual}, 6), frameOf({rare}, 5), true);
  EXPECT_DOUBLE_EQ(errors.ratio(), 0.5);
  EXPECT_TRUE(std::isnan(IntensityErrors().ratio()));
}

} // namespace

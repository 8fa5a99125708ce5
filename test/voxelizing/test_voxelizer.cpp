// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/test_memory.h"
#include "support/voxelized_stream.h"
#include "voxelizing/voxelizer.h"
#include "voxels/grid_fit.h"

#include <pcl/octree/octree_pointcloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;
using pcl_ext::test::MemoryUse;

std::vector<Cloud>
clouds()
{
  std::vector<Cloud> clouds{randomCloud(1, 0.0, 0.5),
                            randomCloud(2, -4.0, 4.0),
                            randomCloud(3, -0.3, -0.1),
                            randomCloud(4, 5000.0, 5001.0),
                            randomCloud(5, -5003.0, -5000.0)};
  Cloud faces; // as near to a face as floats come, on either side
  for (int i = -60; i < 60; ++i) {
    const float at = 0.01f * static_cast<float>(i);
    for (const float x :
         {at, std::nextafter(at, infinity), std::nextafter(at, -infinity)})
      faces.push_back({x, -x, 0.02f * static_cast<float>(i)});
  }
  clouds.push_back(faces);
  return clouds;
}

TEST(Voxelizer, CountsAreThoseOfANaiveVoxelizer)
{
  for (const double resolution : {0.01, 0.02, 0.04, 0.1})
    for (const Cloud& intensities : clouds()) {
      const Cloud cloud = withoutIntensities(intensities);
      Stream stream(settingsOf(resolution));
      stream.add(cloud);
      EXPECT_TRUE(stream.values() == naiveCounts(cloud, resolution));
      EXPECT_EQ(stream.statistics.points_used, cloud.size());
      EXPECT_EQ(stream.frame.grid.origin, (std::array<double, 3>{0.0, 0.0, 0.0}));
      for (const Point& point : cloud) {
        // In spite of rounding no point is further than half an edge from a centre.
        const auto index = std::floor(double{point.x} / resolution);
        EXPECT_LE(std::abs((index + 0.5) * resolution - double{point.x}),
                  resolution * (0.5 + 1e-9));
      }
    }
}

TEST(Voxelizer, TheFinestAndCoarsestVoxelsHoldTheirPoint)
{
  const std::array<float, 3> point{0.5f, -0.25f, 0.75f};
  for (const double resolution : {1e-6, 1e6}) {
    Stream stream(settingsOf(resolution));
    const VoxelFrame& frame = stream.add({{point[0], point[1], point[2]}});
    ASSERT_EQ(frame.size(), 1u);
    const VoxelPosition position = voxelPosition(frame.keys[0]);
    const std::array<std::uint32_t, 3> places{position.x, position.y, position.z};
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(frame.grid.centre(axis, places[axis]),
                  double{point[axis]},
                  0.5 * resolution + 1e-9);
  }
}

TEST(Voxelizer, ReadsStridedAndSeparateViews)
{
  const float coordinates[] = {0.1f, 0.2f, 0.3f, 99.0f, 1.1f, 1.2f, 1.3f, 99.0f};
  const float intensities[] = {5.0f, 7.0f};
  PointView view;
  view.coordinates = coordinates;
  view.coordinate_stride = 4 * sizeof(float);
  view.count = 2;
  Voxelizer voxelizer(settingsOf(1.0), IntensityUnit::Native);
  VoxelFrame frame;
  voxelizer.voxelize(view, false, frame);
  EXPECT_EQ(frame.intensities, (std::vector<std::uint16_t>{1, 1})); // none: all are 1
  view.intensities = intensities;
  view.intensity_stride = sizeof(float);
  voxelizer.voxelize(view, false, frame);
  EXPECT_EQ(frame.intensities, (std::vector<std::uint16_t>{5, 7}));
}

TEST(Voxelizer, EmptyCloudsKeepTheGrid)
{
  Stream stream(settingsOf(0.04));
  stream.add({});
  EXPECT_EQ(stream.frame.size(), 0u);
  stream.add(randomCloud(6, -1.0, 1.0));
  const VoxelGrid grid = stream.frame.grid;
  stream.add({}, true);
  EXPECT_EQ(stream.frame.size(), 0u);
  EXPECT_TRUE(stream.frame.grid == grid);
  stream.add({{nan_value, 0.0f, 0.0f}}, true);
  EXPECT_TRUE(stream.frame.grid == grid);
}

TEST(Voxelizer, NonFiniteValuesAreCounted)
{
  for (const auto unit :
       {IntensityUnit::Native, IntensityUnit::Share, IntensityUnit::Points}) {
    Stream stream(settingsOf(1.0), unit);
    stream.add({{nan_value, 0.5f, 0.5f, nan_value},
                {0.5f, infinity, 0.5f},
                {0.5f, 0.5f, -infinity},
                {0.5f, 0.5f, 0.5f, nan_value},
                {1.5f, 0.5f, 0.5f, infinity},
                {2.5f, 0.5f, 0.5f, -infinity},
                {3.5f, 0.5f, 0.5f, 1.0f}});
    EXPECT_EQ(stream.statistics.points_not_finite, 3u);
    EXPECT_EQ(stream.statistics.intensities_not_finite, 3u);
    EXPECT_EQ(stream.statistics.points_used, 4u);
    const float one = unit == IntensityUnit::Share ? 255.0f : 1.0f;
    const std::map<LatticeIndex, float> expected{
        {{0, 0, 0}, 0.0f}, {{1, 0, 0}, 0.0f}, {{2, 0, 0}, 0.0f}, {{3, 0, 0}, one}};
    EXPECT_EQ(stream.values(), expected);
  }
}

TEST(Voxelizer, BothEndsOfTheBoxBelongToIt)
{
  for (const auto format : {StreamFormat::Version1, StreamFormat::Published})
    for (const double edge : {0.25, 0.3}) { // 0.25: the box is PCL's cube to the voxel
      IntensityCompressionSettings settings = settingsOf(edge, format);
      settings.bounding_box = BoundingBox{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
      Stream stream(settings);
      const float out = std::nextafter(1.0f, 2.0f);
      stream.add({{-1.0f, -1.0f, -1.0f},
                  {1.0f, 1.0f, 1.0f},
                  {1.0f, 0.0f, 0.0f},
                  {out, 0.0f, 0.0f},
                  {0.0f, -out, 0.0f},
                  {0.0f, 0.0f, out},
                  {largest, 0.0f, 0.0f}});
      EXPECT_EQ(stream.statistics.points_used, 3u) << "edge " << edge;
      EXPECT_EQ(stream.statistics.points_outside_box, 4u);
      EXPECT_EQ(stream.statistics.points_outside_grid, 0u);
    }
}

TEST(Voxelizer, FarPointsAreCountedAndTakeNoMemory)
{
  Cloud cloud = randomCloud(8, -1.0, 1.0, 500);
  Stream stream(settingsOf(0.04));
  stream.add(cloud);
  const VoxelGrid grid = stream.frame.grid;
  const std::size_t voxels = stream.frame.size();
  for (const float far : {1e8f, -1e8f, largest, -largest}) {
    cloud.push_back({far, 0.0f, 0.0f});
    cloud.push_back({0.0f, far, far});
  }
  for (const bool may_shrink : {false, true}) {
    const MemoryUse memory_use;
    stream.add(cloud, may_shrink);
    EXPECT_LT(memory_use.largest(), 64 * cloud.size());
    EXPECT_EQ(stream.statistics.points_outside_grid, 8u);
    EXPECT_EQ(stream.frame.size(), voxels);
    EXPECT_TRUE(stream.frame.grid == grid);
  }
  // The outermost voxels of the lattice, and the next ones.
  const MemoryUse memory_use;
  Stream metres(settingsOf(1.0));
  metres.add({{1048575.5f, 0.5f, 0.5f},
              {-1048576.0f, 0.5f, 0.5f},
              {1048576.0f, 0.5f, 0.5f},
              {-1048576.125f, 0.5f, 0.5f}});
  EXPECT_EQ(metres.statistics.points_used, 2u);
  EXPECT_EQ(metres.statistics.points_outside_grid, 2u);
  EXPECT_EQ(metres.frame.grid.depth, max_grid_depth);
  EXPECT_EQ(metres.values().count({1048575, 0, 0}), 1u);
  EXPECT_EQ(metres.values().count({-1048576, 0, 0}), 1u);
  // The grid of 21 levels is an address space, not an array.
  EXPECT_LT(memory_use.largest(), 100000u);
}

// ---------------------------------------------------------------- the grid

Cloud
spread(float low, float high)
{
  return {{low, low, low}, {high, high, high}};
}

TEST(Voxelizer, TheGridStaysWhileThePointsFitAndGrowsOtherwise)
{
  Stream stream(settingsOf(1.0));
  stream.add(spread(0.5f, 6.5f));
  const VoxelGrid first = stream.frame.grid;
  EXPECT_EQ(first.depth, 3u);
  for (const Cloud& cloud :
       {spread(1.5f, 2.5f), spread(0.5f, 0.6f), spread(0.0f, 6.9f)}) {
    stream.add(cloud);
    EXPECT_TRUE(stream.frame.grid == first);
  }
  stream.add(spread(-9.5f, -9.4f));
  const VoxelGrid second = stream.frame.grid;
  EXPECT_EQ(second.depth, 5u); // holds the first one, too
  EXPECT_EQ(stream.values().count({-10, -10, -10}), 1u);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_LE(second.first_index[axis], -10);
    EXPECT_GE(second.first_index[axis] + second.size(),
              first.first_index[axis] + first.size());
  }
  stream.add(spread(0.5f, 6.5f));
  EXPECT_TRUE(stream.frame.grid == second);
}

TEST(Voxelizer, TheGridShrinksOnlyWhenAllowedAndFarTooLarge)
{
  Stream stream(settingsOf(1.0));
  stream.add(spread(0.5f, 63.5f));
  const VoxelGrid large = stream.frame.grid;
  ASSERT_EQ(large.depth, 6u);
  stream.add(spread(0.5f, 3.5f), false);
  EXPECT_TRUE(stream.frame.grid == large);
  stream.add(spread(0.5f, 31.5f), true); // one level too many is breathing space
  EXPECT_TRUE(stream.frame.grid == large);
  stream.add(spread(0.5f, 15.5f), true);
  EXPECT_EQ(stream.frame.grid.depth, 4u);
  EXPECT_EQ(stream.values().count({15, 15, 15}), 1u);
  EXPECT_EQ(stream.values().count({0, 0, 0}), 1u);
}

TEST(Voxelizer, AFixedBoxFixesTheGrid)
{
  for (const auto format : {StreamFormat::Version1, StreamFormat::Published}) {
    IntensityCompressionSettings settings = settingsOf(0.04, format);
    settings.bounding_box = BoundingBox{{-1.0, -2.0, 0.3}, {1.0, 1.0, 2.0}};
    Stream stream(settings);
    stream.add({});
    const VoxelGrid grid = stream.frame.grid;
    EXPECT_EQ(grid.depth, 7u);
    for (const Cloud& cloud : {randomCloud(9, -3.0, 3.0), spread(0.5f, 0.51f)}) {
      stream.add(cloud, true);
      EXPECT_TRUE(stream.frame.grid == grid);
      EXPECT_GT(stream.frame.size(), 0u);
    }
  }
}

std::vector<BoundingBox>
boxes()
{
  std::vector<BoundingBox> boxes{{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}},
                                 {{0.0, 0.0, 0.0}, {5.12, 5.12, 5.12}},
                                 {{-2.56, 0.0, -0.01}, {2.56, 1.0, 0.01}},
                                 {{0.0, 0.0, 0.0}, {0.001, 0.001, 0.001}},
                                 // PCL leaves alone what is nearly a cube.
                                 {{0.0, 0.0, 0.0}, {4.0 - 1e-7, 4.0, 4.0}},
                                 {{1.0, 0.0, 0.0}, {5.0, 4.0 + 5e-8, 4.0}},
                                 {{100.0, -300.0, 4.0}, {140.96, -299.0, 4.5}}};
  std::mt19937_64 random(10);
  for (int i = 0; i < 300; ++i) {
    BoundingBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = double{uniform(random, -50.0, 50.0)};
      box.max[axis] =
          box.min[axis] + std::pow(10.0, double{uniform(random, -3.0, 2.0)});
    }
    boxes.push_back(box);
  }
  return boxes;
}

TEST(Voxelizer, ThePublishedGridIsPclsOctreeBox)
{
  for (const double resolution : {0.01, 0.02, 0.04, 0.1, 0.25, 1.0 / 3.0})
    for (const BoundingBox& box : boxes()) {
      pcl::octree::OctreePointCloud<pcl::PointXYZ> octree(resolution);
      octree.setResolution(resolution);
      octree.defineBoundingBox(
          box.min[0], box.min[1], box.min[2], box.max[0], box.max[1], box.max[2]);
      std::array<double, 3> min{};
      std::array<double, 3> max{};
      octree.getBoundingBox(min[0], min[1], min[2], max[0], max[1], max[2]);

      IntensityCompressionSettings settings =
          settingsOf(resolution, StreamFormat::Published);
      settings.bounding_box = box;
      Stream stream(settings);
      const VoxelGrid& grid = stream.add({}).grid;
      EXPECT_EQ(grid.depth, octree.getTreeDepth());
      EXPECT_EQ(grid.first_index, (std::array<std::int32_t, 3>{0, 0, 0}));
      EXPECT_EQ(grid.origin, min); // to the last bit
      EXPECT_EQ(grid.resolution, resolution);
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(grid.origin[axis] + static_cast<double>(grid.size()) * resolution,
                    max[axis],
                    3e-7); // within PCL's tolerance a box is left as it is
    }
}

} // namespace

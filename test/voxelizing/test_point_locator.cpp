// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simd/bit_operations.h"
#include "support/all_lanes.h"
#include "support/voxelized_stream.h"
#include "voxelizing/lattice.h"
#include "voxelizing/locate_points.h"
#include "voxels/grid_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::AllLanes;
using pcl_ext::test::TestOfLanes;

/** \brief Coordinates that are hard for a grid: all magnitudes, faces and their
 * neighbours, and what is no coordinate. */
std::vector<float>
hardCoordinates(const VoxelGrid& grid, std::uint64_t seed)
{
  std::vector<float> coordinates{0.0f,
                                 -0.0f,
                                 nan_value,
                                 infinity,
                                 -infinity,
                                 largest,
                                 -largest,
                                 std::numeric_limits<float>::denorm_min(),
                                 -std::numeric_limits<float>::denorm_min(),
                                 std::numeric_limits<float>::min(),
                                 -std::numeric_limits<float>::min()};
  std::mt19937_64 random(seed);
  for (int i = 0; i < 300; ++i) {
    const auto bits = static_cast<std::uint32_t>(random());
    float any;
    std::memcpy(&any, &bits, sizeof(any));
    coordinates.push_back(any);
    const std::size_t axis = random() % 3;
    const double low = grid.lowerCorner(axis);
    const double side = static_cast<double>(grid.size()) * grid.resolution;
    coordinates.push_back(uniform(random, low - 0.1 * side, low + 1.1 * side));
    const auto position = static_cast<double>(random() % (grid.size() + 3)) - 1.0;
    const auto face = static_cast<float>(low + position * grid.resolution);
    float above = face;
    float below = face;
    for (int step = 0; step < 4; ++step) {
      coordinates.push_back(above);
      coordinates.push_back(below);
      above = std::nextafter(above, infinity);
      below = std::nextafter(below, -infinity);
    }
  }
  return coordinates;
}

std::vector<VoxelGrid>
grids()
{
  std::vector<VoxelGrid> grids;
  for (const double resolution : {1e-6, 0.01, 0.04, 1.0 / 3.0, 0.5, 1e6})
    for (const std::int32_t first : {-1048576, -777, -1, 0, 5, 300000})
      for (const unsigned int depth : {1u, 2u, 3u, 8u, 17u})
        for (const double origin : {0.0, -7.3})
          grids.push_back(
              {resolution, {origin, 0.0, -origin}, {first, -first / 2, 3}, depth});
  grids.push_back({0.04, {}, {-1048576, -1048576, -1048576}, max_grid_depth});
  return grids;
}

struct EightVoxels {
  unsigned int certain; // bit i is set if the locator is certain of point i
  LocatedPoints located;
};

template <typename LanesT>
EightVoxels
locateEight(const LocatorGrid& grid, const std::array<float, 32>& points)
{
  EightVoxels voxels;
  CertainPoints certain{};
  const LocatorInput input{reinterpret_cast<const unsigned char*>(points.data()),
                           4 * sizeof(float),
                           8,
                           true};
  locatePointsWith<LanesT>(grid, input, voxels.located, certain);
  voxels.certain = certain[0];
  return voxels;
}

/** \brief What the locator is certain of must be what the division says. */
template <typename LanesT>
void
expectAgreement(const VoxelGrid& grid,
                const std::optional<BoundingBox>& box,
                std::size_t& certain_points)
{
  const std::array<std::int64_t, 3> all_begin{-2097152, -2097152, -2097152};
  const std::array<std::int64_t, 3> all_end{4194304, 4194304, 4194304};
  const Lattice lattice(grid, all_begin, all_end);
  const LocatorGrid locator_grid(grid, box);
  std::array<std::vector<float>, 3> axes{
      hardCoordinates(grid, 1), hardCoordinates(grid, 2), hardCoordinates(grid, 3)};
  std::mt19937_64 random(4);
  for (int i = 0; i < 1500; ++i) {
    std::array<float, 32> points{};
    for (std::size_t j = 0; j < points.size(); ++j)
      points[j] = axes[j % 3][random() % axes[0].size()];
    const EightVoxels voxels = locateEight<LanesT>(locator_grid, points);
    for (std::size_t lane = 0; lane < 8; ++lane) {
      if ((voxels.certain >> lane & 1) == 0)
        continue;
      ++certain_points;
      const float* const point = &points[4 * lane];
      std::array<std::int32_t, 3> index;
      ASSERT_TRUE(lattice.indexOf(point, index));
      std::array<std::uint32_t, 3> position;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t from_corner =
            std::int64_t{index[axis]} - grid.first_index[axis];
        ASSERT_GE(from_corner, 0);
        ASSERT_LT(from_corner, grid.size());
        position[axis] = static_cast<std::uint32_t>(from_corner);
        if (box) {
          ASSERT_GE(double{point[axis]}, box->min[axis]);
          ASSERT_LE(double{point[axis]}, box->max[axis]);
        }
      }
      const BlockVoxel expected = blockVoxelOf({position[0], position[1], position[2]});
      ASSERT_EQ(voxels.located.blocks[lane], expected.block);
      ASSERT_EQ(voxels.located.voxels[lane], expected.voxel);
    }
  }
}

template <typename LanesOfT>
using PointLocators = TestOfLanes<LanesOfT>;
TYPED_TEST_SUITE(PointLocators, AllLanes);

TYPED_TEST(PointLocators, AgreeWithTheDivisionWhereCertain)
{
  std::size_t certain_points = 0;
  for (const VoxelGrid& grid : grids())
    expectAgreement<typename TypeParam::Lanes>(grid, std::nullopt, certain_points);
  EXPECT_GT(certain_points, 10000u);
}

TYPED_TEST(PointLocators, AreNotCertainOutsideTheBox)
{
  std::size_t certain_points = 0;
  for (const VoxelGrid& grid : grids()) {
    BoundingBox box;
    const double side = static_cast<double>(grid.size()) * grid.resolution;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = grid.lowerCorner(axis) + 0.1 * side;
      box.max[axis] = grid.lowerCorner(axis) + 0.9 * side;
    }
    expectAgreement<typename TypeParam::Lanes>(grid, box, certain_points);
  }
  EXPECT_GT(certain_points, 10000u);
}

TYPED_TEST(PointLocators, AreCertainOfMostPoints)
{
  const VoxelGrid grid{0.04, {}, {-128, -128, -128}, 8};
  const LocatorGrid locator_grid(grid, std::nullopt);
  ASSERT_TRUE(locator_grid.is_useful);
  std::mt19937_64 random(5);
  std::size_t certain_points = 0;
  constexpr std::size_t rounds = 5000;
  for (std::size_t i = 0; i < rounds; ++i) {
    std::array<float, 32> points{};
    for (float& coordinate : points)
      coordinate = uniform(random, -5.0, 5.0);
    const EightVoxels voxels =
        locateEight<typename TypeParam::Lanes>(locator_grid, points);
    certain_points += pcl_ext::bitCount(voxels.certain);
  }
  EXPECT_GT(certain_points, 8 * rounds * 99 / 100);
}

TYPED_TEST(PointLocators, AreCertainOfWholeMillimetresOnTheFacesOfVoxels)
{
  const VoxelGrid grid{0.0001, {}, {-9654, -10204, 3729}, 14};
  const LocatorGrid locator_grid(grid, std::nullopt);
  for (int millimetres = 373; millimetres < 2000; ++millimetres) {
    std::array<float, 32> points{};
    for (std::size_t point = 0; point < 8; ++point) {
      points[4 * point] = static_cast<float>(millimetres % 600) / 1000.0f;
      points[4 * point + 1] = -points[4 * point];
      points[4 * point + 2] = static_cast<float>(millimetres) / 1000.0f;
    }
    EXPECT_EQ(locateEight<typename TypeParam::Lanes>(locator_grid, points).certain,
              255u)
        << millimetres;
  }
}

/** \brief All lanes types compute the same, also of which points they are certain. */
TYPED_TEST(PointLocators, AgreeWithScalarLanes)
{
  std::mt19937_64 random(6);
  for (const VoxelGrid& grid : grids()) {
    const LocatorGrid locator_grid(grid, std::nullopt);
    const std::vector<float> coordinates = hardCoordinates(grid, random());
    // Not aligned, and no byte after the last z.
    const std::size_t stride = 12 + random() % 8;
    const std::size_t count = random() % (LocatedPoints::capacity + 1);
    std::vector<unsigned char> bytes(count == 0 ? 0 : stride * (count - 1) + 12);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        std::memcpy(&bytes[i * stride + axis * sizeof(float)],
                    &coordinates[random() % coordinates.size()],
                    sizeof(float));
    const LocatorInput input{bytes.data(), stride, count, false};
    LocatedPoints located;
    LocatedPoints expected;
    CertainPoints certain{};
    CertainPoints expected_certain{};
    locatePointsWith<typename TypeParam::Lanes>(locator_grid, input, located, certain);
    locatePointsWith<pcl_ext::ScalarLanes>(
        locator_grid, input, expected, expected_certain);
    ASSERT_EQ(certain, expected_certain);
    for (std::size_t i = 0; i < count; ++i) {
      if ((certain[i / 8] >> i % 8 & 1) != 0) {
        ASSERT_EQ(located.blocks[i], expected.blocks[i]);
        ASSERT_EQ(located.voxels[i], expected.voxels[i]);
      }
    }
  }
}

TEST(Lattice, OutermostCoordinates)
{
  for (const double resolution : {1e-6, 0.01, 0.04, 1.0 / 3.0, 1e6}) {
    // With the last ones the lattice begins or ends at 0, around which are a billion
    // floats.
    const double end_at_0 = -static_cast<double>(lattice_end) * resolution;
    for (const double origin : {0.0, 12.7, end_at_0, -end_at_0}) {
      const VoxelGrid grid{resolution, {origin, -origin, 0.0}, {0, 0, 0}, 1};
      const std::array<std::int64_t, 3> begin{-lattice_end, -5, 0};
      const std::array<std::int64_t, 3> end{lattice_end, 77, 1};
      const Lattice lattice(grid, begin, end);
      const std::array<float, 3> lowest = lattice.lowestCoordinates();
      const std::array<float, 3> highest = lattice.highestCoordinates();
      std::array<std::int32_t, 3> index;
      EXPECT_TRUE(lattice.indexOf(lowest.data(), index));
      EXPECT_TRUE(lattice.indexOf(highest.data(), index));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::array<float, 3> outside = lowest;
        outside[axis] = std::nextafter(lowest[axis], -infinity);
        EXPECT_FALSE(lattice.indexOf(outside.data(), index));
        outside[axis] = std::nextafter(highest[axis], infinity);
        EXPECT_FALSE(lattice.indexOf(outside.data(), index));
      }
    }
  }
}

} // namespace

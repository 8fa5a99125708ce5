#include "support/voxelized_stream.h"
#include "voxelizing/lattice.h"
#include "voxelizing/quad_locator.h"
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
using pcl_ext::NativeLanes;
using pcl_ext::ScalarLanes;

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
        for (const double anchor : {0.0, -7.3})
          grids.push_back(
              {resolution, {anchor, 0.0, -anchor}, {first, -first / 2, 3}, depth});
  grids.push_back({0.04, {}, {-1048576, -1048576, -1048576}, max_grid_depth});
  return grids;
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
  const QuadLocator<LanesT> locator(grid, box);
  std::array<std::vector<float>, 3> axes{
      hardCoordinates(grid, 1), hardCoordinates(grid, 2), hardCoordinates(grid, 3)};
  std::mt19937_64 random(4);
  for (int i = 0; i < 3000; ++i) {
    std::array<float, 16> points{};
    for (std::size_t j = 0; j < points.size(); ++j)
      points[j] = axes[j % 3][random() % axes[0].size()];
    std::array<std::uint64_t, 4> blocks;
    std::array<std::uint32_t, 4> voxels;
    const unsigned int certain =
        locator.locate(reinterpret_cast<const unsigned char*>(points.data()),
                       4 * sizeof(float),
                       blocks.data(),
                       voxels.data());
    for (std::size_t lane = 0; lane < 4; ++lane) {
      if ((certain >> lane & 1) == 0)
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
      const BlockPlace expected = blockPlace({position[0], position[1], position[2]});
      ASSERT_EQ(blocks[lane], expected.block);
      ASSERT_EQ(voxels[lane], expected.voxel);
    }
  }
}

template <typename LanesT>
class QuadLocators : public ::testing::Test {};

using AllLanes = ::testing::Types<ScalarLanes, NativeLanes>;
TYPED_TEST_SUITE(QuadLocators, AllLanes);

TYPED_TEST(QuadLocators, AgreeWithTheDivisionWhereCertain)
{
  std::size_t certain_points = 0;
  for (const VoxelGrid& grid : grids())
    expectAgreement<TypeParam>(grid, std::nullopt, certain_points);
  EXPECT_GT(certain_points, 10000u);
}

TYPED_TEST(QuadLocators, AreNotCertainOutsideTheBox)
{
  std::size_t certain_points = 0;
  for (const VoxelGrid& grid : grids()) {
    BoundingBox box;
    const double side = static_cast<double>(grid.size()) * grid.resolution;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = grid.lowerCorner(axis) + 0.1 * side;
      box.max[axis] = grid.lowerCorner(axis) + 0.9 * side;
    }
    expectAgreement<TypeParam>(grid, box, certain_points);
  }
  EXPECT_GT(certain_points, 10000u);
}

TYPED_TEST(QuadLocators, AreCertainOfMostPoints)
{
  const VoxelGrid grid{0.04, {}, {-128, -128, -128}, 8};
  const QuadLocator<TypeParam> locator(grid, std::nullopt);
  ASSERT_TRUE(locator.isUseful());
  std::mt19937_64 random(5);
  std::size_t certain_points = 0;
  constexpr std::size_t quads = 10000;
  for (std::size_t i = 0; i < quads; ++i) {
    std::array<float, 16> points{};
    for (float& coordinate : points)
      coordinate = uniform(random, -5.0, 5.0);
    std::array<std::uint64_t, 4> blocks;
    std::array<std::uint32_t, 4> voxels;
    for (unsigned int certain =
             locator.locate(reinterpret_cast<const unsigned char*>(points.data()),
                            4 * sizeof(float),
                            blocks.data(),
                            voxels.data());
         certain != 0;
         certain &= certain - 1)
      ++certain_points;
  }
  EXPECT_GT(certain_points, 4 * quads * 99 / 100);
}

TYPED_TEST(QuadLocators, AreCertainOfWholeMillimetresOnTheFacesOfVoxels)
{
  const VoxelGrid grid{0.0001, {}, {-9654, -10204, 3729}, 14};
  const QuadLocator<TypeParam> locator(grid, std::nullopt);
  for (int millimetres = 373; millimetres < 2000; ++millimetres) {
    std::array<float, 16> points{};
    for (std::size_t point = 0; point < 4; ++point) {
      points[4 * point] = static_cast<float>(millimetres % 600) / 1000.0f;
      points[4 * point + 1] = -points[4 * point];
      points[4 * point + 2] = static_cast<float>(millimetres) / 1000.0f;
    }
    std::array<std::uint64_t, 4> blocks;
    std::array<std::uint32_t, 4> voxels;
    EXPECT_EQ(locator.locate(reinterpret_cast<const unsigned char*>(points.data()),
                             4 * sizeof(float),
                             blocks.data(),
                             voxels.data()),
              15u)
        << millimetres;
  }
}

TEST(Lattice, OutermostCoordinates)
{
  for (const double resolution : {1e-6, 0.01, 0.04, 1.0 / 3.0, 1e6})
    for (const double anchor : {0.0, 12.7}) {
      const VoxelGrid grid{resolution, {anchor, -anchor, 0.0}, {0, 0, 0}, 1};
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

} // namespace

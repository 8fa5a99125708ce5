// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/direction_depths.h"
#include "voxelizing/point_batches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <type_traits>
#include <vector>

namespace {

using namespace pcl_ext;

constexpr std::uint32_t square_count = 6 * 256 * 256;
constexpr float unseen = DirectionDepths::unseen;

/** \brief The square of a point by cases: the axis along which it is farthest, the first
 * of several, and where the line to it meets that face. */
std::uint32_t
expectedSquare(const std::array<float, 3>& at)
{
  std::uint32_t axis = 0;
  for (std::uint32_t other = 1; other < 3; ++other)
    if (std::fabs(at[other]) > std::fabs(at[axis]))
      axis = other;
  const float depth = std::fabs(at[axis]);
  const auto square = [&](std::uint32_t across) {
    const float part = (at[across % 3] / depth + 1.0f) * 128.0f;
    return std::min(static_cast<std::uint32_t>(part), 255u);
  };
  const std::uint32_t face = 2 * axis + (at[axis] < 0.0f ? 1 : 0);
  return (face * 256 + square(axis + 1)) * 256 + square(axis + 2);
}

class Expected {
public:
  void
  add(const std::array<float, 3>& at)
  {
    const float depth =
        std::max({std::fabs(at[0]), std::fabs(at[1]), std::fabs(at[2])});
    const auto [of_square, is_new] = depths_.emplace(expectedSquare(at), depth);
    of_square->second = std::min(of_square->second, depth);
  }

  void
  expectEqual(const DirectionDepths& depths) const
  {
    for (std::uint32_t square = 0; square < square_count; ++square) {
      const auto expected = depths_.find(square);
      ASSERT_EQ(depths[square], expected == depths_.end() ? unseen : expected->second)
          << square;
    }
  }

private:
  std::map<std::uint32_t, float> depths_;
};

/** \brief Coordinates of points all around, of which many share a square. */
std::vector<float>
randomPoints(std::size_t count)
{
  std::mt19937 random(5);
  std::vector<float> coordinates;
  for (std::size_t i = 0; i < 3 * count; ++i)
    coordinates.push_back(static_cast<float>(static_cast<int>(random() % 2001) - 1000) /
                          250.0f);
  return coordinates;
}

TEST(DirectionDepths, KeepsTheLeastOfEachSquareUntilItIsCleared)
{
  DirectionDepths depths;
  for (const std::size_t count : {64u, 17u}) {
    Expected expected;
    DirectionDepths::Batch batch{};
    const std::vector<float> points = randomPoints(count * 1000);
    for (std::size_t first = 0; first < 1000; ++first) {
      for (std::size_t i = 0; i < count; ++i) {
        const float* const at = &points[3 * (first * count + i)];
        for (std::size_t axis = 0; axis < 3; ++axis)
          batch[axis][i] = at[axis];
        if (std::max({std::fabs(at[0]), std::fabs(at[1]), std::fabs(at[2])}) >= 0.5f)
          expected.add({at[0], at[1], at[2]});
      }
      depths.add(batch, count, 0.5f);
    }
    expected.expectEqual(depths);
    depths.clear();
  }
  Expected().expectEqual(depths);
}

TEST(DirectionDepths, TheLeastAroundEndsAtTheEdgesOfAFace)
{
  DirectionDepths depths;
  DirectionDepths::Batch batch{};
  // In the corner square of the face of x, and in the first row of the face of -x.
  batch[0] = {3.0f, -2.0f};
  batch[1] = {-3.0f, -2.0f};
  batch[2] = {-3.0f, 2.0f};
  depths.add(batch, 2, 1.0f);
  EXPECT_EQ(depths.leastAround(0, 0), 3.0f);
  EXPECT_EQ(depths.leastAround(3 * 256 + 3, 3), 3.0f);
  EXPECT_EQ(depths.leastAround(3 * 256 + 3, 2), unseen);
  EXPECT_EQ(depths.leastAround(255, 3), unseen);                 // of x
  EXPECT_EQ(depths.leastAround(65536 + 2 * 256 + 254, 2), 2.0f); // of -x
  EXPECT_EQ(depths.leastAround(65536 + 255 * 256 + 255, 3), unseen);
  EXPECT_EQ(depths.leastAround(5 * 65536, 3), unseen); // a face without depths
}

/** \brief Depths of the points of random coordinates outside of a box whose ends no float
 * has, with some that are none. */
template <typename NumberT>
void
expectThoseOutside(const std::array<double, 3>& position)
{
  const io::BoundingBox box{{-1.1, -2.0, -0.7},
                            {1.1, 0.3, std::numeric_limits<double>::infinity()}};
  std::vector<NumberT> points;
  for (const float coordinate : randomPoints(20000))
    points.push_back(static_cast<NumberT>(coordinate));
  // Floats at 1.1 are outside, as the nearest one is above it.
  ASSERT_GT(static_cast<double>(1.1f), 1.1);
  const NumberT nan = std::numeric_limits<NumberT>::quiet_NaN();
  points.insert(points.end(), {NumberT(1.1f), 0, 0, nan, 5, 5, 5, nan, 5, 0, 0, 5});
  points.insert(points.end(), {std::numeric_limits<NumberT>::infinity(), 0, 0});
  for (std::size_t axis = 0; axis < 3; ++axis)
    points.push_back(static_cast<NumberT>(position[axis]));
  Expected expected;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    bool is_inside = true;
    bool is_finite = true;
    std::array<float, 3> at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto coordinate = static_cast<double>(points[i + axis]);
      is_inside =
          is_inside && coordinate >= box.min[axis] && coordinate <= box.max[axis];
      is_finite = is_finite && std::isfinite(coordinate);
      at[axis] = static_cast<float>(coordinate - position[axis]);
    }
    if (is_finite && !is_inside && at != std::array<float, 3>{})
      expected.add(at);
  }
  io::PointView view;
  view.count = points.size() / 3;
  if constexpr (std::is_same_v<NumberT, double>)
    view.double_coordinates = points.data();
  else
    view.coordinates = points.data();
  view.coordinate_stride = 3 * sizeof(NumberT);
  io::SingleBatch batches(view);
  DirectionDepths depths;
  depths.addBeyond(batches, box, position);
  expected.expectEqual(depths);
}

TEST(RaysBeyond, AreThoseOfFinitePointsOutsideOfTheBox)
{
  for (const std::array<double, 3>& position :
       {std::array<double, 3>{0.2, -1.3, 0.4}, std::array<double, 3>{2.0, 2.0, -2.0}}) {
    expectThoseOutside<float>(position);
    expectThoseOutside<double>(position);
  }
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/point_view.h>

#include "support/point_views.h"
#include "support/voxel_frames.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;
using Points = std::vector<ColouredPoint>;

std::vector<ColouredPoint>
colouredPoints(std::size_t count, double width)
{
  std::mt19937_64 random(19);
  std::vector<ColouredPoint> points(count);
  for (ColouredPoint& point : points) {
    point.x = uniform(random, -width, width);
    point.y = uniform(random, -width, width);
    point.z = uniform(random, -width, width);
    point.intensity = 1.0f;
    point.colour = static_cast<std::uint32_t>(random() >> 32);
  }
  return points;
}

/** \brief Number of points and sums of their channels, by lattice index. */
using Sums = std::map<std::array<std::int64_t, 3>, std::array<std::uint64_t, 4>>;

Sums
sumsOf(const std::vector<ColouredPoint>& points, double resolution)
{
  Sums sums;
  for (const ColouredPoint& point : points) {
    const auto index = [&](float coordinate) {
      return static_cast<std::int64_t>(
          std::floor(static_cast<double>(coordinate) / resolution));
    };
    auto& sum = sums[{index(point.x), index(point.y), index(point.z)}];
    ++sum[0];
    for (unsigned int channel = 0; channel < 3; ++channel)
      sum[1 + channel] += point.colour >> (16 - 8 * channel) & 0xff;
  }
  return sums;
}

class VoxelAttributes : public ::testing::TestWithParam<double> {};

// Edges with about one, ten and some hundred points in a voxel: sorted voxels and
// blocks.
INSTANTIATE_TEST_SUITE_P(Edges, VoxelAttributes, ::testing::Values(0.001, 0.1, 0.25));

TEST_P(VoxelAttributes, AreTheMeanColourAndTheNumberOfThePoints)
{
  IntensityCompressionSettings settings;
  settings.resolution = GetParam();
  settings.keep_points = true;
  const std::vector<ColouredPoint> points = colouredPoints(5000, 0.5);
  const Sums sums = sumsOf(points, settings.resolution);
  for (const unsigned int bits : {1u, 4u, 8u}) {
    settings.colour_bits = bits;
    Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::None);
    for (int cloud = 0; cloud < 2; ++cloud) {
      VoxelFrame frame;
      voxelizer.voxelize(viewOf(points), true, frame);
      ASSERT_TRUE(isConsistent(frame));
      ASSERT_EQ(frame.size(), sums.size());
      EXPECT_FALSE(frame.hasIntensities());
      EXPECT_EQ(frame.pointCount(), points.size());
      const std::uint64_t highest = (std::uint64_t{1} << bits) - 1;
      for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
        const auto& sum = sums.at(latticeIndex(frame, voxel));
        EXPECT_EQ(frame.point_counts[voxel], sum[0]);
        // Rounded to the nearest step, half a step up.
        const auto mean = [&](std::size_t channel) {
          const std::uint64_t full_scale = 255 * sum[0];
          return (2 * sum[channel] * highest + full_scale) / (2 * full_scale);
        };
        const VoxelColour& colour = frame.colours[voxel];
        EXPECT_EQ(colour.r, mean(1));
        EXPECT_EQ(colour.g, mean(2));
        EXPECT_EQ(colour.b, mean(3));
      }
    }
  }
}

TEST(VoxelAttribute, ColoursAreThereOnlyWhereTheCloudHasThem)
{
  IntensityCompressionSettings settings;
  const std::vector<ColouredPoint> points = colouredPoints(100, 0.5);
  PointView view = viewOf(points);
  Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Points);
  VoxelFrame frame;
  voxelizer.voxelize(view, true, frame);
  EXPECT_EQ(frame.colour_bits, settings.colour_bits);
  EXPECT_EQ(frame.colours.size(), frame.size());
  view.colours = nullptr;
  voxelizer.voxelize(view, true, frame);
  EXPECT_EQ(frame.colour_bits, 0u);
  EXPECT_TRUE(frame.colours.empty());
  EXPECT_FALSE(frame.has_point_counts);
  EXPECT_TRUE(frame.hasIntensities());
}

TEST(VoxelAttribute, FullColoursSpanTheWholeRange)
{
  VoxelFrame frame;
  for (unsigned int bits = 1; bits <= 8; ++bits) {
    frame.colour_bits = bits;
    const unsigned int highest = (1u << bits) - 1;
    for (unsigned int channel = 0; channel <= highest; ++channel) {
      const auto value = static_cast<std::uint8_t>(channel);
      frame.colours = {{value, 0, static_cast<std::uint8_t>(highest)}};
      const VoxelColour full = frame.fullColour(0);
      EXPECT_EQ(full.r, std::lround(255.0 * channel / highest));
      EXPECT_EQ(full.g, 0);
      EXPECT_EQ(full.b, 255);
    }
  }
}

/** \brief Slices of a cloud, of 1 to some hundred points, each in the same memory. */
class Slices : public PointBatches {
public:
  explicit Slices(const Points& points) : points_(points) {}

  std::size_t
  size() const override
  {
    return points_.size();
  }

  bool
  hasIntensities() const override
  {
    return true;
  }

  bool
  hasColours() const override
  {
    return true;
  }

  void
  restart() override
  {
    next_ = 0;
    ++restarts;
  }

  bool
  next(PointView& points) override
  {
    const std::size_t count =
        std::min<std::size_t>(1 + random_() % 700, points_.size() - next_);
    slice_.assign(points_.begin() + static_cast<std::ptrdiff_t>(next_),
                  points_.begin() + static_cast<std::ptrdiff_t>(next_ + count));
    next_ += count;
    points = viewOf(slice_);
    return count > 0;
  }

  std::size_t
  pointsBehindSensor() const override
  {
    return next_ / 2;
  }

  int restarts = 0;

private:
  const Points& points_;
  std::size_t next_ = 0;
  Points slice_;
  std::mt19937 random_{5};
};

Points
randomPoints(unsigned int seed, std::size_t count, double centre, double width)
{
  std::mt19937_64 random(seed);
  Points points(count);
  for (ColouredPoint& point : points) {
    for (float* const coordinate : {&point.x, &point.y, &point.z})
      *coordinate = uniform(random, centre - width, centre + width);
    point.intensity = uniform(random, 0.0, 50.0);
    point.colour = static_cast<std::uint32_t>(random());
    if (random() % 50 == 0)
      point.y = std::numeric_limits<float>::quiet_NaN();
  }
  return points;
}

TEST(PointBatches, GiveTheFramesOfTheWholeClouds)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.05;
  settings.colour_bits = 5;
  settings.keep_points = true;
  Voxelizer of_clouds(settings, IntensityUnit::Native);
  Voxelizer of_batches(settings, IntensityUnit::Native);
  VoxelFrame expected;
  VoxelFrame frame;
  // Dense, wider, sparse, far from the origin, empty.
  const std::vector<Points> clouds{randomPoints(1, 20000, 0.0, 0.5),
                                   randomPoints(2, 20000, 0.0, 0.5),
                                   randomPoints(3, 9000, 1.0, 3.0),
                                   randomPoints(4, 9000, 1.0, 300.0),
                                   randomPoints(5, 3000, 90000.0, 2.0),
                                   {},
                                   randomPoints(6, 500, 90000.0, 2.0)};
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    SCOPED_TRACE(i);
    Slices slices(clouds[i]);
    const bool may_refit = i % 3 == 0;
    const VoxelizationStatistics whole =
        of_clouds.voxelize(viewOf(clouds[i]), may_refit, expected);
    const VoxelizationStatistics sliced = of_batches.voxelize(slices, may_refit, frame);
    EXPECT_TRUE(frame.grid == expected.grid);
    ASSERT_EQ(frame.keys, expected.keys);
    EXPECT_EQ(frame.intensities, expected.intensities);
    EXPECT_EQ(frame.point_counts, expected.point_counts);
    ASSERT_EQ(frame.colours.size(), expected.colours.size());
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
      ASSERT_TRUE(frame.fullColour(voxel).r == expected.fullColour(voxel).r &&
                  frame.fullColour(voxel).g == expected.fullColour(voxel).g &&
                  frame.fullColour(voxel).b == expected.fullColour(voxel).b);
    EXPECT_EQ(sliced.points, clouds[i].size());
    EXPECT_EQ(sliced.points_used, whole.points_used);
    EXPECT_EQ(sliced.points_not_finite, whole.points_not_finite);
    EXPECT_EQ(sliced.points_outside_grid, whole.points_outside_grid);
    // The passes before the last one are not counted.
    EXPECT_EQ(sliced.points_behind_sensor, clouds[i].size() / 2);
  }
}

TEST(PointBatches, AreReadOnceUnlessTheGridIsFitted)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.05;
  Voxelizer voxelizer(settings, IntensityUnit::Native);
  VoxelFrame frame;
  const Points points = randomPoints(7, 20000, 0.0, 0.5);
  Slices first(points);
  voxelizer.voxelize(first, true, frame);
  EXPECT_EQ(first.restarts, 2);
  Slices second(points);
  voxelizer.voxelize(second, false, frame);
  EXPECT_EQ(second.restarts, 1);
  settings.bounding_box = BoundingBox{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
  Voxelizer in_box(settings, IntensityUnit::Native);
  Slices boxed(points);
  in_box.voxelize(boxed, true, frame);
  EXPECT_EQ(boxed.restarts, 1);
}

} // namespace

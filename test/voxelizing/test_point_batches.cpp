// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds whose points come some at a time give the frames of the whole clouds.
 */
#include <pcl_ext/compression/point_view.h>

#include "support/voxel_frames.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using pcl_ext::IntensityUnit;
using namespace pcl_ext::io::test;

struct Point {
  std::array<float, 3> place;
  float intensity;
  std::uint32_t colour;
};

using Points = std::vector<Point>;

PointView
viewOf(const Points& points)
{
  static const Point none{};
  const Point& first = points.empty() ? none : points.front();
  PointView view;
  view.coordinates = first.place.data();
  view.coordinate_stride = sizeof(Point);
  view.intensities = &first.intensity;
  view.intensity_stride = view.coordinate_stride;
  view.colours = &first.colour;
  view.colour_stride = sizeof(Point);
  view.count = points.size();
  return view;
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
  for (Point& point : points) {
    for (float& coordinate : point.place)
      coordinate = uniform(random, centre - width, centre + width);
    point.intensity = uniform(random, 0.0, 50.0);
    point.colour = static_cast<std::uint32_t>(random());
    if (random() % 50 == 0)
      point.place[1] = std::numeric_limits<float>::quiet_NaN();
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

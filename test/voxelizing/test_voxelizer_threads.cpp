// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/point_view.h>

#include "platforms/run_at_once.h"
#include "support/point_views.h"
#include "support/voxel_frames.h"
#include "voxelizing/parallel_collector.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;

using Point = ColouredPoint;
using Cloud = std::vector<Point>;

/** \brief Points in a box, some of them not finite or very far, with intensities in
 * steps of 0.01, some of them not finite. */
Cloud
randomCloud(std::uint64_t seed, std::size_t count, float width, float centre = 0.0f)
{
  std::mt19937_64 random(seed);
  Cloud cloud(count);
  for (Point& point : cloud) {
    point.x = centre + uniform(random, -width, width);
    point.y = uniform(random, -width, width);
    point.z = uniform(random, -width, width);
    point.intensity = static_cast<float>(below(random, 1000)) / 100.0f;
    point.colour = static_cast<std::uint32_t>(random());
    const std::uint64_t kind = below(random, 3000);
    if (kind == 0)
      point.z = std::numeric_limits<float>::quiet_NaN();
    else if (kind == 1)
      point.y = 1e30f;
    else if (kind == 2)
      point.intensity = std::numeric_limits<float>::infinity();
  }
  return cloud;
}

IntensityCompressionSettings
settingsOf(double resolution, unsigned int threads)
{
  IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.colour_bits = 5;
  settings.keep_points = true;
  settings.threads = threads;
  return settings;
}

void
expectSame(const VoxelizationStatistics& one, const VoxelizationStatistics& other)
{
  EXPECT_EQ(one.resolution, other.resolution);
  EXPECT_EQ(one.points, other.points);
  EXPECT_EQ(one.points_used, other.points_used);
  EXPECT_EQ(one.points_not_finite, other.points_not_finite);
  EXPECT_EQ(one.points_outside_box, other.points_outside_box);
  EXPECT_EQ(one.points_outside_grid, other.points_outside_grid);
  EXPECT_EQ(one.points_behind_sensor, other.points_behind_sensor);
  EXPECT_EQ(one.intensities_not_finite, other.intensities_not_finite);
  EXPECT_EQ(one.intensities_out_of_range, other.intensities_out_of_range);
  EXPECT_EQ(one.intensities_vanished, other.intensities_vanished);
  EXPECT_EQ(one.voxels, other.voxels);
}

TEST(VoxelizerThreads, AnyNumberOfThemGivesTheSameFrames)
{
  // Dense; dense and wider, so that the grid grows; sparse; few points; far away; none.
  const std::vector<Cloud> clouds{randomCloud(1, 150000, 0.5f),
                                  randomCloud(2, 150001, 0.5f),
                                  randomCloud(3, 140000, 4.0f),
                                  randomCloud(4, 140000, 300.0f),
                                  randomCloud(5, 99999, 300.0f),
                                  randomCloud(6, 7, 0.5f),
                                  randomCloud(7, 131072, 2.0f, 90000.0f),
                                  {},
                                  randomCloud(8, 131072, 2.0f)};
  for (const IntensityUnit unit : {IntensityUnit::Native, IntensityUnit::Share})
    for (const unsigned int threads : {2u, 3u, 4u, 16u}) {
      SCOPED_TRACE(threads);
      Voxelizer of_one(settingsOf(0.05, 1), unit);
      Voxelizer of_several(settingsOf(0.05, threads), unit);
      VoxelFrame expected;
      VoxelFrame frame;
      for (std::size_t i = 0; i < clouds.size(); ++i) {
        SCOPED_TRACE(i);
        SingleBatch cloud(viewOf(clouds[i]), clouds[i].size() / 3);
        expectSame(of_several.voxelize(cloud, i % 4 == 3, frame),
                   of_one.voxelize(cloud, i % 4 == 3, expected));
        expectSameFrame(frame, expected);
        EXPECT_TRUE(frame.intensity_scale == expected.intensity_scale);
      }
    }
}

TEST(VoxelizerThreads, TheStepOfIntensitiesIsThatOfAllParts)
{
  Cloud cloud = randomCloud(1, 70000, 0.5f);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud[i].intensity = i < cloud.size() / 4 ? 0.5f : 3.0f;
  VoxelFrame expected;
  VoxelFrame frame;
  Voxelizer(settingsOf(0.05, 1), IntensityUnit::Native)
      .voxelize(viewOf(cloud), true, expected);
  Voxelizer(settingsOf(0.05, 2), IntensityUnit::Native)
      .voxelize(viewOf(cloud), true, frame);
  expectSameFrame(frame, expected);
  EXPECT_TRUE(frame.intensity_scale == expected.intensity_scale);
}

TEST(VoxelizerThreads, WhatAThreadThrowsIsPassedOn)
{
  for (std::size_t thrower = 0; thrower < 3; ++thrower) {
    const auto work = [thrower](std::size_t i) {
      if (i == thrower)
        throw std::runtime_error("of a thread");
    };
    EXPECT_THROW(runAtOnce(3, work), std::runtime_error) << thrower;
  }
}

TEST(VoxelizerThreads, ABoxAndCountsWithoutIntensities)
{
  IntensityCompressionSettings settings = settingsOf(0.05, 1);
  settings.bounding_box = BoundingBox{{-0.3, -0.3, -0.3}, {0.4, 0.4, 0.4}};
  Voxelizer of_one(settings, IntensityUnit::Points);
  settings.threads = 4;
  Voxelizer of_several(settings, IntensityUnit::Points);
  VoxelFrame expected;
  VoxelFrame frame;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const Cloud cloud = randomCloud(i, 140000, 0.5f);
    PointView view = viewOf(cloud);
    view.intensities = nullptr;
    view.colours = nullptr;
    expectSame(of_several.voxelize(view, false, frame),
               of_one.voxelize(view, false, expected));
    expectSameFrame(frame, expected);
  }
}

/** \brief The sums of a cloud's intensities, as one or several threads compute them. */
class Sums {
public:
  explicit Sums(unsigned int threads)
  : locator_(settingsOf(0.5, threads)), collector_(threads)
  {
    VoxelGrid grid;
    grid.resolution = 0.5;
    grid.first_index = {-4, -4, -4};
    grid.depth = 3;
    locator_.setGrid(grid);
  }

  const std::vector<double>&
  of(const Cloud& cloud)
  {
    CollectedFields fields;
    fields.intensities = true;
    SingleBatch batch(viewOf(cloud));
    EXPECT_EQ(collector_.collect(batch, locator_, fields, false, keys_, sums_),
              CollectionResult::AllPoints);
    return sums_.intensities;
  }

  void
  forgetRounding()
  {
    collector_.forgetRounding();
  }

private:
  VoxelLocator locator_;
  ParallelCollector collector_;
  std::vector<std::uint64_t> keys_;
  VoxelSums sums_;
};

TEST(VoxelizerThreads, SumsThatAreRoundedAreThoseOfOneThread)
{
  std::mt19937_64 random(1);
  Cloud cloud(200000);
  for (Point& point : cloud)
    point = {uniform(random, -1.9, 1.9), 0.1f, 0.1f, uniform(random, 0.0, 1.0), 0};
  Cloud rounded = cloud;
  for (Point& point : rounded)
    point.intensity *= uniform(random, 0.0, 1e9);

  // The sum of the halves is another one, so that the test can fail.
  Sums one(1);
  const std::vector<double> sums = one.of(rounded);
  const auto middle = rounded.begin() + 100000;
  std::vector<double> of_halves = one.of(Cloud(rounded.begin(), middle));
  const std::vector<double> second = one.of(Cloud(middle, rounded.end()));
  for (std::size_t i = 0; i < of_halves.size(); ++i)
    of_halves[i] += second.at(i);
  ASSERT_NE(of_halves, sums);

  Sums several(2);
  EXPECT_EQ(several.of(rounded), sums);
  EXPECT_EQ(several.of(rounded), sums);
  for (Point& point : cloud)
    point.intensity += 0.01f; // such sums are exact
  EXPECT_EQ(several.of(cloud), one.of(cloud));
  several.forgetRounding();
  EXPECT_EQ(several.of(cloud), one.of(cloud));
  EXPECT_EQ(several.of(rounded), sums);
}

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/test_memory.h"
#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;
using pcl_ext::test::MemoryUse;

Cloud
surface(std::uint64_t seed, float x, std::size_t count = 4000)
{
  std::mt19937_64 random(seed);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const float y = uniform(random, 0.0, 1.0);
    cloud.push_back({x + 0.3f * y + uniform(random, -0.02, 0.02),
                     y,
                     uniform(random, 0.0, 1.0),
                     uniform(random, 0.0, 0.3)});
  }
  return cloud;
}

TEST(VoxelizerStreams, CloudsThatMoveAndTurnSparseEqualSingleClouds)
{
  for (const double resolution : {0.005, 0.04, 0.5}) {
    Stream stream(settingsOf(resolution));
    for (std::uint64_t i = 0; i < 60; ++i) {
      const float x = i < 30 ? static_cast<float>(i * i) * 0.5f : 1.0f;
      const Cloud cloud = withoutIntensities(
          i > 30 && i % 3 == 0 ? randomCloud(i, -20.0, 20.0, 2000)
                               : surface(i, x, i % 5 == 0 ? 5 : 4000));
      stream.add(cloud, i % 7 == 0);
      ASSERT_TRUE(stream.values() == naiveCounts(cloud, resolution)) << "cloud " << i;
    }
  }
}

TEST(VoxelizerStreams, ADenseStreamMayTurnSparseWithinACloud)
{
  for (const IntensityUnit unit : {IntensityUnit::Points, IntensityUnit::Native}) {
    Stream stream(settingsOf(0.04), unit);
    for (std::uint64_t i = 0; i < 12; ++i) {
      Cloud cloud = withoutIntensities(surface(i, 1.0f, 3000));
      if (i % 3 == 2)
        for (const Point& point : withoutIntensities(randomCloud(i, -9.0, 9.0, 9000)))
          cloud.push_back(point);
      stream.add(cloud);
      const std::map<LatticeIndex, float> counts = naiveCounts(cloud, 0.04);
      ASSERT_TRUE(unit != IntensityUnit::Points || stream.values() == counts);
      ASSERT_EQ(stream.frame.size(), counts.size());
      for (const auto& voxel : stream.values())
        ASSERT_TRUE(unit == IntensityUnit::Points || voxel.second == 1.0f);
      EXPECT_EQ(stream.statistics.points_used, cloud.size());
    }
  }
}

TEST(VoxelizerStreams, ACloudMayTurnSparseAndThenLeaveTheGrid)
{
  for (const unsigned int threads : {1u, 3u}) {
    IntensityCompressionSettings settings = settingsOf(0.04);
    settings.threads = threads;
    Stream stream(settings);
    // Two dense surfaces 60 m apart make a wide grid, which the next cloud's last point
    // is outside of.
    Cloud dense = withoutIntensities(surface(1, 1.0f, 60000));
    for (const Point& point : withoutIntensities(surface(2, 60.0f, 60000)))
      dense.push_back(point);
    stream.add(dense);
    Cloud sparse = withoutIntensities(randomCloud(3, 2.0, 30.0, 100000));
    sparse.push_back({900.0f, 1.0f, 1.0f});
    stream.add(sparse);
    EXPECT_EQ(stream.statistics.points_used, sparse.size());
    EXPECT_TRUE(stream.values() == naiveCounts(sparse, 0.04)) << threads << " threads";
  }
}

TEST(VoxelizerStreams, SumsDoNotDependOnWhatWasBefore)
{
  for (const IntensityUnit unit : {IntensityUnit::Share, IntensityUnit::Native}) {
    Stream old_stream(settingsOf(0.04), unit);
    for (std::uint64_t i = 0; i < 20; ++i)
      old_stream.add(surface(i, 1.0f));
    Stream new_stream(settingsOf(0.04), unit);
    const Cloud cloud = surface(99, 1.01f);
    old_stream.add(cloud, true);
    new_stream.add(cloud, true);
    EXPECT_TRUE(old_stream.values() == new_stream.values());
  }
}

TEST(VoxelizerStreams, PointsWithoutIntensityAreWorthOne)
{
  for (const IntensityUnit unit :
       {IntensityUnit::Points, IntensityUnit::Share, IntensityUnit::Native})
    for (const Aggregation aggregation : {Aggregation::Sum, Aggregation::Mean}) {
      IntensityCompressionSettings settings = settingsOf(0.04);
      settings.aggregation = aggregation;
      Stream with(settings, unit);
      Voxelizer voxelizer(settings, unit);
      for (std::uint64_t i = 0; i < 3; ++i) {
        const Cloud cloud = withoutIntensities(surface(i, 1.0f));
        with.add(cloud);
        PointView view = viewOf(cloud);
        view.intensities = nullptr;
        VoxelFrame frame;
        const VoxelizationStatistics statistics =
            voxelizer.voxelize(view, false, frame);
        EXPECT_EQ(frame.keys, with.frame.keys);
        EXPECT_EQ(frame.intensities, with.frame.intensities);
        EXPECT_TRUE(frame.intensity_scale == with.frame.intensity_scale);
        EXPECT_EQ(statistics.intensities_out_of_range,
                  with.statistics.intensities_out_of_range);
      }
    }
}

TEST(VoxelizerStreams, NothingIsAllocatedOnceTheStreamRuns)
{
  std::vector<Cloud> clouds;
  for (std::uint64_t i = 0; i < 60; ++i)
    clouds.push_back(surface(i, 1.0f, 3000 + i * 37 % 200));
  for (const IntensityCurve curve : {IntensityCurve::Linear, IntensityCurve::Companded})
    for (const double resolution : {0.01, 0.04, 0.5})
      for (const IntensityUnit unit :
           {IntensityUnit::Points, IntensityUnit::Share, IntensityUnit::Native}) {
        IntensityCompressionSettings settings = settingsOf(resolution);
        settings.intensity_curve = curve;
        Voxelizer voxelizer(settings, unit);
        VoxelFrame frame;
        float sum = 0.0f;
        for (std::size_t i = 0; i < clouds.size(); ++i) {
          PointView view = viewOf(clouds[i]);
          if (unit == IntensityUnit::Points)
            view.intensities = nullptr;
          const MemoryUse memory_use;
          voxelizer.voxelize(view, i % 30 == 0, frame);
          forEachVoxelCentre(
              frame, [&](float, float, float, float intensity) { sum += intensity; });
          const std::size_t allocations = i < 30 ? 0 : memory_use.allocations();
          EXPECT_EQ(allocations, 0u) << "cloud " << i;
        }
        EXPECT_GT(sum, 0.0f);
      }
}

TEST(VoxelizerStreams, MemoryDependsOnThePointsNotOnTheGrid)
{
  // Each point is alone in its block, in a world of two thousand kilometres.
  std::mt19937_64 random(3);
  Cloud cloud(20000);
  for (Point& point : cloud)
    point = {uniform(random, -1e6, 1e6), uniform(random, -1e6, 1e6), 0.5f, 1.0f};
  Stream stream(settingsOf(1.0));
  const MemoryUse memory_use;
  for (int i = 0; i < 3; ++i)
    stream.add(cloud);
  EXPECT_EQ(stream.statistics.points_used, cloud.size());
  EXPECT_LT(memory_use.peak(), 300 * cloud.size());
}

} // namespace

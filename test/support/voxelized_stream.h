// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/point_view.h>

#include "support/float_values.h"
#include "support/voxel_frames.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

inline constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
using pcl_ext::test::infinity;
inline constexpr float largest = std::numeric_limits<float>::max();

struct Point {
  float x, y, z;
  float intensity = 1.0f;
};
using Cloud = std::vector<Point>;
using LatticeIndex = std::array<std::int64_t, 3>;

inline IntensityCompressionSettings
settingsOf(double resolution, StreamFormat format = StreamFormat::Version1)
{
  IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.format = format;
  return settings;
}

inline PointView
viewOf(const Cloud& cloud)
{
  PointView view;
  view.count = cloud.size();
  if (!cloud.empty()) {
    view.coordinates = &cloud[0].x;
    view.intensities = &cloud[0].intensity;
    view.coordinate_stride = view.intensity_stride = sizeof(Point);
  }
  return view;
}

class Stream {
public:
  explicit Stream(const IntensityCompressionSettings& settings,
                  IntensityUnit unit = IntensityUnit::Points)
  : voxelizer_(settings, unit)
  {}

  const VoxelFrame&
  add(const Cloud& cloud, bool may_shrink = false)
  {
    statistics = voxelizer_.voxelize(viewOf(cloud), may_shrink, frame);
    EXPECT_TRUE(isConsistent(frame));
    EXPECT_EQ(statistics.points, cloud.size());
    EXPECT_EQ(statistics.voxels, frame.size());
    EXPECT_EQ(statistics.points_used + statistics.points_not_finite +
                  statistics.points_outside_box + statistics.points_outside_grid,
              statistics.points);
    return frame;
  }

  /** \brief Decoded intensity by lattice index. */
  std::map<LatticeIndex, float>
  values() const
  {
    std::map<LatticeIndex, float> values;
    for (std::size_t i = 0; i < frame.size(); ++i)
      values[latticeIndex(frame, i)] =
          frame.intensity_scale.value(frame.intensities[i]);
    return values;
  }

  VoxelFrame frame;
  VoxelizationStatistics statistics;

private:
  Voxelizer voxelizer_;
};

inline std::map<LatticeIndex, std::vector<float>>
naiveVoxels(const Cloud& cloud, double resolution)
{
  std::map<LatticeIndex, std::vector<float>> voxels;
  for (const Point& point : cloud) {
    const auto index = [resolution](float coordinate) {
      return static_cast<std::int64_t>(std::floor(double{coordinate} / resolution));
    };
    voxels[{index(point.x), index(point.y), index(point.z)}].push_back(point.intensity);
  }
  return voxels;
}

/** \brief Points of each voxel, as a frame of counts shows them. */
inline std::map<LatticeIndex, float>
naiveCounts(const Cloud& cloud, double resolution)
{
  std::map<LatticeIndex, float> counts;
  for (const auto& voxel : naiveVoxels(cloud, resolution))
    counts[voxel.first] = static_cast<float>(voxel.second.size());
  return counts;
}

inline Cloud
withoutIntensities(Cloud cloud)
{
  for (Point& point : cloud)
    point.intensity = 1.0f;
  return cloud;
}

inline double
sumOf(const std::vector<float>& intensities)
{
  double sum = 0.0;
  for (const float intensity : intensities)
    sum += double{intensity};
  return sum;
}

inline Cloud
randomCloud(std::uint64_t seed, double low, double high, std::size_t count = 3000)
{
  std::mt19937_64 random(seed);
  Cloud cloud(count);
  for (Point& point : cloud)
    point = {uniform(random, low, high),
             uniform(random, low, high),
             uniform(random, low, high),
             uniform(random, 0.0, 0.3)};
  return cloud;
}

/** \brief One point a voxel, so that a voxel's value is the point's. */
inline Cloud
row(const std::vector<float>& intensities)
{
  Cloud cloud;
  for (const float intensity : intensities)
    cloud.push_back({0.5f + static_cast<float>(cloud.size()), 0.5f, 0.5f, intensity});
  return cloud;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test

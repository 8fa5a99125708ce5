// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Colours and numbers of points of voxels, against sums over a map of the
 * points.
 */
#include <pcl_ext/compression/point_view.h>

#include "support/voxel_frames.h"
#include "voxelizing/voxelizer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

struct ColouredPoint {
  float x, y, z;
  std::uint32_t rgba;
};

std::vector<ColouredPoint>
colouredPoints(std::size_t count, double width)
{
  std::mt19937_64 random(19);
  std::vector<ColouredPoint> points(count);
  for (ColouredPoint& point : points) {
    point.x = uniform(random, -width, width);
    point.y = uniform(random, -width, width);
    point.z = uniform(random, -width, width);
    point.rgba = static_cast<std::uint32_t>(random() >> 32);
  }
  return points;
}

PointView
viewOf(const std::vector<ColouredPoint>& points)
{
  PointView view;
  view.coordinates = &points[0].x;
  view.coordinate_stride = sizeof(ColouredPoint);
  view.colours = &points[0].rgba;
  view.colour_stride = sizeof(ColouredPoint);
  view.count = points.size();
  return view;
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
      sum[1 + channel] += point.rgba >> (16 - 8 * channel) & 0xff;
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

} // namespace

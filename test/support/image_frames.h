// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames whose points have the order of a sensor.
 */
#pragma once

#include "support/voxel_frames.h"
#include "voxels/rays.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace io {
namespace test {

/** \brief A camera in the corner of a grid, steps of depth as long as voxels. */
inline PointImage
planarImage(std::uint32_t width, std::uint32_t height)
{
  PointImage image;
  image.width = width;
  image.height = height;
  image.rays.pose.origin = {(20 << 16) + 12345, (25 << 16) + 54321, 3 << 16};
  image.rays.pose.vectors[0] = {
      -(std::int64_t{1} << 38), -(std::int64_t{3} << 37), std::int64_t{1} << 40};
  image.rays.pose.vectors[1] = {(std::int64_t{1} << 40) / width + 77, -99, 0};
  image.rays.pose.vectors[2] = {55, (std::int64_t{1} << 40) / height - 31, 0};
  return image;
}

/** \brief A lidar in the middle of a grid of 2^depth voxels, with half steps. */
inline PointImage
spinningImage(std::uint32_t width, std::uint32_t height, unsigned int depth)
{
  // Cosines and sines of whole turns / 2^k, units of 2^-30.
  constexpr std::array<std::array<std::int32_t, 2>, 8> directions = {
      {{1073741824, 0},
       {-1073741824, 0},
       {0, 1073741824},
       {759250125, 759250125},
       {992008094, 410903207},
       {1053110176, 209476638},
       {1068571464, 105245103},
       {1072448455, 52686014}}};
  PointImage image;
  image.width = width;
  image.height = height;
  RayModel& rays = image.rays;
  rays.shape = RayShape::Spinning;
  rays.has_half_steps = true;
  rays.pose.origin.fill(std::int64_t{1} << (depth - 1 + 16));
  rays.pose.vectors = {{{0, 1 << 30, 0}, {-(1 << 30), 0, 3}, {1, -2, 1 << 30}}};
  const unsigned int bits = columnBits(width);
  for (unsigned int bit = 0; bit < bits; ++bit)
    rays.turns.push_back(directions[std::min<std::size_t>(bits - bit, 7)]);
  for (std::uint32_t i = 0; i < height; ++i) {
    RayRow row;
    row.cosine = directions[5 + i % 3][0];
    row.sine = directions[5 + i % 3][1] * (i % 2 == 0 ? 1 : -1);
    row.run = (1 << 24) - static_cast<std::int32_t>(1000 * i);
    row.rise = (static_cast<std::int32_t>(i) - static_cast<std::int32_t>(height) / 2) *
               (1 << 20);
    row.along = static_cast<std::int32_t>(i) * 100;
    row.across = 40000 - static_cast<std::int32_t>(i);
    row.up = -70000;
    rays.rows.push_back(row);
  }
  return image;
}

/** \brief How points of an image are made. */
struct ImagePoints {
  std::uint32_t nearest = 40;   ///< depth
  std::uint64_t noise = 3;      ///< of depths, steps
  std::uint64_t misses = 20;    ///< every how manieth voxel is not on its ray
  std::uint64_t miss_width = 3; ///< voxels
  std::uint64_t holes = 12;     ///< every how manieth pixel has no point
};

/** \brief A frame of the points of an image: planes, edges and holes, those on the grid
 * only. It has neither intensities nor fields. */
inline VoxelFrame
imageFrame(std::mt19937_64& random,
           const PointImage& image,
           unsigned int grid_depth,
           const ImagePoints& points = {})
{
  VoxelFrame frame = emptyFrame(grid_depth, 0);
  frame.has_point_counts = true;
  frame.image = image;
  struct Pixel {
    std::uint64_t key;
    std::uint32_t pixel;
    std::uint32_t depth;
  };
  std::vector<Pixel> all;
  RayReader reader(image);
  for (std::uint32_t pixel = 0; pixel < image.pixelCount(); ++pixel) {
    const std::uint32_t row = pixel / image.width;
    const std::uint32_t column = pixel % image.width;
    if ((row / 5 + column / 9) % 7 == 3 || below(random, points.holes) == 0)
      continue;
    const std::uint32_t depth = points.nearest + column / 3 + row / 2 +
                                (column > image.width / 2 ? 11 : 0) +
                                static_cast<std::uint32_t>(below(random, points.noise));
    reader.moveTo(row);
    const Ray ray = reader.at(column);
    std::array<std::int64_t, 3> voxel{};
    const bool is_missed = below(random, points.misses) == 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      voxel[axis] = ray.at(depth, axis) >> 32;
      if (is_missed)
        voxel[axis] += static_cast<std::int64_t>(below(random, points.miss_width)) -
                       static_cast<std::int64_t>(points.miss_width / 2);
    }
    const auto is_inside = [&](std::int64_t position) {
      return position >= 0 && position < frame.grid.size();
    };
    if (std::all_of(voxel.begin(), voxel.end(), is_inside))
      all.push_back({mortonKey({static_cast<std::uint32_t>(voxel[0]),
                                static_cast<std::uint32_t>(voxel[1]),
                                static_cast<std::uint32_t>(voxel[2])}),
                     pixel,
                     depth});
  }
  std::stable_sort(all.begin(), all.end(), [](const Pixel& one, const Pixel& other) {
    return one.key < other.key;
  });
  for (const Pixel& point : all) {
    if (frame.keys.empty() || frame.keys.back() != point.key) {
      frame.keys.push_back(point.key);
      frame.point_counts.push_back(0);
    }
    ++frame.point_counts.back();
    frame.image.pixels.push_back(point.pixel);
    frame.image.depths.push_back(point.depth);
  }
  return frame;
}

/** \brief Adds points in the voxel of the sensor, which has none yet, to pixels that have
 * none. */
inline void
addPointsAtSensor(std::mt19937_64& random, VoxelFrame& frame)
{
  PointImage& image = frame.image;
  const std::array<std::int64_t, 3> voxel = sensorVoxel(image.rays.pose);
  const std::uint64_t key = mortonKey({static_cast<std::uint32_t>(voxel[0]),
                                       static_cast<std::uint32_t>(voxel[1]),
                                       static_cast<std::uint32_t>(voxel[2])});
  std::vector<std::uint32_t> pixels;
  for (std::uint32_t pixel = 0; pixel < image.pixelCount(); ++pixel)
    if (std::find(image.pixels.begin(), image.pixels.end(), pixel) ==
            image.pixels.end() &&
        below(random, 5) > 0)
      pixels.push_back(pixel);
  const auto place = std::lower_bound(frame.keys.begin(), frame.keys.end(), key);
  const auto at = place - frame.keys.begin();
  const std::ptrdiff_t point =
      std::accumulate(frame.point_counts.begin(), frame.point_counts.begin() + at, 0);
  frame.keys.insert(place, key);
  frame.point_counts.insert(frame.point_counts.begin() + at,
                            static_cast<std::uint32_t>(pixels.size()));
  image.depths.insert(image.depths.begin() + point, pixels.size(), 0);
  image.pixels.insert(image.pixels.begin() + point, pixels.begin(), pixels.end());
}

} // namespace test
} // namespace io
} // namespace pcl_ext

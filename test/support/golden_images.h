// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Golden streams of points in the order of their sensor.
 */
#pragma once

#include "support/golden_fields.h"
#include "support/golden_stream.h"
#include "support/image_frames.h"
#include "support/supplement_frames.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>

namespace pcl_ext {
namespace io {
namespace test {

/** \brief Fields of a spinning sensor: a row, a column, a noisy one and one of three
 * values. */
inline void
addImageFields(std::mt19937_64& random, VoxelFrame& frame)
{
  using Position = std::array<std::int64_t, 3>;
  frame.fields.clear();
  std::size_t point = 0;
  addField({"ring", FieldType::UInt8}, frame, [&](const Position&, std::size_t) {
    return std::uint64_t{frame.image.pixels[point++] / frame.image.width};
  });
  point = 0;
  addField({"time", FieldType::Float64}, frame, [&](const Position&, std::size_t) {
    return bitsOf(5.0 + frame.image.pixels[point++] % frame.image.width / 1024.0);
  });
  addField({"label", FieldType::UInt32}, frame, [&](const Position& at, std::size_t) {
    return static_cast<std::uint64_t>(1000003 * (at[0] / 16)) + below(random, 9) / 8;
  });
  addField({"normal", FieldType::Float32, 3, 0.015625},
           frame,
           [&](const Position& at, std::size_t i) {
             return bitsOf(static_cast<float>(at[i % 3]) / 64);
           });
}

/** \brief Depth images of a camera and of a spinning sensor: alone, with fields, with
 * intensities and colours, and with voxels far from their rays. */
inline GoldenStream
goldenImages(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 5, {}};
  std::mt19937_64 random(71);
  const PointImage camera = planarImage(48, 32);
  for (int i = 0; i < 7; ++i) {
    VoxelFrame frame = imageFrame(random, camera, 8);
    if (i == 2) // nothing is seen
      clearVoxels(frame);
    stream.frames.push_back({frame, std::nullopt});
  }
  const PointImage lidar = spinningImage(100, 16, 9);
  for (int i = 0; i < 4; ++i) {
    VoxelFrame frame = imageFrame(random, lidar, 9, {90, 5, 30, 3, i == 1 ? 3u : 25u});
    addImageFields(random, frame);
    stream.frames.push_back({frame, std::nullopt});
  }
  for (int i = 0; i < 3; ++i) {
    VoxelFrame frame = imageFrame(random, lidar, 9, {60, 2, 40, 3, 40});
    frame.intensity_scale.bits = 6;
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
      frame.intensities.push_back(static_cast<std::uint16_t>(20 + below(random, 4)));
    addColours(random, 6, frame);
    frame.viewpoint = {1, -2, 3};
    addField({"gain", FieldType::Int16},
             frame,
             [&](const std::array<std::int64_t, 3>& at, std::size_t) {
               return static_cast<std::uint64_t>(at[2] / 8 - 20);
             });
    stream.frames.push_back({frame, std::nullopt});
  }
  // Depths of many small steps, voxels all over around their rays.
  PointImage fine = planarImage(70, 20);
  for (auto& vector : fine.rays.pose.vectors)
    for (std::int64_t& element : vector)
      element /= 8;
  fine.rays.has_half_steps = true;
  for (int i = 0; i < 3; ++i)
    stream.frames.push_back(
        {imageFrame(
             random, fine, 10, {4000, 300, i == 2 ? 2u : 6u, i == 2 ? 400u : 5u, 30}),
         std::nullopt});
  return stream;
}

/** \brief Depth images of sensors that move, with rays and depths at the ends of their
 * ranges, sides of all lengths, and of clouds without rows and columns. */
inline GoldenStream
goldenMovingImages(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 9, {}};
  std::mt19937_64 random(73);
  const auto add = [&](const PointImage& image,
                       unsigned int grid_depth,
                       const ImagePoints& points) -> VoxelFrame& {
    stream.frames.push_back(
        {imageFrame(random, image, grid_depth, points), std::nullopt});
    return stream.frames.back().frame;
  };
  PointImage camera = planarImage(40, 24);
  for (int i = 0; i < 8; ++i) {
    camera.rays.pose.origin[0] += i < 5 ? 30000 : 0;
    camera.rays.pose.vectors[2][0] -= i % 2 == 0 ? std::int64_t{1} << 32 : 0;
    VoxelFrame& frame = add(camera, 8, {40, 2, 20, 3, 30});
    if (i == 3)
      clearVoxels(frame);
  }
  PointImage lidar = spinningImage(60, 6, 21);
  lidar.is_organised = false;
  lidar.rays.has_half_steps = false;
  for (RayRow& row : lidar.rays.rows) {
    row.run /= 5;
    row.rise /= 5;
  }
  for (int i = 0; i < 4; ++i) {
    lidar.rays.pose.vectors[0][2] += 1000 * (i / 2);
    addImageFields(random, add(lidar, 21, {depth_end - 5000, i == 1 ? 4900u : 2u}));
  }
  // Points at the sensor, on which none of the rays is.
  camera.has_points_at_sensor = true;
  camera.rays.pose.origin[2] = 5 << 16;
  for (int i = 0; i < 4; ++i) {
    VoxelFrame& frame = add(camera, 8, {40, 2, 20, 3, 30});
    addPointsAtSensor(random, frame);
    addImageFields(random, frame);
  }
  for (const auto& [width, height] :
       {std::pair<std::uint32_t, std::uint32_t>(9000, 1), {2, 4500}}) {
    PointImage image = planarImage(width, height);
    image.rays.pose.origin = {1 << 28, 1 << 28, 0};
    VoxelFrame& frame = add(image, 13, {40, 2, 200, 3, 2});
    addImageFields(random, frame);
    frame.fields.resize(2);
  }
  return stream;
}

} // namespace test
} // namespace io
} // namespace pcl_ext

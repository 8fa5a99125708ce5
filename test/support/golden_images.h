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
  for (auto& vector : fine.rays.plane)
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

} // namespace test
} // namespace io
} // namespace pcl_ext

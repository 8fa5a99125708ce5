// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames with colours, numbers of points and voxels that are alone. Made of
 * integers only, as golden streams are made of them.
 */
#pragma once

#include "support/voxel_frames.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

inline void
removeIntensities(VoxelFrame& frame)
{
  frame.intensity_scale = IntensityScale();
  frame.intensity_scale.bits = 0;
  frame.intensities.clear();
}

/** \brief Adds colours that change slowly over the grid, with some noise. */
inline void
addColours(std::mt19937_64& random, unsigned int bits, VoxelFrame& frame)
{
  frame.colour_bits = bits;
  frame.colours.clear();
  const std::int64_t highest = (std::int64_t{1} << bits) - 1;
  for (const std::uint64_t key : frame.keys) {
    const VoxelPosition at = voxelPosition(key);
    const auto channel = [&](std::uint32_t position) {
      const std::int64_t slope = highest * position / frame.grid.size();
      const auto noise = static_cast<std::int64_t>(below(random, 5)) - 2;
      return static_cast<std::uint8_t>(
          std::clamp(slope + noise, std::int64_t{0}, highest));
    };
    const std::uint8_t r = channel(at.x);
    const std::uint8_t g = channel(at.y);
    const std::uint8_t b = channel(at.z);
    frame.colours.push_back({r, g, b});
  }
}

/** \brief Adds numbers of points: most are small, some take all bits. */
inline void
addPointCounts(std::mt19937_64& random, VoxelFrame& frame)
{
  frame.has_point_counts = true;
  frame.point_counts.clear();
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const unsigned int bits = below(random, 20) == 0 ? 14 : 2;
    frame.point_counts.push_back(
        static_cast<std::uint32_t>(1 + below(random, std::uint64_t{1} << bits)));
  }
}

/** \brief Adds fields of the points, or without numbers of points of the voxels: one
 * that follows from the place, one of few numbers in a wide range, one of noise, and one
 * of three values. Voxels have few points then. */
inline void
addFields(std::mt19937_64& random, VoxelFrame& frame)
{
  for (std::uint32_t& count : frame.point_counts)
    count = 1 + count % 3;
  frame.fields.clear();
  frame.viewpoint = {-3, 5, 7};
  const auto add = [&](const char* name, FieldType type, double step, auto number_of) {
    FrameField& field = frame.fields.emplace_back();
    field.name = name;
    field.type = type;
    field.step = step;
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
      for (std::uint32_t i = 0;
           i < (frame.has_point_counts ? frame.point_counts[voxel] : 1);
           ++i)
        field.numbers.push_back(number_of(voxelPosition(frame.keys[voxel])));
  };
  add("ring", FieldType::UInt16, 0.0, [&](const VoxelPosition& at) {
    return at.z / 4 + below(random, 2);
  });
  add("time", FieldType::Float64, 0.0, [&](const VoxelPosition& at) {
    return (std::uint64_t{1} << 62) + 987654321 * (at.x % 8);
  });
  add("noise", FieldType::Float32, 0.01, [&](const VoxelPosition&) {
    return (std::uint64_t{1} << 52) + below(random, 100);
  });
  add("normal", FieldType::Int8, 0.0, [](const VoxelPosition& at) {
    return std::uint64_t{at.y % 256};
  });
  FrameField& normal = frame.fields.back();
  normal.count = 3;
  const std::vector<std::uint64_t> first = normal.numbers;
  normal.numbers.clear();
  for (const std::uint64_t number : first)
    normal.numbers.insert(normal.numbers.end(), {number, 128, 255 - number});
}

/** \brief A frame of some 1500 voxels in a deep grid, of which nearly none has a
 * sibling. */
inline VoxelFrame
fineFrame(std::mt19937_64& random, unsigned int bits)
{
  constexpr unsigned int depth = 17;
  VoxelFrame frame = emptyFrame(depth, bits == 0 ? 8 : bits);
  frame.grid.resolution = 0.0001;
  for (std::uint64_t cell = 0; cell < 120; ++cell) {
    // One cell in ten has many voxels, of which some fill a corner.
    const bool is_full = cell % 10 == 0;
    const std::uint64_t first = (cell * 7919 % 4096) << 21;
    for (int i = 0; i < (is_full ? 40 : 9); ++i)
      frame.keys.push_back(first + below(random, std::uint64_t{1} << 21));
    for (std::uint64_t i = 0; is_full && i < 6; ++i)
      frame.keys.push_back(first + i);
  }
  std::sort(frame.keys.begin(), frame.keys.end());
  frame.keys.erase(std::unique(frame.keys.begin(), frame.keys.end()), frame.keys.end());
  std::uint64_t symbol = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    symbol += below(random, 9) + (std::uint64_t{1} << bits) - 4;
    frame.intensities.push_back(
        static_cast<std::uint16_t>(symbol % (std::uint64_t{1} << bits)));
  }
  if (bits == 0)
    removeIntensities(frame);
  return frame;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test

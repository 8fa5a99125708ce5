// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/voxel_frames.h"
#include "voxels/point_voxels.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief What the points of a frame are like. */
struct PointContent {
  std::uint32_t width = 48;
  std::uint32_t height = 32;
  unsigned int depth = 4;          ///< of the grid: some voxels have several points
  unsigned int intensity_bits = 8; ///< 0: without
  unsigned int colour_bits = 5;    ///< 0: without
  bool has_fields = true;          ///< "index", where a point is, and "pair"
};

/** \brief A position in a random voxel of a grid, away from the voxel's faces. */
inline std::array<double, 3>
positionWithin(const VoxelGrid& grid, std::mt19937_64& random)
{
  std::array<double, 3> position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::uint64_t voxel = below(random, static_cast<std::uint64_t>(grid.size()));
    position[axis] =
        grid.origin[axis] +
        grid.resolution * (grid.first_index[axis] + static_cast<double>(voxel) +
                           static_cast<double>(uniform(random, 0.01, 0.99)));
  }
  return position;
}

/** \brief Gives the points of a frame random intensities and colours, if it has these,
 * and fields. */
inline void
setValues(std::mt19937_64& random, bool has_fields, VoxelFrame& frame)
{
  for (std::size_t i = 0; i < frame.points.indices.size(); ++i) {
    if (frame.hasIntensities())
      frame.points.intensities.push_back(static_cast<std::uint16_t>(
          below(random, std::uint64_t{1} << frame.intensity_scale.bits)));
    const auto channel = [&] {
      return static_cast<std::uint8_t>(
          below(random, std::uint64_t{1} << frame.colour_bits));
    };
    if (frame.colour_bits > 0)
      frame.points.colours.push_back({channel(), channel(), channel()});
  }
  if (!has_fields)
    return;
  FrameField index;
  index.name = "index";
  index.type = FieldType::UInt32;
  FrameField pair;
  pair.name = "pair";
  pair.type = FieldType::UInt16;
  pair.count = 2;
  for (const std::uint32_t point : frame.points.indices) {
    index.numbers.push_back(point);
    pair.numbers.push_back(below(random, 65536));
    pair.numbers.push_back(point % 65536);
  }
  frame.fields = {index, pair};
}

/** \brief A frame of points without voxels, as a decoder may return it: in rows and
 * columns every tenth is missing; with a height of 1 none is. */
inline VoxelFrame
frameOfPoints(std::mt19937_64& random, const PointContent& content = {})
{
  VoxelFrame frame = emptyFrame(content.depth, content.intensity_bits);
  frame.colour_bits = content.colour_bits;
  frame.has_point_counts = true;
  FramePoints& points = frame.points;
  points.width = content.width;
  points.height = content.height;
  for (std::uint32_t index = 0; index < points.cloudSize(); ++index) {
    if (points.height > 1 && below(random, 10) == 0)
      continue;
    points.indices.push_back(index);
    points.positions.push_back(positionWithin(frame.grid, random));
  }
  setValues(random, content.has_fields, frame);
  return frame;
}

inline VoxelFrame
pointFrame(std::mt19937_64& random, const PointContent& content = {})
{
  VoxelFrame frame = frameOfPoints(random, content);
  io::setVoxels(frame);
  EXPECT_TRUE(isConsistent(frame));
  return frame;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test

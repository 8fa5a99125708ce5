// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/published/frame_header.h"

#include "bytes/byte_writer.h"
#include "codec/frame_failures.h"
#include "codec/frame_limits.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

namespace {

// "minValue" in PCL's box arithmetic; a box is not enlarged by less.
constexpr double box_tolerance = 1.1920928955078125e-7;

/** \brief Reads the octree's box of an I-frame and converts it to a grid. */
CompressionStatus
readGrid(ByteSource& source, VoxelGrid& grid)
{
  grid.resolution = source.f64();
  std::array<double, 3> max;
  for (double& corner : grid.origin)
    corner = source.f64();
  for (double& corner : max)
    corner = source.f64();
  if (source.failure() != ByteSource::Failure::None)
    return failedRead(source, "a frame header");

  // The end of the lattice at the largest resolution.
  constexpr double largest_coordinate =
      largest_resolution * static_cast<double>(std::int64_t{1} << max_grid_depth);
  if (CompressionStatus status = checkResolution(grid.resolution); !status.ok())
    return status;
  const double side = max[0] - grid.origin[0];
  const double depth = std::round(std::log2(side / grid.resolution));
  if (!(depth >= 1.0 && depth <= static_cast<double>(max_grid_depth)))
    return corruptFrame("the box does not fit an octree of 1 to 21 levels");
  grid.depth = static_cast<unsigned int>(depth);
  grid.first_index = {0, 0, 0};
  // PCL keeps a box that is within its tolerance of the octree's cube at both ends; the
  // rounding of doubles of the box's size is added to that.
  const double cube = static_cast<double>(grid.size()) * grid.resolution;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double magnitude = std::max(std::abs(max[axis]), std::abs(grid.origin[axis]));
    if (!(magnitude < largest_coordinate) ||
        !(std::abs(max[axis] - grid.origin[axis] - cube) <=
          2.0 * box_tolerance + 1e-12 * magnitude))
      return corruptFrame("the box is not a cube of 2^depth voxels");
  }
  return {};
}

} // namespace

void
writeFrameHeader(const FrameHeader& header, std::vector<std::uint8_t>& bytes)
{
  ByteWriter writer(bytes);
  writer.raw(magic, magic_size);
  writer.u32(header.frame_number);
  writer.u8(header.is_i_frame ? 1 : 0);
  if (!header.is_i_frame)
    return;
  const VoxelGrid& grid = header.grid;
  writer.u64(header.voxel_count);
  writer.f64(grid.resolution);
  for (std::size_t axis = 0; axis < 3; ++axis)
    writer.f64(grid.lowerCorner(axis));
  for (std::size_t axis = 0; axis < 3; ++axis)
    writer.f64(grid.lowerCorner(axis) +
               static_cast<double>(grid.size()) * grid.resolution);
}

CompressionStatus
readFrameHeader(ByteSource& source, const DecoderLimits& limits, FrameHeader& header)
{
  header = FrameHeader();
  header.frame_number = source.u32();
  const std::uint8_t frame_type = source.u8();
  if (source.failure() == ByteSource::Failure::None && frame_type > 1)
    return corruptFrame("neither an I-frame nor a P-frame");
  header.is_i_frame = frame_type == 1;
  if (!header.is_i_frame)
    return {};
  header.voxel_count = source.u64();
  if (CompressionStatus status = readGrid(source, header.grid); !status.ok())
    return status;
  return checkVoxelCount(header.voxel_count, frameLimits(limits, 0).max_voxels);
}

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

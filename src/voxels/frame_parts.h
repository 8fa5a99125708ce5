// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Empties a frame, and gives it what all voxels of another one have in common:
 * grid, scale, depth model and bits of colours. */
inline void
beginLike(const VoxelFrame& other, VoxelFrame& frame)
{
  frame.clearVoxels();
  frame.grid = other.grid;
  frame.intensity_scale = other.intensity_scale;
  frame.depth_model = other.depth_model;
  frame.colour_bits = other.colour_bits;
  frame.has_point_counts = false;
  frame.fields.clear();
  frame.viewpoint = {};
}

/** \brief Sets a frame to the voxels of another one, without its numbers of points,
 * fields and points. */
inline void
copyVoxels(const VoxelFrame& from, VoxelFrame& frame)
{
  beginLike(from, frame);
  frame.keys = from.keys;
  frame.intensities = from.intensities;
  frame.colours = from.colours;
}

/** \brief Appends a voxel of a frame to one that is like it. */
inline void
appendVoxel(const VoxelFrame& from, std::size_t voxel, VoxelFrame& frame)
{
  frame.keys.push_back(from.keys[voxel]);
  if (from.hasIntensities())
    frame.intensities.push_back(from.intensities[voxel]);
  if (from.colour_bits > 0)
    frame.colours.push_back(from.colours[voxel]);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxel_grid.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

namespace pcl_ext::test {

/** \brief Intensity by index of a voxel about the world origin. */
using WorldVoxels = std::map<std::array<std::int64_t, 3>, double>;

/** \brief Adds a frame's intensities to the voxels of a lattice about the world origin
 * that hold the centres of its own; none of these may lie on a face. */
inline void
addVoxels(const io::VoxelFrame& frame, double resolution, WorldVoxels& voxels)
{
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const io::VoxelPosition position = io::voxelPosition(frame.keys[i]);
    const auto index = [&](std::size_t axis, std::uint32_t place) {
      // Clouds have centres as floats.
      const auto centre = static_cast<float>(frame.grid.centre(axis, place));
      return static_cast<std::int64_t>(
          std::floor(static_cast<double>(centre) / resolution));
    };
    voxels[{index(0, position.x), index(1, position.y), index(2, position.z)}] +=
        static_cast<double>(frame.intensity_scale.value(frame.intensities[i]));
  }
}

inline WorldVoxels
worldVoxels(const io::VoxelFrame& frame)
{
  WorldVoxels voxels;
  addVoxels(frame, frame.grid.resolution, voxels);
  return voxels;
}

} // namespace pcl_ext::test

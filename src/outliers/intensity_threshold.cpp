// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "voxels/intensity_symbols.h"
#include "voxels/keep_voxels.h"
#include "voxels/point_voxels.h"

namespace pcl_ext::PCL_EXT_ABI {

namespace {

/** \brief Moves the remaining voxels to the front. \return their number */
std::size_t
packVoxels(std::uint32_t lowest, io::VoxelFrame& frame)
{
  const std::size_t count = frame.size();
  std::uint64_t* const keys = frame.keys.data();
  std::uint16_t* const intensities = frame.intensities.data();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Written in any case, as a branch would be mispredicted.
    const std::uint16_t intensity = intensities[i];
    keys[kept] = keys[i];
    intensities[kept] = intensity;
    kept += intensity >= lowest ? 1 : 0;
  }
  return kept;
}

/** \brief True if voxels have more than intensities, for which packVoxels() is not. */
bool
hasMore(const io::VoxelFrame& frame)
{
  return frame.colour_bits > 0 || frame.has_point_counts || frame.points.areThere() ||
         !frame.fields.empty();
}

} // namespace

std::size_t
removeVoxelsBelow(io::VoxelFrame& frame, float min_intensity)
{
  if (!frame.hasIntensities())
    return 0;
  const std::uint32_t lowest = io::lowestSymbol(frame.intensity_scale, min_intensity);
  if (lowest == 0)
    return 0;
  io::setVoxels(frame);
  if (hasMore(frame))
    return io::keepVoxels(
        frame, [&](std::size_t i) { return frame.intensities[i] >= lowest; });
  const std::size_t kept = packVoxels(lowest, frame);
  const std::size_t removed = frame.size() - kept;
  frame.keys.resize(kept);
  frame.intensities.resize(kept);
  return removed;
}

} // namespace pcl_ext::PCL_EXT_ABI

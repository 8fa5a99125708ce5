// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "voxels/intensity_symbols.h"
#include "voxels/keep_voxels.h"
#include "voxels/point_voxels.h"

#include <algorithm>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

namespace {

/** \brief Copies the remaining voxels to the front of `to`, which may be `from`. It
 * needs space for one voxel more than remain, or for all.
 * \return number of remaining voxels */
std::size_t
packVoxels(const io::VoxelFrame& from, std::uint32_t lowest, io::VoxelFrame& to)
{
  const std::size_t count = from.size();
  const std::uint64_t* const keys = from.keys.data();
  const std::uint16_t* const intensities = from.intensities.data();
  std::uint64_t* const kept_keys = to.keys.data();
  std::uint16_t* const kept_intensities = to.intensities.data();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Written in any case, as a branch would be mispredicted.
    const std::uint16_t intensity = intensities[i];
    kept_keys[kept] = keys[i];
    kept_intensities[kept] = intensity;
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
  const std::size_t kept = packVoxels(frame, lowest, frame);
  const std::size_t removed = frame.size() - kept;
  frame.keys.resize(kept);
  frame.intensities.resize(kept);
  return removed;
}

std::size_t
removeVoxelsBelow(const io::VoxelFrame& frame,
                  float min_intensity,
                  io::VoxelFrame& kept)
{
  if (!frame.hasIntensities() || hasMore(frame)) {
    kept = frame;
    return removeVoxelsBelow(kept, min_intensity);
  }
  const std::uint32_t lowest = io::lowestSymbol(frame.intensity_scale, min_intensity);
  const auto count = static_cast<std::size_t>(
      std::count_if(frame.intensities.begin(),
                    frame.intensities.end(),
                    [lowest](std::uint16_t symbol) { return symbol >= lowest; }));
  kept.grid = frame.grid;
  kept.intensity_scale = frame.intensity_scale;
  kept.depth_model = frame.depth_model;
  kept.colour_bits = 0;
  kept.has_point_counts = false;
  kept.colours.clear();
  kept.point_counts.clear();
  kept.fields.clear();
  kept.points = io::FramePoints();
  // Counted first, so that no more memory is used than needed.
  kept.keys.resize(count + 1);
  kept.intensities.resize(count + 1);
  packVoxels(frame, lowest, kept);
  kept.keys.resize(count);
  kept.intensities.resize(count);
  return frame.size() - count;
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

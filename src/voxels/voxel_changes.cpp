// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_changes.h>

#include <algorithm>

namespace pcl_ext {
namespace io {

namespace {

/** \brief Gives a part of a frame what all its voxels have in common. */
void
beginPart(const VoxelFrame& frame, VoxelFrame& part)
{
  part.clearVoxels();
  part.grid = frame.grid;
  part.intensity_scale = frame.intensity_scale;
  part.depth_model = frame.depth_model;
  part.colour_bits = frame.colour_bits;
  part.has_point_counts = false;
  part.fields.clear();
  part.points = FramePoints();
}

void
append(const VoxelFrame& frame, std::size_t begin, std::size_t end, VoxelFrame& part)
{
  const auto appendTo = [&](auto& values, const auto& from) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(begin);
    values.insert(
        values.end(), first, first + static_cast<std::ptrdiff_t>(end - begin));
  };
  appendTo(part.keys, frame.keys);
  if (frame.hasIntensities())
    appendTo(part.intensities, frame.intensities);
  if (frame.colour_bits > 0)
    appendTo(part.colours, frame.colours);
}

bool
differs(const VoxelFrame& before, std::size_t i, const VoxelFrame& after, std::size_t j)
{
  return (before.hasIntensities() && before.intensities[i] != after.intensities[j]) ||
         (before.colour_bits > 0 && !(before.colours[i] == after.colours[j]));
}

} // namespace

void
findChanges(const VoxelFrame& before, const VoxelFrame& after, VoxelChanges& changes)
{
  beginPart(before, changes.gone);
  beginPart(after, changes.came);
  if (!changes.areOfOneGrid() || before.depth_model != after.depth_model) {
    append(before, 0, before.size(), changes.gone);
    append(after, 0, after.size(), changes.came);
    return;
  }
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < before.size() && j < after.size()) {
    const std::uint64_t was = before.keys[i];
    const std::uint64_t is = after.keys[j];
    if (was < is)
      append(before, i, i + 1, changes.gone);
    else if (is < was)
      append(after, j, j + 1, changes.came);
    else if (differs(before, i, after, j)) {
      append(before, i, i + 1, changes.gone);
      append(after, j, j + 1, changes.came);
    }
    i += was <= is ? 1 : 0;
    j += is <= was ? 1 : 0;
  }
  append(before, i, before.size(), changes.gone);
  append(after, j, after.size(), changes.came);
}

} // namespace io
} // namespace pcl_ext

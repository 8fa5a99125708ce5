// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_changes.h>

#include "voxels/frame_parts.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

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

} // namespace

void
findChanges(const VoxelFrame& before, const VoxelFrame& after, VoxelChanges& changes)
{
  changes.is_from_nothing = false;
  beginLike(before, changes.gone);
  beginLike(after, changes.came);
  if (!changes.areOfOneGrid() || before.depth_model != after.depth_model) {
    append(before, 0, before.size(), changes.gone);
    append(after, 0, after.size(), changes.came);
    return;
  }
  const std::uint64_t* const was = before.keys.data();
  const std::uint64_t* const is = after.keys.data();
  const auto is_same = [&, has_intensities = before.hasIntensities()](std::size_t i,
                                                                      std::size_t j) {
    return was[i] == is[j] &&
           (!has_intensities || before.intensities[i] == after.intensities[j]) &&
           (before.colour_bits == 0 || before.colours[i] == after.colours[j]);
  };
  // Between two voxels that stay as they are all are gone, or came.
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < before.size() || j < after.size()) {
    const std::size_t gone = i;
    const std::size_t came = j;
    while (i < before.size() && j < after.size() && !is_same(i, j)) {
      const std::uint64_t next = std::min(was[i], is[j]);
      i += was[i] == next ? 1 : 0;
      j += is[j] == next ? 1 : 0;
    }
    if (i == before.size() || j == after.size()) {
      i = before.size();
      j = after.size();
    }
    append(before, gone, i, changes.gone);
    append(after, came, j, changes.came);
    for (; i < before.size() && j < after.size() && is_same(i, j); ++i)
      ++j;
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sorted_voxels.h"

#include "bytes/reserve_ahead.h"
#include "voxels/radix_sort.h"

#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI::io {

void
SortedVoxels::begin(const SummedFields& fields, std::size_t expected)
{
  fields_ = fields;
  points_.clear();
  point_keys_.clear();
  if (keepsPoints())
    reserveAhead(points_, expected);
  else
    reserveAhead(point_keys_, expected);
}

void
SortedVoxels::add(const LocatedPoints& located)
{
  const auto key_of = [&](std::size_t i) {
    return mortonKey(BlockVoxel{located.blocks[i], located.voxels[i]});
  };
  // Written by index, as push_back takes longer than the rest.
  if (!keepsPoints()) {
    const std::size_t first = point_keys_.size();
    point_keys_.resize(first + located.count);
    std::uint64_t* const keys = point_keys_.data() + first;
    for (std::size_t i = 0; i < located.count; ++i)
      keys[i] = key_of(i);
    return;
  }
  const std::size_t first = points_.size();
  points_.resize(first + located.count);
  Point* const points = points_.data() + first;
  for (std::size_t i = 0; i < located.count; ++i)
    points[i] = {key_of(i),
                 fields_.intensities ? located.intensities[i] : 0.0f,
                 fields_.colours ? located.colours[i] : 0};
}

void
SortedVoxels::writeVoxels(std::vector<std::uint64_t>& keys, VoxelSums& sums)
{
  if (keepsPoints()) {
    radixSort(points_, spare_points_, usedBits(points_));
    writeSorted(points_, keys, sums);
  }
  else {
    radixSort(point_keys_, spare_keys_, usedBits(point_keys_));
    writeSorted(point_keys_, keys, sums);
  }
  points_.clear();
  point_keys_.clear();
}

template <typename EntryT>
void
SortedVoxels::writeSorted(const std::vector<EntryT>& sorted,
                          std::vector<std::uint64_t>& keys,
                          VoxelSums& sums)
{
  std::size_t voxels = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    voxels += i == 0 || keyOf(sorted[i]) != keyOf(sorted[i - 1]) ? 1 : 0;
  reserveAhead(keys, voxels);
  keys.resize(voxels);
  sums.resize(voxels, fields_);
  occupied_blocks_ = 0;
  std::size_t begun = 0; // voxels
  std::size_t first = 0; // point of the last one
  double intensity = 0.0;
  ColourSum colour;
  std::uint64_t last = sorted.empty() ? 0 : ~keyOf(sorted.front());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    // Without a branch, which would be mispredicted: written again at each point.
    const std::uint64_t key = keyOf(sorted[i]);
    const std::uint64_t difference = key ^ last;
    const bool begins = difference != 0;
    last = key;
    begun += begins ? 1 : 0;
    first = begins ? i : first;
    occupied_blocks_ += difference >> 6 != 0 ? 1 : 0;
    keys[begun - 1] = key;
    sums.counts[begun - 1] = static_cast<std::uint32_t>(i + 1 - first);
    if constexpr (std::is_same_v<EntryT, Point>) {
      if (fields_.intensities) {
        intensity = static_cast<double>(!begins) * intensity +
                    static_cast<double>(sorted[i].intensity);
        sums.intensities[begun - 1] = intensity;
      }
      if (fields_.colours) {
        colour = begins ? ColourSum() : colour;
        colour.add(sorted[i].colour);
        sums.colours[begun - 1] = colour;
      }
    }
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/supplement/coarse_voxels.h"

#include "simd/bit_operations.h"

#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

namespace {

std::size_t
countCoarseVoxels(const std::vector<std::uint64_t>& keys, unsigned int levels)
{
  const unsigned int shift = 3 * levels;
  std::size_t count = keys.empty() ? 0 : 1;
  for (std::size_t i = 1; i < keys.size(); ++i)
    count += isNotZero((keys[i] ^ keys[i - 1]) >> shift);
  return count;
}

} // namespace

unsigned int
chooseRefinement(const VoxelFrame& frame)
{
  constexpr std::size_t least_voxels = 1024;
  // The models of the coders learn what is not noise in so many voxels.
  constexpr std::size_t many_voxels = std::size_t{1} << 14;
  const std::size_t count = frame.size();
  const double largest_edge = count < many_voxels ? 0.005 : 0.0005;
  // On a surface that is sampled densely enough a branch has three or four voxels.
  if (frame.grid.resolution > largest_edge || count < least_voxels ||
      5 * countCoarseVoxels(frame.keys, 1) < 4 * count)
    return 0;
  // Smaller coarse voxels take fewer bytes, and more time where many levels are above
  // them.
  constexpr double smallest_edge_of_few_levels = 0.001;
  const std::size_t halves_of_voxels_in_a_coarse_one =
      frame.grid.resolution < smallest_edge_of_few_levels ? 8 : 3;
  unsigned int levels = 2;
  while (levels + 1 < frame.grid.depth &&
         halves_of_voxels_in_a_coarse_one * countCoarseVoxels(frame.keys, levels) >
             2 * count)
    ++levels;
  return levels < frame.grid.depth ? levels : 0;
}

void
coarseVoxelsOf(const std::vector<std::uint64_t>& keys,
               unsigned int levels,
               std::vector<std::uint64_t>& coarse_voxels)
{
  const unsigned int shift = 3 * levels;
  coarse_voxels.resize(keys.size());
  if (keys.empty())
    return;
  std::uint64_t last = keys.front() >> shift;
  coarse_voxels[0] = last;
  std::size_t count = 1;
  for (const std::uint64_t key : keys) {
    // Written in any case, and again if it is the same one, without a branch.
    const std::uint64_t coarse_voxel = key >> shift;
    count += coarse_voxel != last ? 1 : 0;
    coarse_voxels[count - 1] = coarse_voxel;
    last = coarse_voxel;
  }
  coarse_voxels.resize(count);
}

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io

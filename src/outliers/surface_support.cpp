// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/surface_support.h"

namespace pcl_ext::PCL_EXT_ABI {

Support
SurfaceSupport::of(std::uint64_t key,
                   std::uint64_t distance,
                   unsigned int additional) const
{
  const unsigned int level = levelAt(distance);
  const std::uint32_t mean = levels_[level].density.mean(distance);
  // A plane has 8 neighbours, of which its edges and corners have 5 and 3.
  const std::uint32_t least = mean < enough_neighbours ? 1 : 2;
  const std::uint32_t needed =
      std::clamp(mean * mean / (256 * 34), least, std::uint32_t{5}) + additional;
  const unsigned int count = levels_[level].occupied.count(key >> 3 * level, needed);
  if (count >= needed)
    return Support::Enough;
  return count > 0 || mean < lone_neighbours ? Support::Some : Support::None;
}

} // namespace pcl_ext::PCL_EXT_ABI

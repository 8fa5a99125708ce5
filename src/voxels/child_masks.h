// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Tables of the 256 masks of eight children: those of an octree node, the
 * octants of a block, or the cells of an octant. Bit c is child c = 4x + 2y + z. */
struct ChildMasks {
  std::array<std::uint8_t, 256> count{}; ///< number of children in a mask
  /** \brief The children in a mask, ascending, then zeros. */
  std::array<std::array<std::uint8_t, 8>, 256> children{};
};

constexpr ChildMasks
makeChildMasks()
{
  ChildMasks masks;
  for (unsigned int mask = 0; mask < 256; ++mask) {
    std::uint8_t& count = masks.count[mask];
    for (unsigned int child = 0; child < 8; ++child)
      if ((mask >> child & 1) != 0)
        masks.children[mask][count++] = static_cast<std::uint8_t>(child);
  }
  return masks;
}

inline constexpr ChildMasks child_masks = makeChildMasks();

} // namespace pcl_ext::PCL_EXT_ABI::io

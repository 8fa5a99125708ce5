// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The lowest symbol with an intensity of at least min_intensity; maxSymbol() +
 * 1 if there is none. Intensities do not decrease with the symbol. */
inline std::uint32_t
lowestSymbol(const IntensityScale& scale, float min_intensity)
{
  std::uint32_t low = 0;
  std::uint32_t high = scale.maxSymbol() + 1;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (scale.value(static_cast<std::uint16_t>(middle)) < min_intensity)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

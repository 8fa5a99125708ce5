// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Numbers of points as symbols, which are coded as those of intensities are.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Bits of a symbol, which is the number of points itself. What a number has
 * beyond the highest symbol is coded after the symbols. */
constexpr unsigned int point_symbol_bits = 12;
constexpr std::uint32_t highest_point_symbol = (1u << point_symbol_bits) - 1;
constexpr std::uint32_t most_points = std::numeric_limits<std::uint32_t>::max();

/** \brief Bits of the symbols that a coder codes first, after the voxels: those of
 * intensities, or without these those of numbers of points; 0 without either. */
inline unsigned int
firstSymbolBits(const VoxelFrame& frame)
{
  return frame.hasIntensities()   ? frame.intensity_scale.bits
         : frame.has_point_counts ? point_symbol_bits
                                  : 0;
}

/** \brief Whether numbers of points are coded after intensities. */
inline bool
hasPointsBesideIntensities(const VoxelFrame& frame)
{
  return frame.hasIntensities() && frame.has_point_counts;
}

/** \brief The symbols of numbers of points. */
inline void
pointSymbolsOf(const std::vector<std::uint32_t>& counts,
               std::vector<std::uint16_t>& symbols)
{
  symbols.resize(counts.size());
  std::transform(
      counts.begin(), counts.end(), symbols.begin(), [](std::uint32_t count) {
        return static_cast<std::uint16_t>(std::min(count, highest_point_symbol));
      });
}

} // namespace pcl_ext::PCL_EXT_ABI::io

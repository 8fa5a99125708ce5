// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxelizing/robust_fit.h"

#include <cmath>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The fraction of an edge that whole edges are to be added to, so that numbers
 * rounded to the nearest of these are off by as much above as below. Numbers on a grid of
 * an edge, or of a part of one, would be on ties between two of them otherwise.
 * \param[in] numbers edges
 * \return 0 to below 1; of several the one nearest to 1/2
 */
inline double
coordinatePhase(const std::vector<double>& numbers)
{
  constexpr double middle = 0.5;
  constexpr int most_parts = 10; // of more, ties are few
  for (int parts = 1; parts <= most_parts; ++parts) {
    const double part = 1.0 / parts;
    double offset = 0.0;
    if (!(coherence(numbers, part, offset) > 0.99)) // also if it is no number
      continue;
    // Amid two numbers, where they would be ties else.
    const double phase = parts % 2 == 0 ? offset + part / 2.0 : offset;
    const double nearest = phase + std::round((middle - phase) / part) * part;
    return nearest - std::floor(nearest);
  }
  return middle;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

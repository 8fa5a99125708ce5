// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "simd/lanes_target.h"

#include <cstddef>

namespace pcl_ext {

/** \brief Reads x, y and z of a point a lane; four floats are read of each.
 * \param[in] points x of the first; need not be aligned
 * \param[in] stride bytes from one x to the next
 * \param[out] x,y,z one lane a point
 */
template <typename LanesT>
PCL_EXT_LANES_TARGET void
loadPoints(const unsigned char* points,
           std::size_t stride,
           typename LanesT::Floats& x,
           typename LanesT::Floats& y,
           typename LanesT::Floats& z)
{
  typename LanesT::Floats w;
  if constexpr (LanesT::width == 8) {
    const unsigned char* const last_points = points + 4 * stride;
    x = LanesT::loadPoints(points, last_points);
    y = LanesT::loadPoints(points + stride, last_points + stride);
    z = LanesT::loadPoints(points + 2 * stride, last_points + 2 * stride);
    w = LanesT::loadPoints(points + 3 * stride, last_points + 3 * stride);
  }
  else {
    x = LanesT::loadPoint(points);
    y = LanesT::loadPoint(points + stride);
    z = LanesT::loadPoint(points + 2 * stride);
    w = LanesT::loadPoint(points + 3 * stride);
  }
  LanesT::transpose(x, y, z, w);
}

} // namespace pcl_ext

/** \file
 * \brief Lanes with the vector instructions that every machine of the architecture has.
 *
 * Not to be included together with PCL: Eigen's types may have another layout with other
 * instructions than PCL was compiled with.
 */
#pragma once

#include "simd/scalar_lanes.h"

#if defined(__SSE2__)
#include "simd/sse2_lanes.h"
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
#include "simd/neon_lanes.h"
#endif

namespace pcl_ext {

#if defined(__SSE2__)
using NativeLanes = Sse2Lanes;
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
using NativeLanes = NeonLanes;
#else
using NativeLanes = ScalarLanes;
#endif

/** \brief Reads x, y and z of four points; four floats are read of each.
 * \param[in] points x of the first; need not be aligned
 * \param[in] stride bytes from one x to the next
 * \param[out] x,y,z one lane a point
 */
template <typename LanesT>
void
loadPoints(const unsigned char* points,
           std::size_t stride,
           typename LanesT::Floats& x,
           typename LanesT::Floats& y,
           typename LanesT::Floats& z)
{
  x = LanesT::loadPoint(points);
  y = LanesT::loadPoint(points + stride);
  z = LanesT::loadPoint(points + 2 * stride);
  typename LanesT::Floats w = LanesT::loadPoint(points + 3 * stride);
  LanesT::transpose(x, y, z, w);
}

} // namespace pcl_ext

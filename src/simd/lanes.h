/** \file
 * \brief The vector instructions that every machine of this architecture has.
 *
 * Include it only where PCL is not: what is compiled with other instructions than PCL
 * was may lay out Eigen's types in another way.
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

} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Lanes with the vector instructions that every machine of the architecture has.
 *
 * Not to be included together with PCL: Eigen's types may have another layout with
 * other instructions than PCL was compiled with.
 */
#pragma once

#include <pcl_ext/version.h>

#include "simd/scalar_lanes.h"

// PCL_EXT_HAS_NATIVE_LANES: NativeLanes are not ScalarLanes.
#if defined(__SSE2__)
#define PCL_EXT_HAS_NATIVE_LANES 1
#include "simd/sse2_lanes.h"
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
#define PCL_EXT_HAS_NATIVE_LANES 1
#include "simd/neon_lanes.h"
#else
#define PCL_EXT_HAS_NATIVE_LANES 0
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

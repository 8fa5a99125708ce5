// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#define PCL_EXT_TARGETS_AVX2

#include "filters/moved_points.h"

#if PCL_EXT_HAS_AVX2
#include "filters/point_mover.h"
#include "simd/avx2_lanes.h"

namespace pcl_ext::PCL_EXT_ABI::detail {

template void
movePointsWith<Avx2Lanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);

} // namespace pcl_ext::PCL_EXT_ABI::detail
#endif

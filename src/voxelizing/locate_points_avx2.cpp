// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#define PCL_EXT_TARGETS_AVX2

#include "voxelizing/locate_points.h"

#if PCL_EXT_HAS_AVX2
#include "simd/avx2_lanes.h"
#include "voxelizing/point_locator.h"

namespace pcl_ext::PCL_EXT_ABI::io {

template void
locatePointsWith<Avx2Lanes>(const LocatorGrid&,
                            const LocatorInput&,
                            LocatedPoints&,
                            CertainPoints&);

} // namespace pcl_ext::PCL_EXT_ABI::io
#endif

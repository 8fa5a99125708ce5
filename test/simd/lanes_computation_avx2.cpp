// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#define PCL_EXT_TARGETS_AVX2

#include "simd/lanes_computation.h"

#if PCL_EXT_HAS_AVX2
#include "simd/avx2_lanes.h"

namespace pcl_ext::test {

LanesResult
computeWithAvx2(const LanesInput& input)
{
  return computeWithLanes<Avx2Lanes>(input);
}

} // namespace pcl_ext::test
#endif

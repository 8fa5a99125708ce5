// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "filters/moved_points.h"

#include "filters/point_mover.h"

namespace pcl_ext::PCL_EXT_ABI::detail {

template void
movePointsWith<ScalarLanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#if PCL_EXT_HAS_NATIVE_LANES
template void
movePointsWith<NativeLanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#endif

void
movePoints(const PointBytes& points,
           const PointMove& move,
           float* output,
           MovedPoints& moved)
{
#if PCL_EXT_HAS_AVX2
  if (usesAvx2())
    return movePointsWith<Avx2Lanes>(points, move, output, moved);
#endif
  movePointsWith<NativeLanes>(points, move, output, moved);
}

} // namespace pcl_ext::PCL_EXT_ABI::detail

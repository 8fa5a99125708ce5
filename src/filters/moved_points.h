// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/filters/impl/moved_points.hpp>

#include "simd/lanes.h"
#include "simd/vector_choice.h"

namespace pcl_ext::PCL_EXT_ABI::detail {

/** \brief detail::movePoints with any kind of lanes. */
template <typename LanesT>
void
movePointsWith(const PointBytes& points,
               const PointMove& move,
               float* output,
               MovedPoints& moved);

// Compiled in files that are compiled without contraction of products and sums, so
// that all machines compute the same.
#if PCL_EXT_HAS_AVX2
extern template void
movePointsWith<Avx2Lanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#endif

} // namespace pcl_ext::PCL_EXT_ABI::detail

#pragma once

#include <pcl_ext/filters/impl/moved_points.hpp>

#include "simd/lanes.h"

namespace pcl_ext {
namespace detail {

/** \brief detail::movePoints with any kind of lanes. */
template <typename LanesT>
void
movePointsWith(const PointBytes& points,
               const PointMove& move,
               float* output,
               MovedPoints& moved);

// Instantiated in a file that is compiled without contraction of products and sums, so
// that all machines compute the same.
extern template void
movePointsWith<ScalarLanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#if defined(__SSE2__) || (defined(__aarch64__) && !defined(__AARCH64EB__))
extern template void
movePointsWith<NativeLanes>(const PointBytes&, const PointMove&, float*, MovedPoints&);
#endif

} // namespace detail
} // namespace pcl_ext

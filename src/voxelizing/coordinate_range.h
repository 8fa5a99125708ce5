// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>

#include "simd/bit_operations.h"
#include "simd/lanes.h"
#include "voxelizing/locate_points.h"

#include <array>
#include <cstddef>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The lowest and the highest float coordinates of the points of a usable
 * range. */
class CoordinateRange {
public:
  /** \param[in] usable_min,usable_max ends of the range, both included */
  CoordinateRange(const std::array<float, 3>& usable_min,
                  const std::array<float, 3>& usable_max)
  : usable_min_(lanesOf(usable_min))
  , usable_max_(lanesOf(usable_max))
  , lowest_(usable_max_)
  , highest_(usable_min_)
  {}

  /** \brief Adds those of some points that are in the usable range. */
  void
  add(const PointView& points)
  {
    const auto* const bytes =
        reinterpret_cast<const unsigned char*>(points.coordinates);
    const std::size_t stride = points.coordinate_stride;
    for (std::size_t i = 0; i + 1 < points.count; ++i) {
      prefetch(bytes + i * stride + prefetch_distance);
      addPoint(bytes + i * stride);
    }
    // A float after z is read, which the last point may not have.
    if (points.count > 0) {
      std::array<float, 4> last{};
      std::memcpy(last.data(), bytes + (points.count - 1) * stride, 3 * sizeof(float));
      addPoint(reinterpret_cast<const unsigned char*>(last.data()));
    }
  }

  bool
  isAny() const
  {
    return is_any_;
  }

  std::array<float, 4>
  lowest() const
  {
    return arrayOf(lowest_);
  }

  std::array<float, 4>
  highest() const
  {
    return arrayOf(highest_);
  }

private:
  using Floats = NativeLanes::Floats;

  void
  addPoint(const unsigned char* point)
  {
    const auto coordinates = NativeLanes::loadPoint(point);
    const unsigned int usable = NativeLanes::bitsOf(
        NativeLanes::bitAnd(NativeLanes::lessOrEqual(usable_min_, coordinates),
                            NativeLanes::lessOrEqual(coordinates, usable_max_)));
    if ((usable & 7) != 7) // NaN is not
      return;
    is_any_ = true;
    lowest_ = NativeLanes::minimum(lowest_, coordinates);
    highest_ = NativeLanes::maximum(highest_, coordinates);
  }

  static Floats
  lanesOf(const std::array<float, 3>& point)
  {
    const std::array<float, 4> lanes{point[0], point[1], point[2], 0.0f};
    return NativeLanes::loadPoint(reinterpret_cast<const unsigned char*>(lanes.data()));
  }

  static std::array<float, 4>
  arrayOf(const Floats& lanes)
  {
    std::array<float, 4> array;
    NativeLanes::store(lanes, array.data());
    return array;
  }

  // The fourth lane is not used.
  Floats usable_min_;
  Floats usable_max_;
  Floats lowest_;
  Floats highest_;
  bool is_any_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The lowest float that is not below a double. */
inline float
lowestFloatFrom(double number)
{
  constexpr float infinity = std::numeric_limits<float>::infinity();
  // Casting a double outside the range of float is undefined.
  if (number > static_cast<double>(std::numeric_limits<float>::max()))
    return infinity;
  if (number < static_cast<double>(std::numeric_limits<float>::lowest()))
    return std::numeric_limits<float>::lowest();
  const auto nearest = static_cast<float>(number);
  return static_cast<double>(nearest) < number ? std::nextafter(nearest, infinity)
                                               : nearest;
}

/** \brief The lowest and the highest finite floats that are in a box. */
struct BoxOfFloats {
  std::array<float, 3> min;
  std::array<float, 3> max;

  explicit BoxOfFloats(const BoundingBox& box)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      min[axis] = lowestFloatFrom(box.min[axis]);
      max[axis] = -lowestFloatFrom(-box.max[axis]);
    }
  }
};

} // namespace pcl_ext::PCL_EXT_ABI::io

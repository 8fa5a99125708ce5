// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::detail {

/** \brief The float that is nearest to a number: beyond the range of float its highest
 * or lowest finite number, for which a cast alone is undefined. NaN stays NaN. */
inline float
saturatedFloat(double number)
{
  // In brackets, as windows.h has a macro of that name.
  constexpr double largest = (std::numeric_limits<float>::max)();
  return static_cast<float>(std::clamp(number, -largest, largest));
}

} // namespace pcl_ext::PCL_EXT_ABI::detail

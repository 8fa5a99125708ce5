// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The highest number of a scale of 8 bits, and of one of 16. */
constexpr double highest_of_default_bits = 255.0;
constexpr double highest_number = 65535.0;

/** \brief The lowest and the highest of some values. */
struct ValueRange {
  double lowest = 0.0;
  double highest = 0.0;
};

/** \brief The smallest power of two that is not below a value; 1 for 0. */
double
powerOfTwoAbove(double value);

/** \brief The lowest value of an automatic scale: 0, or a negative power of two.
 * \param[in] lowest value to hold
 * \param[in] divisor the scale has steps of 1 / divisor, and so has the power of two;
 *   0: there is no such step
 */
double
automaticOffset(double lowest, unsigned int divisor);

/** \brief The range of all values, of which there is one or more. */
ValueRange
rangeOf(const std::vector<double>& values);

/** \brief Finds the range of the values that an automatic scale holds: all of them but
 * few that are far from the others.
 *
 * Few are at most one in 256 at each end. The rest are the others, and 0, which every
 * scale holds; its width is from the lowest to the highest of these. Far below is more
 * than 16 times the width below the rest, far above more than 16 times above its lowest.
 * Where the scale keeps its step, far below is also more than 16 times 255 steps, and far
 * above are only numbers of more than 16 bits, as they cost hardly any bytes.
 *
 * \param[in] values voxel intensities, finite, one or more
 * \param[in] divisor the scale keeps steps of 1 / divisor as far as 16 bits suffice; 0:
 *   its steps grow with the range
 * \param[in] lowest_before what the scale holds already
 * \param[out] sorted values in another order, if needed; kept by the caller so that its
 *   memory is reused
 * \return the lowest and the highest of the held values
 */
ValueRange
heldRange(const std::vector<double>& values,
          unsigned int divisor,
          double lowest_before,
          std::vector<double>& sorted);

} // namespace pcl_ext::PCL_EXT_ABI::io

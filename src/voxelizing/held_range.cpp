// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/held_range.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::size_t values_for_one_outlier = 256;
constexpr double far_ratio = 16.0;

/** \brief The highest value that a scale with a step holds. */
double
highestExact(double lowest, unsigned int divisor)
{
  return automaticOffset(lowest, divisor) + highest_number / divisor;
}

/** \brief The values without the lowest and the highest few, and 0. */
ValueRange
rangeOfRest(const std::vector<double>& values, std::vector<double>& sorted)
{
  const std::size_t few = values.size() / values_for_one_outlier;
  sorted.assign(values.begin(), values.end());
  const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(few);
  std::nth_element(sorted.begin(), at, sorted.end());
  const double lowest = *at; // which the next call moves
  const auto highest = sorted.end() - 1 - static_cast<std::ptrdiff_t>(few);
  std::nth_element(at, highest, sorted.end());
  return {std::min(lowest, 0.0), std::max(*highest, 0.0)};
}

/** \brief True if it is certain without sorting that no value is far from the rest. */
bool
areAllNear(const std::vector<double>& values,
           const ValueRange& all,
           unsigned int divisor,
           double lowest_before)
{
  const std::size_t few = values.size() / values_for_one_outlier;
  if (few == 0)
    return true;
  if (all.lowest < 0.0)
    return false;
  if (divisor != 0)
    return all.highest <= highestExact(lowest_before, divisor);
  const double near = all.highest / far_ratio;
  return std::count_if(values.begin(), values.end(), [near](double value) {
           return value >= near;
         }) > static_cast<std::ptrdiff_t>(few);
}

} // namespace

double
powerOfTwoAbove(double value)
{
  return value > 0.0 ? std::exp2(std::ceil(std::log2(value))) : 1.0;
}

double
automaticOffset(double lowest, unsigned int divisor)
{
  if (lowest >= 0.0)
    return 0.0;
  return divisor != 0 ? -powerOfTwoAbove(std::max(-lowest * divisor, 1.0)) / divisor
                      : -powerOfTwoAbove(-lowest);
}

ValueRange
rangeOf(const std::vector<double>& values)
{
  const auto [lowest, highest] = std::minmax_element(values.begin(), values.end());
  return {*lowest, *highest};
}

ValueRange
heldRange(const std::vector<double>& values,
          unsigned int divisor,
          double lowest_before,
          std::vector<double>& sorted)
{
  const ValueRange all = rangeOf(values);
  if (areAllNear(values, all, divisor, lowest_before))
    return all;
  const ValueRange rest = rangeOfRest(values, sorted);
  const double width = rest.highest - rest.lowest;
  if (width == 0.0) // all but few are 0
    return all;
  const double near_below =
      divisor != 0 ? std::max(width, highest_of_default_bits / divisor) : width;
  const double least = rest.lowest - near_below * far_ratio;
  ValueRange held{rest.highest, rest.lowest};
  for (const double value : values)
    if (value >= least)
      held.lowest = std::min(held.lowest, value);
  double most = rest.lowest + far_ratio * width;
  if (divisor != 0) {
    const double exact = highestExact(std::min(held.lowest, lowest_before), divisor);
    if (rest.highest <= exact)
      most = exact;
  }
  for (const double value : values)
    if (value <= most)
      held.highest = std::max(held.highest, value);
  return held;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "voxelizing/least_squares.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The median of absolute values.
 * \param[in,out] values finite, not empty; are reordered
 */
inline double
medianSize(std::vector<double>& values)
{
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end(), [](double one, double other) {
    return std::abs(one) < std::abs(other);
  });
  return std::abs(*middle);
}

/** \brief The number that one part of some numbers is below; of two it is the median.
 * \param[in,out] numbers finite, not empty; are reordered
 */
template <typename NumberT>
NumberT
quantileOf(std::vector<NumberT>& numbers, std::size_t parts = 2)
{
  const auto place =
      numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / parts);
  std::nth_element(numbers.begin(), place, numbers.end());
  return *place;
}

/** \brief How far the azimuths of most neighbours in a row are apart; 0: there are none.
 * \param[in,out] rows azimuths of each row, in any unit; are sorted
 * \param[in] least_step nearer ones are echoes in one direction
 */
template <typename NumberT>
NumberT
stepOfNeighbours(std::vector<std::vector<NumberT>>& rows, NumberT least_step)
{
  std::vector<NumberT> steps;
  for (std::vector<NumberT>& row : rows) {
    std::sort(row.begin(), row.end());
    for (std::size_t i = 1; i < row.size(); ++i)
      if (row[i] - row[i - 1] > least_step)
        steps.push_back(row[i] - row[i - 1]);
  }
  // Missing points leave larger steps.
  return steps.empty() ? NumberT{0} : quantileOf(steps, 4);
}

/** \brief The largest number in the place of one that is not finite, which has no
 * order. */
inline double
finiteOrLargest(double number)
{
  return std::isfinite(number) ? number : std::numeric_limits<double>::max();
}

/** \brief Fits target = features * result by least squares, up to six times: each time
 * without what is far from the last result, until that stays.
 * \param[in] targets not empty
 * \param[out] error median of the errors; the largest number if there is no result
 */
template <int count>
Eigen::Matrix<double, count, 1>
fitRobustly(const std::vector<Eigen::Matrix<double, count, 1>>& features,
            const std::vector<double>& targets,
            double& error)
{
  using Vector = Eigen::Matrix<double, count, 1>;
  Vector result = Vector::Zero();
  double most = std::numeric_limits<double>::infinity();
  error = most;
  std::vector<double> errors(targets.size());
  for (int round = 0; round < 6; ++round) {
    Eigen::Matrix<double, count, count> squares =
        Eigen::Matrix<double, count, count>::Zero();
    Vector products = Vector::Zero();
    for (std::size_t i = 0; i < targets.size(); ++i)
      if (std::abs(targets[i] - features[i].dot(result)) <= most) {
        squares += features[i] * features[i].transpose();
        products += features[i] * targets[i];
      }
    // The smallest one of several, as where all points are equally far.
    result = solveLeastSquares(squares, products);
    for (std::size_t i = 0; i < targets.size(); ++i)
      errors[i] = finiteOrLargest(targets[i] - features[i].dot(result));
    const double last_error = error;
    error = medianSize(errors);
    if (error == last_error)
      break;
    most = 4.0 * error;
  }
  return result;
}

/** \brief Whether an element is one of about some number of elements, which are spread
 * over all and have no period.
 * \param[in] count of all
 */
inline bool
isChosen(std::size_t index, std::size_t count, std::size_t enough)
{
  constexpr std::uint64_t golden = 2654435769u; // of 2^32
  const std::uint64_t place = index * golden & 0xffffffffu;
  return place * count >> 32 < enough;
}

/** \brief A number as an integer of 2^-bits, within a range; 0 for NaN. */
inline std::int64_t
fixedPoint(double number, int bits, double most)
{
  const double units = std::round(std::ldexp(number, bits));
  return std::isnan(units) ? 0
                           : static_cast<std::int64_t>(std::clamp(units, -most, most));
}

constexpr double two_pi = 6.28318530717958647693;

/** \brief An angle of -pi to pi for one that is not many turns away. */
inline double
wrapped(double angle)
{
  while (angle > 0.5 * two_pi)
    angle -= two_pi;
  while (angle < -0.5 * two_pi)
    angle += two_pi;
  return angle;
}

/** \brief How well numbers are multiples of a step, up to a common offset: 0 to 1.
 * \param[out] offset of them, -step / 2 to step / 2
 */
inline double
coherence(const std::vector<double>& numbers, double step, double& offset)
{
  std::complex<double> sum;
  for (const double number : numbers)
    sum += std::polar(1.0, two_pi * number / step);
  offset = std::arg(sum) * step / two_pi;
  return numbers.empty() ? 0.0 : std::abs(sum) / static_cast<double>(numbers.size());
}

// Distances of the depths that sensors measure, metres, the largest first.
inline constexpr double depth_steps[] = {
    0.01, 0.008, 0.005, 0.004, 0.002, 0.001, 0.0005, 0.00025, 0.0002, 0.0001};
constexpr double least_coherence = 0.9;

} // namespace pcl_ext::PCL_EXT_ABI::io

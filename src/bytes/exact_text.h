// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief A number with the fewest digits, at least six, from which it is read again:
 * fewer would show one that is just out of its range as the end of the range.
 * \tparam NumberT float or double
 */
template <typename NumberT>
std::string
exactText(NumberT number)
{
  if (std::isnan(number))
    return "nan"; // without a sign
  // Without streams, which the viewer's codec does without.
  std::array<char, 48> digits;
  for (int count = 6; count <= std::numeric_limits<NumberT>::max_digits10; ++count) {
    std::snprintf(
        digits.data(), digits.size(), "%.*g", count, static_cast<double>(number));
    if (static_cast<NumberT>(std::strtod(digits.data(), nullptr)) == number)
      break;
  }
  // Some locales have another decimal point.
  std::string text(digits.data());
  const std::size_t point = text.find_first_not_of("0123456789+-einf");
  if (point != std::string::npos)
    text.replace(point, text.find_first_of("0123456789", point) - point, 1, '.');
  return text;
}

/** \brief A number of two digits that is not below another one, which is above 0. */
inline double
roundedUp(double number)
{
  // By a power of ten that is a whole number, so that the result has no further digits.
  const double digits = 1.0 - std::floor(std::log10(number));
  const double scale = std::pow(10.0, std::abs(digits));
  return digits > 0.0 ? std::ceil(number * scale) / scale
                      : std::ceil(number / scale) * scale;
}

} // namespace pcl_ext::PCL_EXT_ABI

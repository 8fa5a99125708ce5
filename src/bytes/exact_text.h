// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <string>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

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
  std::ostringstream text;
  text.imbue(std::locale::classic());
  for (int digits = 6; digits <= std::numeric_limits<NumberT>::max_digits10; ++digits) {
    text.str("");
    text.precision(digits);
    text << number;
    std::istringstream again(text.str());
    again.imbue(std::locale::classic());
    NumberT read = 0;
    if (again >> read && read == number)
      break;
  }
  return text.str();
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

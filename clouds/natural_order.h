// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cctype>
#include <cstddef>
#include <string>

namespace pcl_ext {
namespace clouds {

/** \brief True if a name comes before another one, with the numbers in them compared as
 * numbers: cloud_2 before cloud_10. */
inline bool
comesBefore(const std::string& first, const std::string& second)
{
  const auto isDigit = [](const std::string& text, std::size_t i) {
    return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0;
  };
  // A number without its leading zeros.
  const auto numberAt = [&](const std::string& text, std::size_t& i) {
    while (isDigit(text, i) && text[i] == '0')
      ++i;
    const std::size_t begin = i;
    while (isDigit(text, i))
      ++i;
    return text.substr(begin, i - begin);
  };
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < first.size() && k < second.size()) {
    if (isDigit(first, i) && isDigit(second, k)) {
      const std::string number = numberAt(first, i);
      const std::string other = numberAt(second, k);
      if (number.size() != other.size())
        return number.size() < other.size();
      if (number != other)
        return number < other;
    }
    else {
      if (first[i] != second[k])
        return first[i] < second[k];
      ++i;
      ++k;
    }
  }
  const std::size_t left = first.size() - i;
  const std::size_t other_left = second.size() - k;
  return left != other_left ? left < other_left : first < second;
}

} // namespace clouds
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Makes one value of those that a field has in a voxel: the mean, or of integers
 * and of a single value the most frequent one, the lowest of several.
 * \param[in] field type and step
 * \param[in,out] numbers not empty; are sorted
 * \param[out] value of the field's type, in the machine's order of bytes
 */
inline void
summarizeField(const FieldDescription& field,
               std::vector<std::uint64_t>& numbers,
               void* value)
{
  const bool is_float =
      field.type == FieldType::Float32 || field.type == FieldType::Float64;
  if (is_float && numbers.size() > 1) {
    double sum = 0.0;
    for (const std::uint64_t number : numbers)
      sum += fieldValue(field, number);
    storeFieldValue(field.type, sum / static_cast<double>(numbers.size()), value);
    return;
  }
  std::sort(numbers.begin(), numbers.end());
  std::uint64_t best = numbers.front();
  std::ptrdiff_t best_count = 0;
  for (auto begin = numbers.begin(); begin != numbers.end();) {
    const auto end = std::upper_bound(begin, numbers.end(), *begin);
    if (end - begin > best_count) {
      best = *begin;
      best_count = end - begin;
    }
    begin = end;
  }
  fieldValue(field, best, value);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

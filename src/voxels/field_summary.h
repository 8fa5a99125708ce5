// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

inline bool
isInteger(FieldType type)
{
  return type != FieldType::Float32 && type != FieldType::Float64;
}

/** \brief Whether a field is a packed colour, of 8 bits a channel. */
inline bool
isPackedColour(const FieldDescription& field)
{
  return (field.name == "rgb" || field.name == "rgba") && field.count == 1 &&
         sizeOf(field.type) == sizeof(std::uint32_t);
}

/** \brief The most frequent of some values, the lowest of several.
 * \param[in,out] values not empty; are sorted
 */
template <typename ValueT>
ValueT
mostFrequent(std::vector<ValueT>& values)
{
  std::sort(values.begin(), values.end());
  auto best = values.begin();
  std::ptrdiff_t best_count = 0;
  for (auto begin = values.begin(); begin != values.end();) {
    const auto end = std::upper_bound(begin, values.end(), *begin);
    if (end - begin > best_count) {
      best = begin;
      best_count = end - begin;
    }
    begin = end;
  }
  return *best;
}

/** \brief The mean of packed colours in each of their four bytes.
 * \param[in] field type, without a step
 * \param[in] numbers not empty
 * \param[out] value of the field's type, in the machine's order of bytes
 */
inline void
meanColour(const FieldDescription& field,
           const std::vector<std::uint64_t>& numbers,
           void* value)
{
  std::array<std::uint64_t, sizeof(std::uint32_t)> sums{};
  for (const std::uint64_t number : numbers) {
    std::array<unsigned char, sizeof(std::uint32_t)> bytes;
    fieldValue(field, number, bytes.data());
    for (std::size_t i = 0; i < bytes.size(); ++i)
      sums[i] += bytes[i];
  }
  std::array<unsigned char, sizeof(std::uint32_t)> mean;
  for (std::size_t i = 0; i < mean.size(); ++i)
    mean[i] =
        static_cast<unsigned char>((sums[i] + numbers.size() / 2) / numbers.size());
  std::memcpy(value, mean.data(), mean.size());
}

/** \brief Makes one value of those that a field has in a voxel: the mean without those
 * that are NaN, of packed colours that of each channel, or of integers and of a single
 * value the most frequent one, the lowest of several.
 * \param[in] field type, without a step; integers have one value a point
 * \param[in,out] numbers not empty; may be sorted
 * \param[out] value of the field's type, in the machine's order of bytes
 */
inline void
summarizeField(const FieldDescription& field,
               std::vector<std::uint64_t>& numbers,
               void* value)
{
  if (isPackedColour(field))
    meanColour(field, numbers, value);
  else if (isInteger(field.type) || numbers.size() == 1)
    fieldValue(field, mostFrequent(numbers), value);
  else {
    double sum = 0.0;
    std::size_t count = 0;
    for (const std::uint64_t number : numbers)
      if (const double one = fieldValue(field, number); !std::isnan(one)) {
        sum += one;
        ++count;
      }
    storeFieldValue(field.type,
                    count > 0 ? sum / static_cast<double>(count)
                              : std::numeric_limits<double>::quiet_NaN(),
                    value);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io

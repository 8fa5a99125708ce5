// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What the header of SensorPreprocessor says, once more: which clouds are
 * refused and why, and how a field is read.
 */
#pragma once

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "cloud_message.h"

#include <pcl/PCLPointCloud2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <set>
#include <string>

namespace pcl_ext {
namespace fuzz {

/** \brief What is wrong with a cloud; any of it may be the reason of a refusal. */
using Faults = std::set<PreprocessingCode>;

/** \brief The first field of a name; one that cannot be read is a fault. */
inline const pcl::PCLPointField*
readableField(const pcl::PCLPointCloud2& cloud, const std::string& name, Faults& faults)
{
  for (const pcl::PCLPointField& field : cloud.fields) {
    if (field.name != name)
      continue;
    const std::size_t size = sizeOf(field.datatype);
    if (size == 0 || field.count > 1 ||
        std::uint64_t{field.offset} + size > cloud.point_step)
      faults.insert(PreprocessingCode::InvalidField);
    return &field;
  }
  faults.insert(PreprocessingCode::MissingField);
  return nullptr;
}

/** \brief The fields that are read: x, y, z, and the intensity and the colour if these
 * are. */
using Fields = std::array<const pcl::PCLPointField*, 5>;

/** \brief The first colour that can be read; clouds are not refused for theirs. */
inline const pcl::PCLPointField*
colourField(const pcl::PCLPointCloud2& cloud)
{
  for (const char* const name : {"rgb", "rgba"}) {
    Faults of_field;
    const pcl::PCLPointField* const field = readableField(cloud, name, of_field);
    if (of_field.empty() && sizeOf(field->datatype) == 4)
      return field;
  }
  return nullptr;
}

/** \brief Bytes of a row: row_step is not used where all bytes are points, nor for a
 * single row that is longer. */
inline std::uint64_t
bytesOfRow(const pcl::PCLPointCloud2& cloud)
{
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (cloud.height == 1 && cloud.row_step < row && row <= cloud.data.size())
    return row;
  std::uint64_t rest = cloud.data.size();
  std::uint64_t rows = 0;
  for (; row > 0 && rest >= row; rest -= row)
    ++rows;
  return rest == 0 && rows == cloud.height && rows > 0 ? row : cloud.row_step;
}

inline Faults
findFaults(const pcl::PCLPointCloud2& cloud,
           const std::string& intensity_field,
           bool needs_intensity,
           bool reads_colours,
           Fields& fields)
{
  Faults faults;
  fields = {readableField(cloud, "x", faults),
            readableField(cloud, "y", faults),
            readableField(cloud, "z", faults),
            needs_intensity ? readableField(cloud, intensity_field, faults) : nullptr,
            reads_colours ? colourField(cloud) : nullptr};
  constexpr std::uint8_t bool_datatype = 11;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (fields[axis] != nullptr && fields[axis]->datatype == bool_datatype)
      faults.insert(PreprocessingCode::InvalidField);
  if (cloud.width == 0 || cloud.height == 0) {
    // Bytes of points that are not there: one of both was forgotten.
    if (cloud.width != cloud.height && cloud.point_step > 0 &&
        cloud.data.size() >= cloud.point_step)
      faults.insert(PreprocessingCode::InvalidLayout);
    return faults;
  }
  // The products need up to 64 bits each; their sum is compared without adding.
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  const std::uint64_t rows_before = std::uint64_t{cloud.height - 1} * bytesOfRow(cloud);
  if (cloud.point_step == 0 || cloud.is_bigendian != 0 || row > bytesOfRow(cloud) ||
      row > cloud.data.size() || rows_before > cloud.data.size() - row)
    faults.insert(PreprocessingCode::InvalidLayout);
  return faults;
}

template <typename NumberT>
NumberT
numberAt(const std::uint8_t* bytes)
{
  NumberT number;
  std::memcpy(&number, bytes, sizeof(number));
  return number;
}

template <typename NumberT>
NumberT
readField(const std::uint8_t* point, const pcl::PCLPointField& field)
{
  const std::uint8_t* const bytes = point + field.offset;
  switch (field.datatype) {
  case 1:
    return static_cast<NumberT>(numberAt<std::int8_t>(bytes));
  case 2:
    return static_cast<NumberT>(numberAt<std::uint8_t>(bytes));
  case 3:
    return static_cast<NumberT>(numberAt<std::int16_t>(bytes));
  case 4:
    return static_cast<NumberT>(numberAt<std::uint16_t>(bytes));
  case 5:
    return static_cast<NumberT>(numberAt<std::int32_t>(bytes));
  case 6:
    return static_cast<NumberT>(numberAt<std::uint32_t>(bytes));
  case 7:
    return static_cast<NumberT>(numberAt<float>(bytes));
  case 8:
    return static_cast<NumberT>(numberAt<double>(bytes));
  case 9:
    return static_cast<NumberT>(numberAt<std::int64_t>(bytes));
  case 10:
    return static_cast<NumberT>(numberAt<std::uint64_t>(bytes));
  default:
    return *bytes != 0 ? 1.0f : 0.0f;
  }
}

/** \brief A point's intensity as the documentation of the models describes it. */
template <typename ModelT>
double
expectedIntensity(const ModelT& model, float depth, float native)
{
  if constexpr (ModelT::uses_depth) {
    const double share =
        std::clamp(static_cast<double>(depth) / model.cutOffDepth(), 0.0, 1.0);
    return share * share;
  }
  return ModelT::uses_native ? static_cast<double>(native) : 1.0;
}

/** \brief Whether a value is a point's intensity times the scale except for rounding,
 * and for what is too small for a float before it is scaled. Beyond a float all is the
 * same. */
inline bool
isNear(float value, double intensity, float scale)
{
  constexpr auto smallest = static_cast<double>(std::numeric_limits<float>::min());
  constexpr auto largest = static_cast<double>(std::numeric_limits<float>::max());
  const double expected = intensity * static_cast<double>(scale);
  if (!std::isfinite(value))
    return !(std::abs(expected) < 0.999 * largest);
  return std::abs(static_cast<double>(value) - expected) <=
         1e-5 * std::abs(expected) + smallest * (1.0 + static_cast<double>(scale));
}

} // namespace fuzz
} // namespace pcl_ext

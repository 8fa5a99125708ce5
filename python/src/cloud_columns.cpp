// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "cloud_columns.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace pcl_ext::python {

namespace {

template <typename NumberT, typename ResultT>
void
copyNumbers(const Column& column,
            std::size_t count,
            std::size_t stride,
            ResultT* result)
{
  const char* number = column.first;
  for (std::size_t i = 0; i < count; ++i, number += column.stride) {
    NumberT value;
    std::memcpy(&value, number, sizeof(value));
    *result = static_cast<ResultT>(value);
    result += stride;
  }
}

/** \brief Copies a column.
 * \param[in] stride numbers from one result to the next
 * \param[out] result the numbers, rounded to its type
 */
template <typename ResultT>
void
copyColumn(const Column& column, std::size_t count, std::size_t stride, ResultT* result)
{
  switch (column.type) {
  case NumberType::Float32:
    return copyNumbers<float>(column, count, stride, result);
  case NumberType::Float64:
    return copyNumbers<double>(column, count, stride, result);
  case NumberType::Int8:
    return copyNumbers<std::int8_t>(column, count, stride, result);
  case NumberType::Int16:
    return copyNumbers<std::int16_t>(column, count, stride, result);
  case NumberType::Int32:
    return copyNumbers<std::int32_t>(column, count, stride, result);
  case NumberType::Int64:
    return copyNumbers<std::int64_t>(column, count, stride, result);
  case NumberType::UInt8:
    return copyNumbers<std::uint8_t>(column, count, stride, result);
  case NumberType::UInt16:
    return copyNumbers<std::uint16_t>(column, count, stride, result);
  case NumberType::UInt32:
    return copyNumbers<std::uint32_t>(column, count, stride, result);
  case NumberType::UInt64:
    return copyNumbers<std::uint64_t>(column, count, stride, result);
  }
}

template <typename NumberT>
bool
isAligned(const char* address)
{
  return reinterpret_cast<std::uintptr_t>(address) % alignof(NumberT) == 0;
}

/** \brief True if a stride, bytes, can be that of a view with a few numbers of a type
 * for each point. */
template <typename NumberT>
bool
isStrideOf(std::ptrdiff_t stride, std::ptrdiff_t numbers)
{
  constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(NumberT));
  return stride >= numbers * bytes && stride % bytes == 0;
}

/** \brief True if x, y and z are consecutive numbers of a type. */
template <typename NumberT>
bool
arePositions(const std::array<Column, 3>& coordinates, std::size_t count)
{
  constexpr NumberType type =
      std::is_same_v<NumberT, double> ? NumberType::Float64 : NumberType::Float32;
  const Column& x = coordinates[0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Column& column = coordinates[axis];
    if (column.type != type || column.stride != x.stride ||
        column.first != x.first + axis * sizeof(NumberT))
      return false;
  }
  return isAligned<NumberT>(x.first) && (count < 2 || isStrideOf<NumberT>(x.stride, 3));
}

/** \brief A stride, bytes; that of a single point may be anything, and is not used. */
std::size_t
strideOf(std::ptrdiff_t stride, std::size_t count)
{
  return count < 2 ? 0 : static_cast<std::size_t>(stride);
}

/** \brief Where x, y and z are: in the caller's array, or in a copy. */
template <typename NumberT>
const NumberT*
coordinatesOf(const CloudColumns& cloud,
              std::vector<NumberT>& copy,
              std::size_t& stride)
{
  const Column& x = cloud.coordinates[0];
  if (arePositions<NumberT>(cloud.coordinates, cloud.count)) {
    stride = strideOf(x.stride, cloud.count);
    return reinterpret_cast<const NumberT*>(x.first);
  }
  copy.resize(3 * cloud.count);
  for (std::size_t axis = 0; axis < 3; ++axis)
    copyColumn(cloud.coordinates[axis], cloud.count, 3, copy.data() + axis);
  stride = 3 * sizeof(NumberT);
  return copy.data();
}

void
setCoordinates(const CloudColumns& cloud, CloudMemory& memory, io::PointView& view)
{
  const bool has_doubles = std::any_of(
      cloud.coordinates.begin(), cloud.coordinates.end(), [](const Column& column) {
        return column.type == NumberType::Float64;
      });
  if (has_doubles)
    view.double_coordinates =
        coordinatesOf(cloud, memory.double_coordinates, view.coordinate_stride);
  else
    view.coordinates = coordinatesOf(cloud, memory.coordinates, view.coordinate_stride);
}

void
setIntensities(const Column& column,
               std::size_t count,
               CloudMemory& memory,
               io::PointView& view)
{
  if (column.type == NumberType::Float32 && isAligned<float>(column.first) &&
      (count < 2 || isStrideOf<float>(column.stride, 1))) {
    view.intensities = reinterpret_cast<const float*>(column.first);
    view.intensity_stride = strideOf(column.stride, count);
    return;
  }
  memory.intensities.resize(count);
  copyColumn(column, count, 1, memory.intensities.data());
  view.intensities = memory.intensities.data();
  view.intensity_stride = sizeof(float);
}

void
packChannels(const std::array<Column, 3>& channels, std::vector<std::uint32_t>& colours)
{
  std::array<const char*, 3> next = {
      channels[0].first, channels[1].first, channels[2].first};
  for (std::uint32_t& colour : colours) {
    colour = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      colour = colour << 8 | static_cast<unsigned char>(*next[channel]);
      next[channel] += channels[channel].stride;
    }
  }
}

void
setColours(const CloudColumns& cloud, CloudMemory& memory, io::PointView& view)
{
  if (cloud.packed_colour && cloud.packed_colour->stride >= 0) {
    view.colours = cloud.packed_colour->first;
    view.colour_stride = static_cast<std::size_t>(cloud.packed_colour->stride);
    return;
  }
  memory.colours.resize(cloud.count);
  if (cloud.channels)
    packChannels(*cloud.channels, memory.colours);
  else {
    const char* packed = cloud.packed_colour->first;
    for (std::uint32_t& colour : memory.colours) {
      std::memcpy(&colour, packed, sizeof(colour));
      packed += cloud.packed_colour->stride;
    }
  }
  view.colours = memory.colours.data();
  view.colour_stride = sizeof(std::uint32_t);
}

bool
isOffered(const FieldColumn& field, const io::StreamSettings& settings)
{
  if (!field.is_channel || settings.colour_bits == 0)
    return true;
  return std::any_of(settings.fields.begin(),
                     settings.fields.end(),
                     [&field](const io::FieldSetting& setting) {
                       return setting.name == field.description.name;
                     });
}

/** \brief Sets the place of a field's values.
 * \param[out] copy for values from the last point to the first
 */
void
setField(const FieldColumn& field,
         std::size_t count,
         std::vector<char>& copy,
         io::FieldView& view)
{
  view.first = field.first;
  view.stride = strideOf(field.stride, count);
  if (count < 2 || field.stride >= 0)
    return;
  const std::size_t bytes =
      io::sizeOf(field.description.type) * field.description.count;
  copy.resize(bytes * count);
  const char* values = field.first;
  for (std::size_t i = 0; i < count; ++i, values += field.stride)
    std::memcpy(copy.data() + i * bytes, values, bytes);
  view.first = copy.data();
  view.stride = bytes;
}

void
setFields(const CloudColumns& cloud,
          const io::StreamSettings& settings,
          CloudMemory& memory,
          io::PointView& view)
{
  // With the points the field ring, too, whose order they may have.
  if (settings.fields.empty() && !settings.keepsPoints())
    return;
  memory.fields.resize(cloud.fields.size());
  for (std::size_t i = 0; i < cloud.fields.size(); ++i)
    if (const FieldColumn& field = cloud.fields[i]; isOffered(field, settings)) {
      view.fields.push_back({field.description});
      setField(field, cloud.count, memory.fields[i], view.fields.back());
    }
}

} // namespace

std::string
fieldDemand()
{
  return "one of " + namesOf(io::field_types) +
         ", in the machine's byte order: convert it with astype";
}

io::PointView
viewOf(const CloudColumns& cloud,
       bool uses_intensities,
       const io::StreamSettings& settings,
       CloudMemory& memory)
{
  io::PointView view;
  view.count = cloud.count;
  view.image = cloud.image;
  // Also those of an empty cloud: its frame then has the fields of the stream's others.
  setFields(cloud, settings, memory, view);
  static const std::uint32_t black = 0;
  if (cloud.count == 0) {
    // Likewise.
    view.colours = cloud.hasColours() ? &black : nullptr;
    return view;
  }
  setCoordinates(cloud, memory, view);
  if (uses_intensities)
    setIntensities(*cloud.intensity, cloud.count, memory, view);
  if (cloud.hasColours())
    setColours(cloud, memory, view);
  return view;
}

} // namespace pcl_ext::python

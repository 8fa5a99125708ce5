#include "cloud_columns.h"

#include <cstring>

namespace pcl_ext {
namespace python {

namespace {

constexpr std::ptrdiff_t float_bytes = sizeof(float);

template <typename NumberT>
void
copyNumbers(const Column& column, std::size_t count, std::size_t stride, float* result)
{
  const char* number = column.first;
  for (std::size_t i = 0; i < count; ++i, number += column.stride) {
    NumberT value;
    std::memcpy(&value, number, sizeof(value));
    *result = static_cast<float>(value);
    result += stride;
  }
}

bool
isAligned(const char* address)
{
  return reinterpret_cast<std::uintptr_t>(address) % alignof(float) == 0;
}

/** \brief True if a stride, bytes, can be that of a view with a few floats for each point. */
bool
isFloatStride(std::ptrdiff_t stride, std::ptrdiff_t floats)
{
  return stride >= floats * float_bytes && stride % float_bytes == 0;
}

/** \brief True if x, y and z are consecutive floats. */
bool
arePositions(const std::array<Column, 3>& coordinates, std::size_t count)
{
  const Column& x = coordinates[0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Column& column = coordinates[axis];
    if (column.type != NumberType::Float32 || column.stride != x.stride ||
        column.first != x.first + static_cast<std::ptrdiff_t>(axis) * float_bytes)
      return false;
  }
  return isAligned(x.first) && (count < 2 || isFloatStride(x.stride, 3));
}

std::size_t
inFloats(std::ptrdiff_t stride, std::size_t count)
{
  // That of one point alone may be anything.
  return count < 2 ? 0 : static_cast<std::size_t>(stride / float_bytes);
}

void
setCoordinates(const CloudColumns& cloud, CloudMemory& memory, io::PointView& view)
{
  const Column& x = cloud.coordinates[0];
  if (arePositions(cloud.coordinates, cloud.count)) {
    view.coordinates = reinterpret_cast<const float*>(x.first);
    view.coordinate_stride = inFloats(x.stride, cloud.count);
    return;
  }
  memory.coordinates.resize(3 * cloud.count);
  for (std::size_t axis = 0; axis < 3; ++axis)
    copyColumn(
        cloud.coordinates[axis], cloud.count, 3, memory.coordinates.data() + axis);
  view.coordinates = memory.coordinates.data();
  view.coordinate_stride = 3;
}

void
setIntensities(const Column& column,
               std::size_t count,
               CloudMemory& memory,
               io::PointView& view)
{
  if (column.type == NumberType::Float32 && isAligned(column.first) &&
      (count < 2 || isFloatStride(column.stride, 1))) {
    view.intensities = reinterpret_cast<const float*>(column.first);
    view.intensity_stride = inFloats(column.stride, count);
    return;
  }
  memory.intensities.resize(count);
  copyColumn(column, count, 1, memory.intensities.data());
  view.intensities = memory.intensities.data();
  view.intensity_stride = 1;
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

} // namespace

void
copyColumn(const Column& column, std::size_t count, std::size_t stride, float* result)
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

io::PointView
viewOf(const CloudColumns& cloud, bool uses_intensities, CloudMemory& memory)
{
  io::PointView view;
  view.count = cloud.count;
  static const std::uint32_t black = 0;
  if (cloud.count == 0) {
    // An empty cloud with colours: its frame then has colours as the stream's others.
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

} // namespace python
} // namespace pcl_ext

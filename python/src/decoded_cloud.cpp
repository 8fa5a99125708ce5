// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "decoded_cloud.h"

#include "bindings.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

namespace pcl_ext::python {

namespace {

std::size_t
roundedUp(std::size_t bytes, std::size_t alignment)
{
  return (bytes + alignment - 1) / alignment * alignment;
}

bool
hasField(const io::VoxelFrame& frame, const char* name)
{
  return std::any_of(
      frame.fields.begin(), frame.fields.end(), [name](const io::FrameField& field) {
        return field.name == name;
      });
}

/** \brief A type in numpy's words, with the number of values if these are several. */
py::object
formatOf(const io::FieldDescription& column)
{
  const py::str type(nameOf(io::field_types, column.type));
  if (column.count == 1)
    return type;
  return py::make_tuple(type, py::make_tuple(column.count));
}

} // namespace

DecodedCloud::DecodedCloud(const io::VoxelFrame& frame)
: width_(frame.cloudWidth()), height_(frame.cloudHeight())
{
  const auto coordinate =
      frame.needsDoubles() ? io::FieldType::Float64 : io::FieldType::Float32;
  for (const char* name : {"x", "y", "z"})
    addColumn({name, coordinate});
  std::optional<std::size_t> intensity_offset;
  if (frame.hasIntensities() && !hasField(frame, "intensity"))
    intensity_offset = addColumn({"intensity", io::FieldType::Float32});
  std::array<std::optional<std::size_t>, 3> channel_offsets;
  for (std::size_t i = 0; i < 3; ++i)
    if (const char* const name = std::array{"r", "g", "b"}[i];
        frame.colour_bits > 0 && !hasField(frame, name))
      channel_offsets[i] = addColumn({name, io::FieldType::UInt8});
  const std::size_t first_field = columns_.size();
  for (const io::FrameField& field : frame.fields)
    addColumn(field);
  std::size_t alignment = 1;
  for (const Column& column : columns_)
    alignment = std::max(alignment, io::sizeOf(column.description.type));
  point_bytes_ = roundedUp(point_bytes_, alignment);

  points_ = std::make_unique<unsigned char[]>(frame.cloudSize() * point_bytes_);
  if (!frame.isDense())
    writeMissingPoints(frame.needsDoubles());
  const auto write_point = [&](std::size_t point,
                               auto x,
                               auto y,
                               auto z,
                               float intensity,
                               const io::VoxelColour& colour) {
    unsigned char* const next = pointAt(frame, point);
    const std::array<decltype(x), 3> place = {x, y, z};
    std::memcpy(next, place.data(), sizeof(place));
    if (intensity_offset)
      std::memcpy(next + *intensity_offset, &intensity, sizeof(intensity));
    const std::array<unsigned char, 3> channels = {colour.r, colour.g, colour.b};
    for (std::size_t i = 0; i < 3; ++i)
      if (channel_offsets[i])
        next[*channel_offsets[i]] = channels[i];
  };
  io::forEachPoint(frame, write_point);
  for (std::size_t i = 0; i < frame.fields.size(); ++i)
    writeField(frame, frame.fields[i], columns_[first_field + i].offset);
}

std::size_t
DecodedCloud::addColumn(const io::FieldDescription& description)
{
  const std::size_t size = io::sizeOf(description.type);
  const std::size_t offset = roundedUp(point_bytes_, size);
  columns_.push_back({description, offset});
  point_bytes_ = offset + size * description.count;
  return offset;
}

void
DecodedCloud::writeField(const io::VoxelFrame& frame,
                         const io::FrameField& field,
                         std::size_t offset)
{
  const std::size_t size = io::sizeOf(field.type);
  const std::uint64_t* number = field.numbers.data();
  const std::size_t points = frame.pointCount();
  for (std::size_t i = 0; i < points; ++i)
    for (std::size_t k = 0; k < field.count; ++k, ++number)
      io::fieldValue(field, *number, pointAt(frame, i) + offset + k * size);
}

/** \brief Where a point of a frame is. */
unsigned char*
DecodedCloud::pointAt(const io::VoxelFrame& frame, std::size_t point)
{
  return points_.get() + frame.cloudIndex(point) * point_bytes_;
}

/** \brief Sets the coordinates of all points to what is not a number, x, y and z being
 * the first columns. */
void
DecodedCloud::writeMissingPoints(bool are_doubles)
{
  const auto write = [this](auto not_a_number) {
    for (std::size_t i = 0; i < width_ * height_; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis)
        std::memcpy(points_.get() + i * point_bytes_ + axis * sizeof(not_a_number),
                    &not_a_number,
                    sizeof(not_a_number));
  };
  if (are_doubles)
    write(std::numeric_limits<double>::quiet_NaN());
  else
    write(std::numeric_limits<float>::quiet_NaN());
}

py::array
DecodedCloud::intoArray()
{
  py::list names;
  py::list formats;
  py::list offsets;
  for (const Column& column : columns_) {
    // Names of a stream may repeat each other or those of the coordinates.
    py::str name = text(column.description.name);
    while (names.contains(name))
      name = name + py::str("_");
    names.append(name);
    formats.append(formatOf(column.description));
    offsets.append(column.offset);
  }
  const py::dtype type(names, formats, offsets, static_cast<py::ssize_t>(point_bytes_));
  unsigned char* const points = points_.get();
  const py::capsule owner(
      points, [](void* memory) { delete[] static_cast<unsigned char*>(memory); });
  points_.release();
  const auto width = static_cast<py::ssize_t>(width_);
  const auto step = static_cast<py::ssize_t>(point_bytes_);
  if (height_ == 1)
    return py::array(type, {width}, {step}, points, owner);
  return py::array(type,
                   {static_cast<py::ssize_t>(height_), width},
                   {width * step, step},
                   points,
                   owner);
}

} // namespace pcl_ext::python

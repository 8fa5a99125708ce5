#include "decoded_cloud.h"

#include "bindings.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>

namespace pcl_ext {
namespace python {

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

DecodedCloud::DecodedCloud(const io::VoxelFrame& frame) : count_(frame.pointCount())
{
  const auto coordinate =
      frame.grid.needsDoubles() ? io::FieldType::Float64 : io::FieldType::Float32;
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

  points_ = std::make_unique<unsigned char[]>(count_ * point_bytes_);
  unsigned char* next = points_.get();
  std::size_t voxel = 0;
  io::forEachPreciseCentre(frame, [&](auto x, auto y, auto z, float intensity) {
    const unsigned char* const first = next;
    const std::array<decltype(x), 3> place = {x, y, z};
    std::memcpy(next, place.data(), sizeof(place));
    if (intensity_offset)
      std::memcpy(next + *intensity_offset, &intensity, sizeof(intensity));
    if (frame.colour_bits > 0) {
      const io::VoxelColour colour = frame.fullColour(voxel);
      const std::array<unsigned char, 3> channels = {colour.r, colour.g, colour.b};
      for (std::size_t i = 0; i < 3; ++i)
        if (channel_offsets[i])
          next[*channel_offsets[i]] = channels[i];
    }
    next += point_bytes_;
    const std::size_t points = frame.has_point_counts ? frame.point_counts[voxel] : 1;
    for (std::size_t copy = 1; copy < points; ++copy, next += point_bytes_)
      std::memcpy(next, first, point_bytes_);
    ++voxel;
  });
  for (std::size_t i = 0; i < frame.fields.size(); ++i)
    writeField(frame.fields[i], columns_[first_field + i].offset);
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
DecodedCloud::writeField(const io::FrameField& field, std::size_t offset)
{
  const std::size_t size = io::sizeOf(field.type);
  const std::uint64_t* number = field.numbers.data();
  unsigned char* point = points_.get();
  for (std::size_t i = 0; i < count_; ++i, point += point_bytes_)
    for (std::size_t k = 0; k < field.count; ++k, ++number)
      io::fieldValue(field, *number, point + offset + k * size);
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
  return py::array(type,
                   {static_cast<py::ssize_t>(count_)},
                   {static_cast<py::ssize_t>(point_bytes_)},
                   points,
                   owner);
}

} // namespace python
} // namespace pcl_ext

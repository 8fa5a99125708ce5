// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/nodes/impl/message_layouts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

using io::FieldType;
using io::PlacedField;

std::uint64_t
bytesOf(const PlacedField& field)
{
  return std::uint64_t{field.count} * io::sizeOf(field.type);
}

bool
isColour(const PlacedField& field)
{
  return (field.name == "rgb" || field.name == "rgba") && bytesOf(field) == 4 &&
         field.count == 1;
}

bool
isCoordinate(const PlacedField& field)
{
  return field.name == "x" || field.name == "y" || field.name == "z";
}

bool
areTheSame(const PlacedField& one, const PlacedField& other)
{
  return one.count == other.count &&
         (one.name == other.name || (isColour(one) && isColour(other)));
}

/** \brief Puts coordinates that are whole numbers, or of several types, behind the other
 * bytes of a point. */
void
makeCoordinatesReal(io::MessageLayout& layout)
{
  std::array<PlacedField*, 3> coordinates{};
  CoordinateTypes types{};
  for (std::size_t axis = 0; axis < types.size(); ++axis) {
    const auto found = std::find_if(
        layout.fields.begin(), layout.fields.end(), [axis](const auto& field) {
          return field.name == std::string(1, static_cast<char>('x' + axis));
        });
    if (found == layout.fields.end())
      return;
    coordinates[axis] = &*found;
    types[axis] = static_cast<std::uint8_t>(found->type);
  }
  if (areReal(types))
    return;
  for (PlacedField* const field : coordinates) {
    field->type = needDoubles(types) ? FieldType::Float64 : FieldType::Float32;
    field->offset = layout.point_step;
    layout.point_step += static_cast<std::uint32_t>(io::sizeOf(field->type));
  }
}

/** \brief Copies bytes, the usual numbers of them at once. */
void
copyBytes(const std::uint8_t* from, std::uint8_t* to, std::size_t bytes)
{
  switch (bytes) {
  case 2:
    std::memcpy(to, from, 2);
    break;
  case 4:
    std::memcpy(to, from, 4);
    break;
  case 8:
    std::memcpy(to, from, 8);
    break;
  case 12:
    std::memcpy(to, from, 12);
    break;
  case 16:
    std::memcpy(to, from, 16);
    break;
  default:
    std::memcpy(to, from, bytes);
  }
}

/** \brief Stores a number as a type.
 * \return whether it was outside of the type, and was limited */
bool
storeLimited(FieldType type, double number, std::uint8_t* place)
{
  io::storeFieldValue(type, number, place);
  // Floats, as intensities are, may be above the largest whole number that they were.
  const double rounding =
      std::max(0.5, std::abs(number) * double{std::numeric_limits<float>::epsilon()});
  return type != FieldType::Float32 && type != FieldType::Float64 &&
         std::abs(detail::readScalar<double>(place, static_cast<std::uint8_t>(type)) -
                  number) > rounding;
}

} // namespace

io::MessageLayout
messageLayoutOf(const pcl::PCLPointCloud2& cloud)
{
  io::MessageLayout layout;
  layout.point_step = cloud.point_step;
  // What is behind a single row has no meaning.
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (const std::uint64_t step = rowStep(cloud);
      cloud.width > 0 && cloud.height > 1 && step > row)
    layout.row_padding = static_cast<std::uint32_t>(step - row);
  for (const pcl::PCLPointField& field : cloud.fields) {
    PlacedField place;
    place.name = field.name;
    place.type = static_cast<FieldType>(field.datatype);
    place.count = std::max(field.count, 1u); // some programs write 0
    place.offset = field.offset;
    if (field.name != "_" && io::isField(place) &&
        place.offset + bytesOf(place) <= cloud.point_step)
      layout.fields.push_back(place);
  }
  makeCoordinatesReal(layout);
  return layout;
}

Arrangement::Arrangement(const io::MessageLayout& layout,
                         const std::vector<PlacedField>& fields,
                         std::uint32_t point_step,
                         std::uint32_t width,
                         std::uint32_t height)
: from_step_(point_step), point_step_(layout.point_step), width_(width), height_(height)
{
  constexpr std::uint64_t always_allowed = std::uint64_t{64} << 20;
  constexpr std::uint64_t most_times = 16;
  std::vector<PlacedField> left = fields;
  for (const PlacedField& place : layout.fields) {
    const auto found = std::find_if(left.begin(), left.end(), [&](const auto& field) {
      return areTheSame(field, place);
    });
    if (found == left.end())
      continue;
    if (isCoordinate(place) && found->type == FieldType::Float64 &&
        place.type != FieldType::Float64)
      refusal_ = "coordinates need FLOAT64 now";
    add(*found, place);
    left.erase(found);
  }
  for (const PlacedField& field : left) {
    PlacedField place = field;
    place.offset = point_step_;
    point_step_ += static_cast<std::uint32_t>(bytesOf(field));
    add(field, place);
  }
  const std::uint64_t row_step =
      std::uint64_t{width} * point_step_ + (height > 1 ? layout.row_padding : 0);
  // A few bytes of a layout could ask for any memory.
  if (row_step > std::numeric_limits<std::uint32_t>::max() ||
      height * row_step >
          std::max(always_allowed,
                   most_times * point_step * std::uint64_t{width} * height))
    refusal_ = "it would take " + std::to_string((height * row_step) >> 20) + " MiB";
  row_step_ = static_cast<std::uint32_t>(row_step);
}

void
Arrangement::add(const PlacedField& from, const PlacedField& to)
{
  fields_.push_back(to);
  const bool has_same_bits = from.type == to.type || (isColour(from) && isColour(to));
  const std::size_t bytes =
      has_same_bits ? static_cast<std::size_t>(bytesOf(to)) : std::size_t{0};
  if (has_same_bits && !copies_.empty()) {
    Copy& last = copies_.back();
    if (last.bytes > 0 && last.from.offset + last.bytes == from.offset &&
        last.to.offset + last.bytes == to.offset) {
      last.bytes += bytes;
      return;
    }
  }
  copies_.push_back({from, to, bytes});
}

std::size_t
Arrangement::apply(const std::uint8_t* from, std::uint8_t* to) const
{
  std::size_t limited = 0;
  const auto convert = [&limited](const Copy& copy,
                                  const std::uint8_t* from_point,
                                  std::uint8_t* to_point) {
    const std::uint8_t* next = from_point + copy.from.offset;
    std::uint8_t* place = to_point + copy.to.offset;
    for (std::uint32_t i = 0; i < copy.to.count; ++i) {
      const auto number =
          detail::readScalar<double>(next, static_cast<std::uint8_t>(copy.from.type));
      limited += storeLimited(copy.to.type, number, place) ? 1 : 0;
      next += io::sizeOf(copy.from.type);
      place += io::sizeOf(copy.to.type);
    }
  };
  for (std::size_t row = 0; row < height_; ++row) {
    std::uint8_t* to_point = to + row * row_step_;
    for (std::size_t column = 0; column < width_; ++column) {
      for (const Copy& copy : copies_)
        if (copy.bytes > 0)
          copyBytes(from + copy.from.offset, to_point + copy.to.offset, copy.bytes);
        else
          convert(copy, from, to_point);
      from += from_step_;
      to_point += point_step_;
    }
  }
  return limited;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

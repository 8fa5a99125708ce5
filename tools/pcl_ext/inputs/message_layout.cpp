// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/message_layout.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "inputs/point_cloud_conversions.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <string>
#include <type_traits>

namespace pcl_ext {
namespace tools {

namespace {

using nlohmann::json;
using recording::PointCloudMessage;
using recording::PointFieldMessage;

// Beyond these the metadata is damaged: more would be memory without use.
constexpr std::uint32_t largest_step = 1u << 12;
constexpr std::uint32_t largest_padding = 1u << 16;
constexpr std::size_t most_fields = 1u << 10;

/** \brief Calls visit(a number of the type) for a datatype of PointField, if there is
 * such a type. */
template <typename VisitT>
void
visitType(std::uint8_t datatype, const VisitT& visit)
{
  switch (datatype) {
  case pcl::PCLPointField::INT8:
    return visit(std::int8_t{});
  case pcl::PCLPointField::UINT8:
    return visit(std::uint8_t{});
  case pcl::PCLPointField::INT16:
    return visit(std::int16_t{});
  case pcl::PCLPointField::UINT16:
    return visit(std::uint16_t{});
  case pcl::PCLPointField::INT32:
    return visit(std::int32_t{});
  case pcl::PCLPointField::UINT32:
    return visit(std::uint32_t{});
  case pcl::PCLPointField::FLOAT32:
    return visit(float{});
  case pcl::PCLPointField::FLOAT64:
    return visit(double{});
  default:
    return;
  }
}

/** \brief Bytes of a field; 0 if its type does not exist. */
std::uint64_t
sizeOf(const PointFieldMessage& field)
{
  return std::uint64_t{field.count} * bytesOf(field.datatype);
}

/** \brief Whether a field has a type, and is within the point. */
bool
isWithin(const PointFieldMessage& field, std::uint32_t point_step)
{
  const std::uint64_t size = sizeOf(field);
  return size > 0 && field.offset + size <= point_step;
}

bool
isValid(const MessageLayout& layout)
{
  return layout.point_step > 0 && layout.point_step <= largest_step &&
         layout.row_padding <= largest_padding && layout.fields.size() <= most_fields &&
         std::all_of(
             layout.fields.begin(), layout.fields.end(), [&](const auto& field) {
               return isWithin(field, layout.point_step);
             });
}

bool
isColour(const PointFieldMessage& field)
{
  return (field.name == "rgb" || field.name == "rgba") && field.count == 1 &&
         sizeOf(field) == sizeof(std::uint32_t);
}

template <typename NumberT>
NumberT
rounded(double number)
{
  if constexpr (std::is_floating_point_v<NumberT>)
    return static_cast<NumberT>(number);
  else {
    using Limits = std::numeric_limits<NumberT>;
    if (std::isnan(number))
      return 0;
    return static_cast<NumberT>(std::clamp(std::nearbyint(number),
                                           static_cast<double>(Limits::min()),
                                           static_cast<double>(Limits::max())));
  }
}

/** \brief Copies a field of one point from one layout to another. */
class FieldCopy {
public:
  FieldCopy(const PointFieldMessage& from, const PointFieldMessage& to)
  : from_(from)
  , to_(to)
  , bytes_(sizeOf(to))
  , has_same_bits_(from.datatype == to.datatype || (isColour(from) && isColour(to)))
  {}

  void
  operator()(const std::uint8_t* from_point, std::uint8_t* to_point) const
  {
    const std::uint8_t* const from = from_point + from_.offset;
    std::uint8_t* const to = to_point + to_.offset;
    if (has_same_bits_)
      std::memcpy(to, from, bytes_);
    else
      for (std::uint32_t i = 0; i < to_.count; ++i)
        convert(from, to, i);
  }

private:
  void
  convert(const std::uint8_t* from, std::uint8_t* to, std::uint32_t i) const
  {
    double value = 0.0;
    visitType(from_.datatype, [&](auto number) {
      std::memcpy(&number, from + i * sizeof(number), sizeof(number));
      value = static_cast<double>(number);
    });
    visitType(to_.datatype, [&](auto number) {
      number = rounded<decltype(number)>(value);
      std::memcpy(to + i * sizeof(number), &number, sizeof(number));
    });
  }

  PointFieldMessage from_;
  PointFieldMessage to_;
  std::size_t bytes_;
  bool has_same_bits_;
};

bool
areTheSame(const PointFieldMessage& one, const PointFieldMessage& other)
{
  return one.count == other.count &&
         (one.name == other.name || (isColour(one) && isColour(other)));
}

/** \brief Whether a coordinate would lose precision. */
bool
narrowsCoordinates(const std::vector<PointFieldMessage>& fields,
                   const std::vector<PointFieldMessage>& places)
{
  const auto has =
      [](const std::vector<PointFieldMessage>& in, const char* name, bool is_double) {
        return std::any_of(in.begin(), in.end(), [&](const PointFieldMessage& field) {
          return field.name == name &&
                 (field.datatype == pcl::PCLPointField::FLOAT64) == is_double;
        });
      };
  const std::initializer_list<const char*> names = {"x", "y", "z"};
  return std::any_of(names.begin(), names.end(), [&](const char* name) {
    return has(fields, name, true) && has(places, name, false);
  });
}

/** \brief Where the fields of a message are to go. */
class Arrangement {
public:
  Arrangement(const MessageLayout& layout, const PointCloudMessage& message)
  : point_step_(layout.point_step)
  {
    std::vector<PointFieldMessage> left = message.fields;
    for (const PointFieldMessage& place : layout.fields) {
      const auto found = std::find_if(left.begin(), left.end(), [&](const auto& field) {
        return areTheSame(field, place);
      });
      if (found == left.end())
        continue;
      add(*found, place);
      left.erase(found);
    }
    for (const PointFieldMessage& field : left) {
      PointFieldMessage place = field;
      place.offset = point_step_;
      point_step_ += static_cast<std::uint32_t>(sizeOf(field));
      add(field, place);
    }
  }

  /** \brief Bytes of a row with this many points and bytes behind them. */
  std::uint64_t
  rowStep(std::uint32_t width, std::uint32_t padding) const
  {
    return std::uint64_t{width} * point_step_ + padding;
  }

  /** \brief Arranges the points, and describes them. */
  void
  apply(std::size_t row_step, PointCloudMessage& message) const
  {
    std::vector<std::uint8_t> bytes(message.height * row_step);
    for (std::size_t row = 0; row < message.height; ++row) {
      const std::uint8_t* from = message.bytes.data() + row * message.row_step;
      std::uint8_t* to = bytes.data() + row * row_step;
      for (std::size_t i = 0; i < message.width; ++i) {
        for (const FieldCopy& copy : copies_)
          copy(from, to);
        from += message.point_step;
        to += point_step_;
      }
    }
    message.bytes.swap(bytes);
    message.fields = fields_;
    message.point_step = point_step_;
    message.row_step = static_cast<std::uint32_t>(row_step);
  }

private:
  void
  add(const PointFieldMessage& from, const PointFieldMessage& to)
  {
    copies_.emplace_back(from, to);
    fields_.push_back(to);
  }

  std::uint32_t point_step_;
  std::vector<PointFieldMessage> fields_;
  std::vector<FieldCopy> copies_;
};

/** \brief Puts coordinates that are whole numbers, or of several types, behind the other
 * bytes of a point, as real numbers: decoded ones are no whole numbers. */
void
makeCoordinatesReal(MessageLayout& layout)
{
  std::array<PointFieldMessage*, 3> coordinates{};
  CoordinateTypes types{};
  for (std::size_t axis = 0; axis < types.size(); ++axis) {
    const auto found = std::find_if(
        layout.fields.begin(), layout.fields.end(), [axis](const auto& field) {
          return field.name == std::string(1, static_cast<char>('x' + axis));
        });
    if (found == layout.fields.end())
      return;
    coordinates[axis] = &*found;
    types[axis] = found->datatype;
  }
  if (areReal(types))
    return;
  for (PointFieldMessage* const field : coordinates) {
    field->datatype =
        needDoubles(types) ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32;
    field->offset = layout.point_step;
    layout.point_step += bytesOf(field->datatype);
  }
}

/** \brief A number of JSON; throws json::exception if it is none of the type. */
template <typename NumberT>
NumberT
numberOf(const json& object, const char* name)
{
  const json& number = object.at(name);
  const auto value = number.is_number_unsigned()
                         ? number.get<std::uint64_t>()
                         : std::numeric_limits<std::uint64_t>::max();
  if (value > std::numeric_limits<NumberT>::max())
    throw json::other_error::create(500, "not in range", &number);
  return static_cast<NumberT>(value);
}

} // namespace

MessageLayout
layoutOf(const StreamMetadata& metadata)
{
  const auto found = metadata.find(layout_metadata);
  if (found == metadata.end())
    return {};
  const json text = json::parse(found->second, nullptr, false);
  MessageLayout layout;
  try {
    layout.point_step = numberOf<std::uint32_t>(text, "point_step");
    layout.row_padding = numberOf<std::uint32_t>(text, "row_padding");
    for (const json& field : text.at("fields"))
      layout.fields.push_back({field.at("name").get<std::string>(),
                               numberOf<std::uint32_t>(field, "offset"),
                               numberOf<std::uint8_t>(field, "datatype"),
                               numberOf<std::uint32_t>(field, "count")});
  }
  catch (const json::exception&) {
    return {};
  }
  return isValid(layout) ? layout : MessageLayout();
}

bool
addLayout(const pcl::PCLPointCloud2& cloud, StreamMetadata& metadata)
{
  MessageLayout layout;
  layout.point_step = cloud.point_step;
  // What is behind a single row has no meaning.
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  if (const std::uint64_t step = rowStep(cloud);
      cloud.width > 0 && cloud.height > 1 && step > row)
    layout.row_padding = static_cast<std::uint32_t>(step - row);
  for (const pcl::PCLPointField& field : cloud.fields) {
    // Some programs write a count of 0 for a single number.
    const PointFieldMessage place{
        field.name, field.offset, field.datatype, std::max(field.count, 1u)};
    if (isWithin(place, cloud.point_step))
      layout.fields.push_back(place);
  }
  makeCoordinatesReal(layout);
  if (!isValid(layout))
    return false;
  json fields = json::array();
  for (const PointFieldMessage& field : layout.fields)
    fields.push_back({{"name", field.name},
                      {"offset", field.offset},
                      {"datatype", field.datatype},
                      {"count", field.count}});
  const json text = {{"point_step", layout.point_step},
                     {"row_padding", layout.row_padding},
                     {"fields", fields}};
  // Names may be no UTF-8.
  metadata[layout_metadata] = text.dump(-1, ' ', false, json::error_handler_t::replace);
  return true;
}

std::string
arrange(const MessageLayout& layout, PointCloudMessage& message)
{
  constexpr std::uint64_t always_allowed = std::uint64_t{64} << 20;
  constexpr std::uint64_t most_times = 16;
  if (layout.point_step == 0)
    return {};
  if (narrowsCoordinates(message.fields, layout.fields))
    return "coordinates need FLOAT64 now";
  const Arrangement arrangement(layout, message);
  const std::uint64_t row_step =
      arrangement.rowStep(message.width, message.height > 1 ? layout.row_padding : 0);
  const std::uint64_t bytes = message.height * row_step;
  // A few bytes of metadata could ask for any memory.
  if (bytes > std::numeric_limits<std::uint32_t>::max() ||
      bytes > std::max(always_allowed, most_times * message.bytes.size()))
    return "it would take " + std::to_string(bytes >> 20) + " MiB";
  arrangement.apply(static_cast<std::size_t>(row_step), message);
  return {};
}

} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/message_layout.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

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

/** \brief Calls visit(a number of the type) for a datatype of PointField.
 * \return false if there is no such type */
template <typename VisitT>
bool
visitType(std::uint8_t datatype, const VisitT& visit)
{
  switch (datatype) {
  case pcl::PCLPointField::INT8:
    visit(std::int8_t{});
    return true;
  case pcl::PCLPointField::UINT8:
    visit(std::uint8_t{});
    return true;
  case pcl::PCLPointField::INT16:
    visit(std::int16_t{});
    return true;
  case pcl::PCLPointField::UINT16:
    visit(std::uint16_t{});
    return true;
  case pcl::PCLPointField::INT32:
    visit(std::int32_t{});
    return true;
  case pcl::PCLPointField::UINT32:
    visit(std::uint32_t{});
    return true;
  case pcl::PCLPointField::FLOAT32:
    visit(float{});
    return true;
  case pcl::PCLPointField::FLOAT64:
    visit(double{});
    return true;
  default:
    return false;
  }
}

/** \brief Bytes of a field; 0 if its type does not exist. */
std::uint64_t
sizeOf(const PointFieldMessage& field)
{
  std::uint64_t size = 0;
  visitType(field.datatype,
            [&](auto number) { size = std::uint64_t{field.count} * sizeof(number); });
  return size;
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
  , has_same_bits_(from.datatype == to.datatype || (isColour(from) && isColour(to)))
  {}

  void
  operator()(const std::uint8_t* from_point, std::uint8_t* to_point) const
  {
    const std::uint8_t* const from = from_point + from_.offset;
    std::uint8_t* const to = to_point + to_.offset;
    if (has_same_bits_)
      std::memcpy(to, from, sizeOf(to_));
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
  bool has_same_bits_;
};

bool
areTheSame(const PointFieldMessage& one, const PointFieldMessage& other)
{
  return one.count == other.count &&
         (one.name == other.name || (isColour(one) && isColour(other)));
}

/** \brief Whether coordinates are FLOAT64. */
bool
hasDoubles(const std::vector<PointFieldMessage>& fields)
{
  return std::any_of(fields.begin(), fields.end(), [](const PointFieldMessage& field) {
    return field.name == "x" && field.datatype == pcl::PCLPointField::FLOAT64;
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

  /** \brief Arranges the points, and describes them. */
  void
  apply(std::uint32_t row_padding, PointCloudMessage& message) const
  {
    const std::size_t row_step = std::size_t{message.width} * point_step_ + row_padding;
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
    layout.point_step = text.at("point_step").get<std::uint32_t>();
    layout.row_padding = text.at("row_padding").get<std::uint32_t>();
    for (const json& field : text.at("fields"))
      layout.fields.push_back({field.at("name").get<std::string>(),
                               field.at("offset").get<std::uint32_t>(),
                               field.at("datatype").get<std::uint8_t>(),
                               field.at("count").get<std::uint32_t>()});
  }
  catch (const json::exception&) {
    return {};
  }
  return isValid(layout) ? layout : MessageLayout();
}

void
addLayout(const pcl::PCLPointCloud2& cloud, StreamMetadata& metadata)
{
  json fields = json::array();
  for (const pcl::PCLPointField& field : cloud.fields)
    if (isWithin({field.name, field.offset, field.datatype, field.count},
                 cloud.point_step))
      fields.push_back({{"name", field.name},
                        {"offset", field.offset},
                        {"datatype", field.datatype},
                        {"count", field.count}});
  const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
  const json text = {{"point_step", cloud.point_step},
                     {"row_padding", cloud.row_step > row ? cloud.row_step - row : 0},
                     {"fields", fields}};
  // Names may be no UTF-8.
  metadata[layout_metadata] = text.dump(-1, ' ', false, json::error_handler_t::replace);
}

bool
arrange(const MessageLayout& layout, PointCloudMessage& message)
{
  if (layout.point_step == 0)
    return true;
  if (!hasDoubles(layout.fields) && hasDoubles(message.fields))
    return false;
  Arrangement(layout, message).apply(layout.row_padding, message);
  return true;
}

} // namespace tools
} // namespace pcl_ext

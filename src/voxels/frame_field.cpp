// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_field.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

// Numbers of values with a step: finite ones are around the middle.
constexpr double most_steps = 0x1p52;
constexpr std::uint64_t middle_number = (std::uint64_t{1} << 52) + 1;
constexpr std::uint64_t minus_infinity_number = 0;
constexpr std::uint64_t infinity_number = 2 * middle_number;
constexpr std::uint64_t nan_number = infinity_number + 1;

/** \brief Calls a function with a value of a type. */
template <typename VisitT>
auto
withType(FieldType type, VisitT&& visit)
{
  switch (type) {
  case FieldType::Int8:
    return visit(std::int8_t{});
  case FieldType::UInt8:
    return visit(std::uint8_t{});
  case FieldType::Int16:
    return visit(std::int16_t{});
  case FieldType::UInt16:
    return visit(std::uint16_t{});
  case FieldType::Int32:
    return visit(std::int32_t{});
  case FieldType::UInt32:
    return visit(std::uint32_t{});
  case FieldType::Float32:
    return visit(float{});
  default:
    return visit(double{});
  }
}

/** \brief The unsigned integer of a type's size. */
template <typename ValueT>
using Bits = std::conditional_t<
    sizeof(ValueT) == 1,
    std::uint8_t,
    std::conditional_t<
        sizeof(ValueT) == 2,
        std::uint16_t,
        std::conditional_t<sizeof(ValueT) == 4, std::uint32_t, std::uint64_t>>>;

template <typename ValueT>
constexpr auto sign_bit = static_cast<Bits<ValueT>>(std::uint64_t{1}
                                                    << (8 * sizeof(ValueT) - 1));

template <typename ValueT>
std::uint64_t
exactNumber(const void* value)
{
  Bits<ValueT> bits;
  std::memcpy(&bits, value, sizeof(bits));
  if constexpr (std::is_floating_point_v<ValueT>)
    return (bits & sign_bit<ValueT>) != 0 ? static_cast<Bits<ValueT>>(~bits)
                                          : bits | sign_bit<ValueT>;
  else if constexpr (std::is_signed_v<ValueT>)
    return static_cast<Bits<ValueT>>(bits ^ sign_bit<ValueT>);
  else
    return bits;
}

template <typename ValueT>
ValueT
exactValue(std::uint64_t number)
{
  auto bits = static_cast<Bits<ValueT>>(number);
  if constexpr (std::is_floating_point_v<ValueT>)
    bits = static_cast<Bits<ValueT>>(
        (bits & sign_bit<ValueT>) != 0 ? bits ^ sign_bit<ValueT> : ~bits);
  else if constexpr (std::is_signed_v<ValueT>)
    bits = static_cast<Bits<ValueT>>(bits ^ sign_bit<ValueT>);
  ValueT value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

std::uint64_t
steppedNumber(double value, double step)
{
  if (std::isnan(value))
    return nan_number;
  if (std::isinf(value))
    return value < 0.0 ? minus_infinity_number : infinity_number;
  const double steps =
      std::clamp(std::nearbyint(value / step), -most_steps, most_steps);
  return middle_number + static_cast<std::uint64_t>(static_cast<std::int64_t>(steps));
}

double
steppedValue(std::uint64_t number, double step)
{
  if (number >= nan_number)
    return std::numeric_limits<double>::quiet_NaN();
  if (number == infinity_number || number == minus_infinity_number)
    return number == infinity_number ? std::numeric_limits<double>::infinity()
                                     : -std::numeric_limits<double>::infinity();
  return static_cast<double>(static_cast<std::int64_t>(number - middle_number)) * step;
}

/** \brief Rounds and clamps a value to a type; NaN is 0 in integers. */
template <typename ValueT>
ValueT
converted(double value)
{
  if constexpr (std::is_floating_point_v<ValueT>) {
    constexpr auto highest = static_cast<double>(std::numeric_limits<ValueT>::max());
    return static_cast<ValueT>(
        std::isfinite(value) ? std::clamp(value, -highest, highest) : value);
  }
  else {
    constexpr auto lowest = static_cast<double>(std::numeric_limits<ValueT>::min());
    constexpr auto highest = static_cast<double>(std::numeric_limits<ValueT>::max());
    return std::isnan(value) ? ValueT{0}
                             : static_cast<ValueT>(
                                   std::clamp(std::nearbyint(value), lowest, highest));
  }
}

} // namespace

bool
isField(const FieldDescription& field)
{
  return !field.name.empty() && field.name.size() <= most_field_name_bytes &&
         field.type >= FieldType::Int8 && field.type <= FieldType::Float64 &&
         field.count >= 1 && field.count <= most_field_values &&
         std::isfinite(field.step) && field.step >= 0.0;
}

std::uint64_t
fieldNumber(const FieldDescription& field, const void* value)
{
  return withType(field.type, [&](auto typed) {
    using ValueT = decltype(typed);
    if (field.step == 0.0)
      return exactNumber<ValueT>(value);
    std::memcpy(&typed, value, sizeof(typed));
    return steppedNumber(static_cast<double>(typed), field.step);
  });
}

bool
isFieldNumberClamped(const FieldDescription& field, std::uint64_t number)
{
  return field.step != 0.0 &&
         (number == minus_infinity_number + 1 || number == infinity_number - 1);
}

void
fieldValue(const FieldDescription& field, std::uint64_t number, void* value)
{
  withType(field.type, [&](auto typed) {
    using ValueT = decltype(typed);
    typed = field.step == 0.0 ? exactValue<ValueT>(number)
                              : converted<ValueT>(steppedValue(number, field.step));
    std::memcpy(value, &typed, sizeof(typed));
  });
}

void
storeFieldValue(FieldType type, double number, void* value)
{
  withType(type, [&](auto typed) {
    typed = converted<decltype(typed)>(number);
    std::memcpy(value, &typed, sizeof(typed));
  });
}

double
fieldValue(const FieldDescription& field, std::uint64_t number)
{
  return withType(field.type, [&](auto typed) {
    fieldValue(field, number, &typed);
    return static_cast<double>(typed);
  });
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/impl/named_value.h>
#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Datatype of a field, numbered as in pcl::PCLPointField and
 * sensor_msgs/PointField. */
enum class FieldType : std::uint8_t {
  Int8 = 1,
  UInt8 = 2,
  Int16 = 3,
  UInt16 = 4,
  Int32 = 5,
  UInt32 = 6,
  Float32 = 7,
  Float64 = 8
};

inline constexpr std::array<NamedValue<FieldType>, 8> field_types = {
    {{FieldType::Int8, "int8"},
     {FieldType::UInt8, "uint8"},
     {FieldType::Int16, "int16"},
     {FieldType::UInt16, "uint16"},
     {FieldType::Int32, "int32"},
     {FieldType::UInt32, "uint32"},
     {FieldType::Float32, "float32"},
     {FieldType::Float64, "float64"}}};

/** \brief Bytes of a value of a datatype: 1, 2, 4 or 8. */
constexpr std::size_t
sizeOf(FieldType type)
{
  switch (type) {
  case FieldType::Int8:
  case FieldType::UInt8:
    return 1;
  case FieldType::Int16:
  case FieldType::UInt16:
    return 2;
  case FieldType::Int32:
  case FieldType::UInt32:
  case FieldType::Float32:
    return 4;
  default:
    return 8;
  }
}

/** \brief What a field of points is called, and how exact it is kept. */
struct FieldDescription {
  std::string name; ///< 1 to 64 bytes
  FieldType type = FieldType::Float32;
  std::uint32_t count = 1; ///< values of a point, 1 to 4096
  /** \brief Values are rounded to multiples of it, in the unit of the field, and are
   * below 2^52 of them; 0: they are kept as they are, NaN and its bits included. */
  double step = 0.0;

  bool
  operator==(const FieldDescription& other) const
  {
    return name == other.name && type == other.type && count == other.count &&
           step == other.step;
  }

  bool
  operator!=(const FieldDescription& other) const
  {
    return !(*this == other);
  }
};

/** \brief A field of all points of a frame.
 *
 * Values are numbers, which ascend with them: see fieldNumber(). They are in the order
 * of the voxels, and those of a voxel as often as it has points, or once in a frame
 * without numbers of points. */
struct FrameField : FieldDescription {
  std::vector<std::uint64_t> numbers; ///< `count` for each point
};

/** \brief Whether all members of a description are within their ranges. */
PCL_EXT_CODEC_EXPORT bool
isField(const FieldDescription& field);

/** \brief Whether one of some descriptions or fields has a name. */
template <typename FieldsT>
bool
hasField(const FieldsT& fields, const std::string& name)
{
  for (const FieldDescription& field : fields)
    if (field.name == name)
      return true;
  return false;
}

/** \brief Longest name of a field, bytes. */
constexpr std::size_t most_field_name_bytes = 64;
/** \brief Most fields of a frame, and most values of a point in all of them. */
constexpr std::size_t most_fields = 64;
constexpr std::size_t most_field_values = 4096;

/** \brief The number of a value: without a step one of as many bits as the type has;
 * with one at most 2^53 + 3, where -inf, finite values (clamped to 2^52 steps), inf and
 * NaN have this order.
 * \param[in] field type and step
 * \param[in] value in the machine's order of bytes; need not be aligned
 */
PCL_EXT_CODEC_EXPORT std::uint64_t
fieldNumber(const FieldDescription& field, const void* value);

/** \brief Whether a number is that of a finite value of 2^52 steps or more, which may
 * have been clamped. */
PCL_EXT_CODEC_EXPORT bool
isFieldNumberClamped(const FieldDescription& field, std::uint64_t number);

/** \brief The value of a number, rounded and clamped to the range of the type. Numbers
 * that fieldNumber() does not return give any value.
 * \param[in] field type and step
 * \param[out] value in the machine's order of bytes; need not be aligned
 */
PCL_EXT_CODEC_EXPORT void
fieldValue(const FieldDescription& field, std::uint64_t number, void* value);

/** \brief Stores a number as a value of a type, rounded and clamped to its range; NaN is
 * 0 in integers. */
PCL_EXT_CODEC_EXPORT void
storeFieldValue(FieldType type, double number, void* value);

/** \brief The value of a number as a double, for pictures and statistics. */
PCL_EXT_CODEC_EXPORT double
fieldValue(const FieldDescription& field, std::uint64_t number);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io

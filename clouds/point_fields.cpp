// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/point_fields.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <stdexcept>

namespace pcl_ext {
namespace clouds {

namespace {

using pcl::PCLPointField;

struct Datatype {
  std::uint8_t number;
  FieldKind kind;
  std::uint64_t bytes;
};

constexpr std::array<Datatype, 10> datatypes = {
    {{PCLPointField::INT8, FieldKind::Signed, 1},
     {PCLPointField::UINT8, FieldKind::Unsigned, 1},
     {PCLPointField::INT16, FieldKind::Signed, 2},
     {PCLPointField::UINT16, FieldKind::Unsigned, 2},
     {PCLPointField::INT32, FieldKind::Signed, 4},
     {PCLPointField::UINT32, FieldKind::Unsigned, 4},
     {PCLPointField::FLOAT32, FieldKind::Real, 4},
     {PCLPointField::FLOAT64, FieldKind::Real, 8},
     {detail::int64_datatype, FieldKind::Signed, 8},
     {detail::uint64_datatype, FieldKind::Unsigned, 8}}};

const Datatype*
datatypeOf(const FileField& field)
{
  for (const Datatype& datatype : datatypes)
    if (datatype.kind == field.kind && datatype.bytes == field.bytes)
      return &datatype;
  return nullptr;
}

/** \brief Bytes of a field in each of some points. */
template <typename Byte>
struct Column {
  Byte* first;      ///< of the first point
  std::size_t step; ///< from one point to the next
};

template <std::size_t bytes>
void
copyEachOf(std::uint64_t points,
           Column<const std::uint8_t> from,
           Column<std::uint8_t> to)
{
  for (std::uint64_t i = 0; i < points; ++i)
    std::memcpy(to.first + i * to.step, from.first + i * from.step, bytes);
}

/** \brief Copies a field of some points.
 * \param[in] bytes of the field in a point
 */
void
copyEach(std::uint64_t bytes,
         std::uint64_t points,
         const Column<const std::uint8_t>& from,
         const Column<std::uint8_t>& to)
{
  // The usual sizes as constants, with which a copy is an instruction or two.
  switch (bytes) {
  case 1:
    return copyEachOf<1>(points, from, to);
  case 2:
    return copyEachOf<2>(points, from, to);
  case 4:
    return copyEachOf<4>(points, from, to);
  case 8:
    return copyEachOf<8>(points, from, to);
  default:
    for (std::uint64_t i = 0; i < points; ++i)
      std::copy_n(from.first + i * from.step, bytes, to.first + i * to.step);
  }
}

} // namespace

bool
hasDatatype(const FileField& field)
{
  return datatypeOf(field) != nullptr;
}

void
startCloud(const std::vector<FileField>& fields,
           std::uint64_t width,
           std::uint64_t height,
           pcl::PCLPointCloud2& cloud)
{
  for (const char* coordinate : {"x", "y", "z"})
    if (std::count_if(fields.begin(), fields.end(), [&](const FileField& field) {
          return field.name == coordinate;
        }) > 1)
      fail(std::string("its header has two fields '") + coordinate + "'");
  cloud.fields.clear();
  cloud.point_step = 0;
  for (const FileField& field : fields) {
    PCLPointField& added = cloud.fields.emplace_back();
    added.name = field.name;
    added.offset = cloud.point_step;
    added.count = static_cast<std::uint32_t>(field.count);
    // Of a gap one that has its size, as far as there is one.
    const bool is_gap = field.kind == FieldKind::Ignored;
    const Datatype* const datatype =
        datatypeOf(is_gap ? FileField{"", FieldKind::Unsigned, field.bytes, 1} : field);
    added.datatype =
        datatype != nullptr ? datatype->number : std::uint8_t{PCLPointField::UINT8};
    if (datatype == nullptr)
      added.count *= static_cast<std::uint32_t>(field.bytes);
    cloud.point_step += static_cast<std::uint32_t>(field.bytes * field.count);
  }
  cloud.width = static_cast<std::uint32_t>(width);
  cloud.height = static_cast<std::uint32_t>(height);
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.is_bigendian = isBigEndianMachine() ? 1 : 0;
  cloud.is_dense = 0; // Nothing tells.
  cloud.data.clear();
}

FileField
fileFieldOf(const PCLPointField& field)
{
  for (const Datatype& datatype : datatypes)
    if (datatype.number == field.datatype)
      return {field.name, datatype.kind, datatype.bytes, field.count};
  throw std::runtime_error("the field '" + shownText(field.name) + "' is no number");
}

std::string
typeName(const FileField& field)
{
  const std::string bits = std::to_string(8 * field.bytes);
  return (field.kind == FieldKind::Real     ? "float"
          : field.kind == FieldKind::Signed ? "int"
                                            : "uint") +
         bits;
}

std::string
textOf(const FileField& field, const std::uint8_t* number)
{
  return visitNumber(field, number, [](auto value) {
    std::array<char, 40> text{};
    const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
    return std::string(text.data(), result.ptr);
  });
}

bool
isBigEndianMachine()
{
  const std::uint16_t one = 1;
  std::uint8_t first = 0;
  std::memcpy(&first, &one, 1);
  return first == 0;
}

void
toLittleEndian(const std::vector<FileField>& fields, std::vector<std::uint8_t>& points)
{
  if (!isBigEndianMachine())
    return;
  const std::uint64_t point_bytes = bytesOf(fields);
  for (std::size_t at = 0; point_bytes > 0 && at + point_bytes <= points.size();)
    for (const FileField& field : fields)
      for (std::uint64_t i = 0; i < field.count; ++i, at += field.bytes)
        std::reverse(&points[at], &points[at] + field.bytes);
}

void
transpose(const std::vector<FileField>& fields,
          std::uint64_t points,
          bool gather,
          const std::vector<std::uint8_t>& from,
          std::vector<std::uint8_t>& to)
{
  to.resize(from.size());
  const std::uint64_t point_bytes = bytesOf(fields);
  std::size_t column = 0;
  std::size_t offset = 0;
  for (const FileField& field : fields) {
    const std::uint64_t bytes = field.bytes * field.count;
    if (gather)
      copyEach(bytes,
               points,
               {from.data() + offset, point_bytes},
               {to.data() + column, bytes});
    else
      copyEach(bytes,
               points,
               {from.data() + column, bytes},
               {to.data() + offset, point_bytes});
    column += points * bytes;
    offset += bytes;
  }
}

std::vector<std::uint8_t>
packedPoints(const pcl::PCLPointCloud2& cloud, const std::vector<FileField>& fields)
{
  const std::uint64_t point_bytes = bytesOf(fields);
  std::vector<std::uint8_t> packed(std::size_t{cloud.width} * cloud.height *
                                   point_bytes);
  for (std::size_t row = 0; !packed.empty() && row < cloud.height; ++row) {
    std::uint8_t* to = packed.data() + row * cloud.width * point_bytes;
    for (std::size_t number = 0; number < fields.size(); ++number) {
      const std::uint8_t* const from =
          cloud.data.data() + row * cloud.row_step + cloud.fields[number].offset;
      const std::uint64_t bytes = fields[number].bytes * fields[number].count;
      copyEach(bytes, cloud.width, {from, cloud.point_step}, {to, point_bytes});
      to += bytes;
    }
  }
  return packed;
}

} // namespace clouds
} // namespace pcl_ext

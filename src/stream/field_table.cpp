// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/field_table.h"

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/frame_failures.h"

#include <algorithm>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

// Set in the type of a field that has a step, which follows.
constexpr std::uint8_t step_flag = 0x80;

CompressionStatus
readField(ByteSource& source, FieldDescription& field)
{
  const std::uint64_t size = source.varint();
  if (source.failure() == ByteSource::Failure::None && size > most_field_name_bytes)
    return corruptFrame("name of a field too long");
  source.text(size, field.name);
  const std::uint8_t type = source.u8();
  field.type = static_cast<FieldType>(type & ~step_flag);
  const std::uint64_t count = source.varint();
  field.count =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(count, most_field_values + 1));
  const bool has_step = (type & step_flag) != 0;
  field.step = has_step ? source.f64() : 0.0;
  if (source.failure() == ByteSource::Failure::None &&
      (!isField(field) || (has_step && field.step == 0.0)))
    return corruptFrame("invalid field");
  return {};
}

void
writeField(const FieldDescription& field, ByteWriter& writer)
{
  writer.varint(field.name.size());
  writer.raw(field.name.data(), field.name.size());
  const bool has_step = field.step != 0.0;
  writer.u8(static_cast<std::uint8_t>(static_cast<unsigned int>(field.type) |
                                      (has_step ? step_flag : 0u)));
  writer.varint(field.count);
  if (has_step)
    writer.f64(field.step);
}

/** \brief A number of a layout; one too large stays so. */
std::uint32_t
readNumber(ByteSource& source)
{
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(
      source.varint(), std::numeric_limits<std::uint32_t>::max()));
}

} // namespace

void
writeFieldTable(const std::vector<FieldDescription>& fields,
                const std::array<std::int32_t, 3>& viewpoint,
                ByteWriter& writer)
{
  writer.varint(fields.size());
  for (const FieldDescription& field : fields)
    writeField(field, writer);
  for (const std::int32_t position : viewpoint)
    writer.signedVarint(position);
}

CompressionStatus
readFieldTable(ByteSource& source,
               std::vector<FieldDescription>& fields,
               std::array<std::int32_t, 3>& viewpoint)
{
  const std::uint64_t count = source.varint();
  if (source.failure() == ByteSource::Failure::None &&
      (count == 0 || count > most_fields))
    return corruptFrame("number of fields outside 1 to 64");
  std::size_t values = 0;
  for (std::uint64_t i = 0; i < count && source.failure() == ByteSource::Failure::None;
       ++i) {
    if (CompressionStatus status = readField(source, fields.emplace_back());
        !status.ok())
      return status;
    values += fields.back().count;
  }
  for (std::int32_t& position : viewpoint) {
    const std::int64_t number = source.signedVarint();
    if (source.failure() == ByteSource::Failure::None &&
        (number < -farthest_viewpoint || number > farthest_viewpoint))
      return corruptFrame("viewpoint too far away");
    position = static_cast<std::int32_t>(number);
  }
  if (source.failure() == ByteSource::Failure::None && values > most_field_values)
    return corruptFrame("too many values of a point");
  return {};
}

void
writeLayout(const MessageLayout& layout, ByteWriter& writer)
{
  writer.varint(layout.fields.size());
  for (const PlacedField& field : layout.fields) {
    writeField(field, writer);
    writer.varint(field.offset);
  }
  writer.varint(layout.point_step);
  writer.varint(layout.row_padding);
}

CompressionStatus
readLayout(ByteSource& source, MessageLayout& layout)
{
  const std::uint64_t count = source.varint();
  if (source.failure() == ByteSource::Failure::None && count > most_layout_bytes)
    return corruptFrame("layout of messages with too many fields");
  for (std::uint64_t i = 0; i < count && source.failure() == ByteSource::Failure::None;
       ++i) {
    PlacedField& field = layout.fields.emplace_back();
    if (CompressionStatus status = readField(source, field); !status.ok())
      return status;
    field.offset = readNumber(source);
  }
  layout.point_step = readNumber(source);
  layout.row_padding = readNumber(source);
  if (source.failure() == ByteSource::Failure::None && !isLayout(layout))
    return corruptFrame("invalid layout of messages");
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::io

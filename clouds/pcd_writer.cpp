// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/pcd_file.h"
#include "clouds/point_fields.h"

extern "C" { // which some versions of lzf.h lack
#include <liblzf/lzf.h>
}

#include <array>
#include <charconv>
#include <limits>
#include <stdexcept>

namespace pcl_ext {
namespace clouds {

namespace {

std::string
textOf(float number)
{
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

std::string
headerOf(const pcl::PCLPointCloud2& cloud,
         const std::vector<FileField>& fields,
         const Viewpoint& viewpoint,
         const std::string& storage)
{
  std::string names;
  std::string sizes;
  std::string types;
  std::string counts;
  for (const FileField& field : fields) {
    names += ' ' + field.name;
    sizes += ' ' + std::to_string(field.bytes);
    types += field.kind == FieldKind::Real     ? " F"
             : field.kind == FieldKind::Signed ? " I"
                                               : " U";
    counts += ' ' + std::to_string(field.count);
  }
  std::string pose;
  const Eigen::Quaternionf& turn = viewpoint.orientation;
  for (const float number : {viewpoint.origin.x(),
                             viewpoint.origin.y(),
                             viewpoint.origin.z(),
                             turn.w(),
                             turn.x(),
                             turn.y(),
                             turn.z()})
    pose += ' ' + textOf(number);
  const std::uint64_t points = std::uint64_t{cloud.width} * cloud.height;
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" + names +
         "\nSIZE" + sizes + "\nTYPE" + types + "\nCOUNT" + counts + "\nWIDTH " +
         std::to_string(cloud.width) + "\nHEIGHT " + std::to_string(cloud.height) +
         "\nVIEWPOINT" + pose + "\nPOINTS " + std::to_string(points) + "\nDATA " +
         storage + "\n";
}

void
appendCompressed(const std::vector<std::uint8_t>& columns,
                 std::vector<std::uint8_t>& bytes)
{
  // What LZF cannot compress becomes longer by a byte in 32.
  const std::size_t most = columns.size() + columns.size() / 16 + 64;
  if (most > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("the cloud is too large for compressed points");
  std::vector<std::uint8_t> packed(most);
  packed.resize(lzf_compress(columns.data(),
                             static_cast<unsigned int>(columns.size()),
                             packed.data(),
                             static_cast<unsigned int>(packed.size())));
  for (const std::size_t size : {packed.size(), columns.size()})
    for (const int shift : {0, 8, 16, 24})
      bytes.push_back(static_cast<std::uint8_t>(size >> shift));
  bytes.insert(bytes.end(), packed.begin(), packed.end());
}

void
appendText(const std::vector<std::uint8_t>& points,
           const std::vector<FileField>& fields,
           std::vector<std::uint8_t>& bytes)
{
  for (std::size_t at = 0; at < points.size();) {
    std::string line;
    for (const FileField& field : fields)
      for (std::uint64_t i = 0; i < field.count; ++i, at += field.bytes)
        line += (line.empty() ? "" : " ") + textOf(field, &points[at]);
    line += '\n';
    bytes.insert(bytes.end(), line.begin(), line.end());
  }
}

} // namespace

std::vector<std::uint8_t>
writePcd(const pcl::PCLPointCloud2& cloud,
         const Viewpoint& viewpoint,
         PcdStorage storage)
{
  std::vector<FileField> fields;
  for (const pcl::PCLPointField& field : cloud.fields) {
    fields.push_back(fileFieldOf(field));
    // Colours are 32 bits, which text of a float would not keep.
    if (storage == PcdStorage::Ascii && field.name == "rgb")
      fields.back().kind = FieldKind::Unsigned;
  }
  const char* const name = storage == PcdStorage::Ascii    ? "ascii"
                           : storage == PcdStorage::Binary ? "binary"
                                                           : "binary_compressed";
  const std::string header = headerOf(cloud, fields, viewpoint, name);
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  std::vector<std::uint8_t> points = packedPoints(cloud, fields);
  if (storage == PcdStorage::Ascii) {
    appendText(points, fields, bytes);
    return bytes;
  }
  toLittleEndian(fields, points);
  if (storage == PcdStorage::Binary) {
    bytes.insert(bytes.end(), points.begin(), points.end());
    return bytes;
  }
  std::vector<std::uint8_t> columns;
  transpose(fields, std::uint64_t{cloud.width} * cloud.height, true, points, columns);
  appendCompressed(columns, bytes);
  return bytes;
}

} // namespace clouds
} // namespace pcl_ext

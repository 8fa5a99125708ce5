// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_text.h"
#include "clouds/ply_file.h"
#include "clouds/ply_header.h"
#include "clouds/point_fields.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace pcl_ext {
namespace clouds {

namespace {

bool
isColour(const FileField& field)
{
  return (field.name == "rgb" || field.name == "rgba") && field.bytes == 4;
}

std::string
propertiesOf(const FileField& field)
{
  if (isColour(field))
    return std::string(
               "property uchar red\nproperty uchar green\nproperty uchar blue\n") +
           (field.name == "rgba" ? "property uchar alpha\n" : "");
  const std::string type = field.kind == FieldKind::Real
                               ? (field.bytes == 4 ? "float" : "double")
                           : field.bytes == 1 ? "char"
                           : field.bytes == 2 ? "short"
                           : field.bytes == 4 ? "int"
                                              : "";
  if (type.empty() || field.count != 1)
    throw std::runtime_error("PLY has no such numbers as those of the field '" +
                             shownText(field.name) + "'");
  return "property " + (field.kind == FieldKind::Unsigned ? "u" + type : type) + ' ' +
         fieldNameToPly(field.name) + '\n';
}

/** \brief Whether the coordinates of a point are finite. */
bool
isThere(const std::vector<FileField>& fields, const std::uint8_t* point)
{
  for (const FileField& field : fields) {
    double number = 0.0;
    float single = 0.0f;
    if (field.kind == FieldKind::Real && field.bytes == 8)
      std::memcpy(&number, point, sizeof(number));
    else if (field.kind == FieldKind::Real) {
      std::memcpy(&single, point, sizeof(single));
      number = static_cast<double>(single);
    }
    const bool is_coordinate =
        field.name == "x" || field.name == "y" || field.name == "z";
    if (is_coordinate && !std::isfinite(number))
      return false;
    point += field.bytes;
  }
  return true;
}

void
appendPoint(const std::vector<FileField>& fields,
            const std::uint8_t* point,
            std::vector<std::uint8_t>& bytes)
{
  for (const FileField& field : fields) {
    if (isColour(field)) {
      std::uint32_t colour = 0;
      std::memcpy(&colour, point, sizeof(colour));
      for (const int shift : {16, 8, 0})
        bytes.push_back(static_cast<std::uint8_t>(colour >> shift));
      if (field.name == "rgba")
        bytes.push_back(static_cast<std::uint8_t>(colour >> 24));
    }
    else
      bytes.insert(bytes.end(), point, point + field.bytes);
    point += field.bytes;
  }
}

void
append(const std::string& text, std::vector<std::uint8_t>& bytes)
{
  bytes.insert(bytes.end(), text.begin(), text.end());
}

} // namespace

std::vector<std::uint8_t>
writePly(const pcl::PCLPointCloud2& cloud)
{
  std::vector<FileField> fields;
  std::string properties;
  for (const pcl::PCLPointField& field : cloud.fields) {
    fields.push_back(fileFieldOf(field));
    properties += propertiesOf(fields.back());
  }
  const std::vector<std::uint8_t> points = packedPoints(cloud, fields);
  const std::size_t point_bytes = bytesOf(fields);
  const bool is_image = cloud.height > 1;
  std::vector<std::uint8_t> vertices;
  std::vector<std::uint8_t> grid;
  std::uint32_t count = 0;
  for (std::size_t at = 0; at < points.size(); at += point_bytes) {
    const bool is_there = !is_image || isThere(fields, &points[at]);
    if (is_image)
      grid.push_back(is_there ? 1 : 0);
    if (!is_there)
      continue;
    appendPoint(fields, &points[at], vertices);
    if (is_image) {
      grid.resize(grid.size() + sizeof(count));
      std::memcpy(&grid[grid.size() - sizeof(count)], &count, sizeof(count));
    }
    ++count;
  }
  std::vector<std::uint8_t> bytes;
  append(std::string("ply\nformat binary_") +
             (isBigEndianMachine() ? "big" : "little") + "_endian 1.0\n",
         bytes);
  if (is_image)
    append("obj_info num_cols " + std::to_string(cloud.width) + "\nobj_info num_rows " +
               std::to_string(cloud.height) + '\n',
           bytes);
  append("element vertex " + std::to_string(count) + '\n' + properties, bytes);
  if (is_image)
    append("element range_grid " +
               std::to_string(std::size_t{cloud.width} * cloud.height) +
               "\nproperty list uchar int vertex_indices\n",
           bytes);
  append("end_header\n", bytes);
  bytes.insert(bytes.end(), vertices.begin(), vertices.end());
  bytes.insert(bytes.end(), grid.begin(), grid.end());
  return bytes;
}

} // namespace clouds
} // namespace pcl_ext

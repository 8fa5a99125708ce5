// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/ply_header.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

/** \brief Names in PLY files, and those of PCL's fields. */
constexpr std::pair<const char*, const char*> normals[] = {
    {"nx", "normal_x"}, {"ny", "normal_y"}, {"nz", "normal_z"}};

/** \brief A number of a PLY file by the name of its type; none: there is no such type. */
std::optional<FileField>
numberOf(const std::string& type)
{
  constexpr struct {
    const char* name;
    const char* other_name;
    FieldKind kind;
    std::uint64_t bytes;
  } types[] = {{"bool", "boolean", FieldKind::Unsigned, 1},
               {"char", "int8", FieldKind::Signed, 1},
               {"uchar", "uint8", FieldKind::Unsigned, 1},
               {"short", "int16", FieldKind::Signed, 2},
               {"ushort", "uint16", FieldKind::Unsigned, 2},
               {"int", "int32", FieldKind::Signed, 4},
               {"uint", "uint32", FieldKind::Unsigned, 4},
               {"long", "int64", FieldKind::Signed, 8},
               {"ulong", "uint64", FieldKind::Unsigned, 8},
               {"float", "float32", FieldKind::Real, 4},
               {"double", "float64", FieldKind::Real, 8}};
  for (const auto& candidate : types)
    if (type == candidate.name || type == candidate.other_name)
      return FileField{"", candidate.kind, candidate.bytes, 1};
  return std::nullopt;
}

void
readProperty(const std::vector<std::string>& words, PlyElement& element)
{
  const bool is_list = words.size() == 5 && words[1] == "list";
  std::optional<FileField> number =
      is_list ? numberOf(words[3])
              : numberOf(words.size() == 3 ? words[1] : std::string());
  const std::optional<FileField> count = is_list ? numberOf(words[2]) : std::nullopt;
  const bool has_integer_count = count && count->kind != FieldKind::Real;
  if (!number || is_list != has_integer_count) {
    if (element.name == "vertex")
      fail("its header has a property of vertices that is no number");
    element.has_unknown = true;
    return;
  }
  number->name = words.back();
  constexpr std::size_t most_properties = 1000;
  if (element.properties.size() == most_properties)
    fail("its header has too many properties");
  element.properties.push_back({*number, count});
}

void
readFormat(const std::vector<std::string>& words, PlyHeader& header)
{
  if (header.has_format)
    fail("its header has two lines format");
  if (words.size() != 3 || words[2] != "1.0")
    fail("its header has no line format with the version 1.0");
  header.has_format = true;
  header.is_text = words[1] == "ascii";
  header.is_big_endian = words[1] == "binary_big_endian";
  if (!header.is_text && !header.is_big_endian && words[1] != "binary_little_endian")
    fail("its header has the unknown format '" + shownText(words[1]) + "'");
}

void
readElement(const std::vector<std::string>& words, PlyHeader& header)
{
  PlyElement element;
  element.name = words.size() == 3 ? words[1] : "";
  element.count =
      countOf(element.name == "vertex" ? "number of vertices" : "number of elements",
              words.back());
  for (const PlyElement& other : header.elements)
    if (other.name == element.name)
      fail("its header has two elements '" + shownText(element.name) + "'");
  header.elements.push_back(element);
}

/** \brief Reads the columns or rows of an image. */
void
readImageSize(const std::vector<std::string>& words, std::uint64_t& size)
{
  const std::uint64_t number = countOf(words[1], words[2]);
  if (size != 0 && size != number)
    fail("its header has two lines " + words[1] + " that differ");
  size = number;
}

/** \brief Reads a line of the header. */
void
readHeaderLine(const std::vector<std::string>& words, PlyHeader& header)
{
  if (words.empty())
    return;
  if (words[0] == "format")
    readFormat(words, header);
  else if (words[0] == "element")
    readElement(words, header);
  else if (words[0] == "property" && !header.elements.empty())
    readProperty(words, header.elements.back());
  else if (words[0] == "obj_info" && words.size() == 3 && isCount(words[2])) {
    if (words[1] == "num_cols")
      readImageSize(words, header.columns);
    if (words[1] == "num_rows")
      readImageSize(words, header.rows);
  }
  header.has_end = words[0] == "end_header";
}

} // namespace

bool
hasList(const PlyElement& element)
{
  return std::any_of(element.properties.begin(),
                     element.properties.end(),
                     [](const PlyProperty& property) { return property.count; });
}

std::string
plyNameToField(const std::string& property)
{
  for (const auto& [ply_name, field_name] : normals)
    if (property == ply_name)
      return field_name;
  return property;
}

std::string
fieldNameToPly(const std::string& field)
{
  for (const auto& [ply_name, field_name] : normals)
    if (field == field_name)
      return ply_name;
  return field;
}

PlyHeader
readPlyHeader(std::istream& file)
{
  PlyHeader header;
  std::string line;
  header.line_end = lineEndOf(file);
  while (header.bytes < most_header_bytes && !header.has_end &&
         readLine(file, line, header.line_end, most_header_bytes - header.bytes)) {
    header.bytes += line.size() + 1;
    ++header.lines;
    readHeaderLine(wordsOf(line), header);
  }
  if (!header.has_end)
    fail("its header has no line end_header: it was cut off, or is no PLY file");
  if (!header.has_format)
    fail("its header has no line format");
  return header;
}

} // namespace clouds
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/bin_file.h"

#include <algorithm>
#include <optional>
#include <sstream>

namespace pcl_ext {
namespace clouds {

namespace {

FileField
parseField(const std::string& text)
{
  constexpr struct {
    const char* name;
    FieldKind kind;
    std::uint64_t bytes;
  } types[] = {{"uint8", FieldKind::Unsigned, 1},
               {"int8", FieldKind::Signed, 1},
               {"uint16", FieldKind::Unsigned, 2},
               {"int16", FieldKind::Signed, 2},
               {"uint32", FieldKind::Unsigned, 4},
               {"int32", FieldKind::Signed, 4},
               {"float32", FieldKind::Real, 4},
               {"float64", FieldKind::Real, 8}};
  const std::size_t colon = text.rfind(':');
  const std::string name = text.substr(0, colon);
  const std::string type =
      colon == std::string::npos ? "float32" : text.substr(colon + 1);
  if (name.empty())
    fail("a field has no name; _ leaves one out");
  std::string known;
  for (const auto& candidate : types) {
    if (type == candidate.name)
      return {
          name, name == "_" ? FieldKind::Ignored : candidate.kind, candidate.bytes, 1};
    known += (known.empty() ? "" : ", ") + std::string(candidate.name);
  }
  fail("'" + shownText(type) + "' of the field '" + shownText(name) +
       "' is no type: it is one of " + known);
}

} // namespace

std::vector<FileField>
parseBinFields(const std::string& text)
{
  std::vector<FileField> fields;
  std::istringstream stream(text + ',');
  for (std::string word; std::getline(stream, word, ',');) {
    word.erase(0, std::min(word.find_first_not_of(' '), word.size()));
    word.erase(word.find_last_not_of(' ') + 1);
    fields.push_back(parseField(word));
    const std::string& name = fields.back().name;
    if (name != "_" &&
        std::count_if(fields.begin(), fields.end(), [&name](const FileField& other) {
          return other.name == name;
        }) > 1)
      fail("there are two fields '" + shownText(name) + "'; _ leaves one out");
  }
  for (const char* coordinate : {"x", "y", "z"})
    if (std::none_of(
            fields.begin(), fields.end(), [coordinate](const FileField& field) {
              return field.name == coordinate;
            }))
      fail(std::string("there is no field '") + coordinate +
           "'; those of KITTI are x,y,z,intensity");
  constexpr std::size_t most_fields = 1000;
  if (fields.size() > most_fields)
    fail("there are more than " + std::to_string(most_fields) + " fields");
  return fields;
}

std::string
binFieldsOf(std::size_t numbers)
{
  if (numbers == 4)
    return "x,y,z,intensity";
  if (numbers == 5)
    return "x,y,z,intensity,ring";
  if (numbers == 6)
    return "x,y,z,r,g,b";
  std::string text = "x,y,z";
  for (std::size_t i = 3; i < numbers; ++i)
    text += ",_";
  return text;
}

} // namespace clouds
} // namespace pcl_ext

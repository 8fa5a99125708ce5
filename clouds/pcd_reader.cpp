// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_files.h"
#include "clouds/file_text.h"
#include "clouds/pcd_file.h"
#include "clouds/point_fields.h"

extern "C" { // which some versions of lzf.h lack
#include <liblzf/lzf.h>
}

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;

/** \brief The lines of a PCD header by their first words. */
struct PcdLines {
  std::map<std::string, std::string> values;
  std::uint64_t bytes = 0;   ///< of the header
  std::uint64_t lines = 0;   ///< of the header
  char line_end = '\n';      ///< see lineEndOf()
  std::string unknown_line;  ///< empty: all are known
  std::string repeated_word; ///< empty: no word is first in two lines
};

bool
isKnownWord(const std::string& word)
{
  constexpr const char* known[] = {"VERSION",
                                   "FIELDS",
                                   "COLUMNS",
                                   "SIZE",
                                   "TYPE",
                                   "COUNT",
                                   "WIDTH",
                                   "HEIGHT",
                                   "VIEWPOINT",
                                   "POINTS",
                                   "DATA"};
  return std::find(std::begin(known), std::end(known), word) != std::end(known);
}

std::optional<PcdLines>
readPcdLines(const std::string& path)
{
  if (isEmptyFile(path))
    return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  PcdLines lines;
  lines.line_end = lineEndOf(file);
  std::string line;
  while (lines.bytes < most_header_bytes &&
         readLine(file, line, lines.line_end, most_header_bytes - lines.bytes)) {
    lines.bytes += line.size() + 1;
    ++lines.lines;
    if (lines.lines == 1 && line.rfind(byte_order_mark, 0) == 0)
      line.erase(0, std::strlen(byte_order_mark));
    std::vector<std::string> words = wordsOf(line);
    if (words.empty() || words[0].front() == '#')
      continue;
    words[0] = upperCase(words[0]);
    if (!isKnownWord(words[0]) || words.size() == 1) {
      lines.unknown_line = line;
      continue;
    }
    const std::string name = words[0] == "COLUMNS" ? "FIELDS" : words[0];
    if (lines.values.count(name) != 0)
      lines.repeated_word = name;
    std::string& value = lines.values[name];
    value = words[1];
    for (std::size_t i = 2; i < words.size(); ++i)
      value += ' ' + words[i];
    if (words[0] == "DATA")
      return lines;
  }
  return std::nullopt;
}

/** \brief A field of a point by its words in a header.
 * \param[in,out] remarks what is left out
 * \return nothing if it has no numbers
 */
std::optional<FileField>
pcdField(const std::string& name,
         const std::string& size,
         const std::string& given_type,
         const std::string& count,
         std::vector<std::string>& remarks)
{
  const std::string type = upperCase(given_type);
  const bool is_known = type == "I" || type == "U" || type == "F";
  if (!is_known && isCoordinateName(name))
    fail("its header has the unknown TYPE '" + shownText(given_type) + "'");
  FileField field;
  field.name = name;
  field.kind = name == "_" || !is_known ? FieldKind::Ignored // fills a point up
               : type == "I"            ? FieldKind::Signed
               : type == "U"            ? FieldKind::Unsigned
                                        : FieldKind::Real;
  field.bytes = countOf("SIZE", size);
  field.count = countOf("COUNT", count);
  if (field.bytes == 0 || field.count == 0) {
    if (name != "_")
      remarks.push_back("the field '" + shownText(name) +
                        "' is left out: its SIZE or COUNT is 0");
    return std::nullopt;
  }
  constexpr std::uint64_t most_bytes = 16; // of a number
  constexpr std::uint64_t most_count = 1 << 20;
  if (field.bytes > most_bytes || field.count > most_count)
    fail("its header has no valid SIZE or COUNT");
  if (name == "_" || (is_known && hasDatatype(field)))
    return field;
  if (isCoordinateName(name))
    fail("its header has no valid SIZE and TYPE of the field '" + shownText(name) +
         "'");
  remarks.push_back("the field '" + shownText(name) +
                    "' is left out: PCL has no numbers of its SIZE and TYPE");
  field.name = "_";
  field.kind = FieldKind::Ignored;
  return field;
}

/** \brief The fields of a point as the header of a PCD file tells. */
std::vector<FileField>
pcdFields(const std::map<std::string, std::string>& values,
          std::vector<std::string>& remarks)
{
  const auto wordsIn = [&values](const std::string& name) {
    const auto found = values.find(name);
    return found == values.end() ? std::vector<std::string>() : wordsOf(found->second);
  };
  const std::vector<std::string> names = wordsIn("FIELDS");
  const std::vector<std::string> sizes = wordsIn("SIZE");
  const std::vector<std::string> types = wordsIn("TYPE");
  const std::vector<std::string> counts = wordsIn("COUNT");
  constexpr std::size_t most_fields = 1000;
  if (names.empty() || names.size() > most_fields || sizes.size() != names.size() ||
      types.size() != names.size() ||
      (!counts.empty() && counts.size() != names.size()))
    fail("the numbers of FIELDS, SIZE, TYPE and COUNT in its header differ");
  std::vector<FileField> fields;
  std::uint64_t point_bytes = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::optional<FileField> field = pcdField(
        names[i], sizes[i], types[i], counts.empty() ? "1" : counts[i], remarks);
    if (!field)
      continue;
    constexpr std::uint64_t most_point_bytes = 1 << 20;
    if ((point_bytes += field->bytes * field->count) > most_point_bytes)
      fail("its header has no valid SIZE or COUNT");
    fields.push_back(*field);
  }
  if (fields.empty())
    fail("its header has no fields with numbers");
  return fields;
}

/** \brief A header that agrees with itself. */
struct PcdContent {
  std::vector<FileField> fields;
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::string storage;              ///< ascii, binary, binary_compressed
  std::vector<std::string> remarks; ///< what is left out
};

PcdContent
contentOf(const std::optional<PcdLines>& lines)
{
  if (!lines)
    fail("its header has no line DATA: it was cut off, or is no PCD file");
  if (!lines->repeated_word.empty())
    fail("its header has two lines " + lines->repeated_word);
  std::map<std::string, std::string> values = lines->values;
  // As for PCL: without rows the points are one, without columns POINTS tells how many.
  const auto points = values.find("POINTS");
  if (values.count("HEIGHT") == 0 ||
      (values["HEIGHT"] == "0" && points != values.end() && points->second != "0")) {
    if (values.count("WIDTH") == 0 && values.count("POINTS") != 0)
      values["WIDTH"] = values["POINTS"];
    values["HEIGHT"] = "1";
  }
  for (const char* name : {"FIELDS", "SIZE", "TYPE", "WIDTH"})
    if (values.count(name) == 0)
      fail(std::string("its header has no line ") + name);
  PcdContent content;
  if (!lines->unknown_line.empty())
    content.remarks.push_back("its header has a line that PCD has not: '" +
                              shownText(lines->unknown_line) + "'");
  content.width = countOf("WIDTH", values.at("WIDTH"));
  content.height = countOf("HEIGHT", values.at("HEIGHT"));
  constexpr std::uint64_t most_points = std::uint64_t{1} << 31;
  if (content.width > most_points || content.height > most_points ||
      content.width * content.height > most_points)
    fail("its header promises " + values.at("WIDTH") + " x " + values.at("HEIGHT") +
         " points, which is too many");
  if (values.count("POINTS") != 0 &&
      countOf("POINTS", values.at("POINTS")) != content.width * content.height)
    fail("WIDTH x HEIGHT and POINTS in its header differ");
  constexpr std::size_t viewpoint_numbers = 7;
  if (const auto viewpoint = values.find("VIEWPOINT");
      viewpoint != values.end() &&
      wordsOf(viewpoint->second).size() != viewpoint_numbers)
    content.remarks.push_back("its VIEWPOINT is left out: it has not 7 numbers");
  content.fields = pcdFields(values, content.remarks);
  const std::string storage = lowerCase(values.at("DATA"));
  if (storage != "ascii" && storage != "binary" && storage != "binary_compressed")
    fail("its points are stored as '" + shownText(storage) +
         "', which is none of ascii, binary and binary_compressed");
  content.storage = storage;
  return content;
}

/** \brief Says that more points follow those that the header of a PCD file promises;
 * empty if none do. Refuses another cloud.
 * \param[in] file after the points
 * \param[in] end of lines
 * \param[in] point_bytes of a point that is not text nor compressed, else 0
 */
std::string
describeRest(std::istream& file, char end, bool is_text, std::uint64_t point_bytes)
{
  const std::istream::pos_type points_end = file.tellg();
  // PCL's writer fills compressed points up to the size of a page.
  constexpr int largest_page = 1 << 16;
  for (int i = 0; i < largest_page && file.peek() == 0; ++i)
    file.get();
  if (!file || file.peek() == std::istream::traits_type::eof())
    return {};
  const std::istream::pos_type begin = file.tellg();
  std::string line;
  readLine(file, line, end);
  if (line.rfind("# .PCD", 0) == 0 || line.rfind("VERSION ", 0) == 0)
    fail("another cloud follows the first one: put each into a file of its own, and "
         "name the files or their folder");
  file.clear();
  if (is_text) {
    file.seekg(begin);
    return describeFurtherLines(file, end);
  }
  file.seekg(0, std::ios::end);
  return describeFurtherPoints(static_cast<std::uint64_t>(file.tellg() - points_end),
                               point_bytes);
}

void
readBytes(std::istream& file, std::vector<std::uint8_t>& bytes)
{
  if (!file.read(reinterpret_cast<char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size())))
    fail("reading it failed");
}

/** \brief The fields without those named _, which PCL leaves out of compressed points.
 */
std::vector<FileField>
withoutGaps(std::vector<FileField> fields)
{
  fields.erase(std::remove_if(fields.begin(),
                              fields.end(),
                              [](const FileField& field) { return field.name == "_"; }),
               fields.end());
  return fields;
}

/** \brief Reads the points after the sizes that compressed ones have before them.
 * \param[in,out] content of its fields those that the points have
 */
void
readCompressed(std::istream& file,
               PcdContent& content,
               std::uint64_t file_bytes,
               std::vector<std::uint8_t>& points)
{
  const std::uint64_t count = content.width * content.height;
  std::vector<std::uint8_t> sizes(8); // compressed, uncompressed; little-endian
  if (file_bytes < sizes.size())
    fail("it was cut off: it has " + std::to_string(file_bytes) +
         " bytes of points, not " + std::to_string(sizes.size()));
  readBytes(file, sizes);
  const auto sizeAt = [&sizes](std::size_t at) {
    return std::uint64_t{sizes[at]} | std::uint64_t{sizes[at + 1]} << 8 |
           std::uint64_t{sizes[at + 2]} << 16 | std::uint64_t{sizes[at + 3]} << 24;
  };
  const std::uint64_t compressed = sizeAt(0);
  const std::uint64_t uncompressed = sizeAt(4);
  if (const auto fields = withoutGaps(content.fields);
      uncompressed == count * bytesOf(fields))
    content.fields = fields;
  const std::uint64_t point_bytes = bytesOf(content.fields);
  if (uncompressed != count * point_bytes)
    fail("its points have " + std::to_string(uncompressed) +
         " bytes uncompressed, not the " + std::to_string(count * point_bytes) +
         " that its header promises");
  // Of LZF, three bytes stand for at most 264.
  constexpr std::uint64_t most_times = 88;
  if (uncompressed > most_times * compressed)
    fail("its compressed points are damaged: " + std::to_string(compressed) +
         " bytes cannot stand for " + std::to_string(uncompressed));
  if (file_bytes < sizes.size() + compressed)
    fail("it was cut off: it has " + std::to_string(file_bytes) +
         " bytes of points, not " + std::to_string(sizes.size() + compressed));
  std::vector<std::uint8_t> packed(compressed);
  readBytes(file, packed);
  std::vector<std::uint8_t> columns(uncompressed);
  if (uncompressed > 0 &&
      lzf_decompress(packed.data(),
                     static_cast<unsigned int>(packed.size()),
                     columns.data(),
                     static_cast<unsigned int>(columns.size())) != columns.size())
    fail("its compressed points are damaged");
  transpose(content.fields, count, false, columns, points);
}

} // namespace

std::optional<PcdHeader>
readPcdHeader(const std::string& path)
{
  const std::optional<PcdLines> lines = readPcdLines(path);
  if (!lines || lines->values.count("FIELDS") == 0)
    return std::nullopt;
  std::map<std::string, std::string> values = lines->values;
  return PcdHeader{
      values["FIELDS"], values["WIDTH"], values["HEIGHT"], values["VIEWPOINT"]};
}

std::vector<std::string>
readPcd(const std::string& path, pcl::PCLPointCloud2& cloud)
{
  const std::optional<PcdLines> lines = readPcdLines(path);
  PcdContent content = contentOf(lines);
  const std::uint64_t points = content.width * content.height;
  const std::uint64_t point_bytes = bytesOf(content.fields);
  const std::uint64_t all_bytes = fs::file_size(path);
  const std::uint64_t bytes = all_bytes - std::min(all_bytes, lines->bytes);
  const bool is_text = content.storage == "ascii";
  const bool is_binary = content.storage == "binary";
  std::uint64_t words = 0; // of a point as text
  for (const FileField& field : content.fields)
    words += field.count;
  // A number and a space for each field is the least that text takes.
  const std::uint64_t least = is_text     ? 2 * points * words - (points > 0 ? 1 : 0)
                              : is_binary ? points * point_bytes
                                          : 0;
  if (bytes < least)
    fail("it was cut off: " +
         (is_text ? "it has fewer points than the " + std::to_string(points) +
                        " of its header"
                  : "it has " + std::to_string(bytes) + " bytes of points, not " +
                        std::to_string(least)));
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(lines->bytes));
  std::vector<std::uint8_t> data;
  if (is_text)
    readTextPoints(file, lines->line_end, content.fields, points, lines->lines, data);
  else if (is_binary) {
    data.resize(points * point_bytes);
    readBytes(file, data);
  }
  else
    readCompressed(file, content, bytes, data);
  if (!is_text)
    toLittleEndian(content.fields, data);
  if (std::string rest =
          describeRest(file, lines->line_end, is_text, is_binary ? point_bytes : 0);
      !rest.empty())
    content.remarks.push_back(std::move(rest));
  startCloud(content.fields, content.width, content.height, cloud);
  cloud.data = std::move(data);
  return content.remarks;
}

} // namespace clouds
} // namespace pcl_ext

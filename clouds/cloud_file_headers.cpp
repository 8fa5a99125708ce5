#include "clouds/cloud_file_headers.h"

#include "clouds/text_points.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void
fail(const std::string& reason)
{
  throw std::runtime_error(reason);
}

/** \brief The lines of a PCD header by their first words. */
struct PcdLines {
  std::map<std::string, std::string> values;
  std::uint64_t bytes = 0;  ///< of the header
  std::uint64_t lines = 0;  ///< of the header
  std::string unknown_line; ///< empty: all are known
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
  std::string line;
  constexpr int most_header_lines = 100;
  for (int i = 0; i < most_header_lines && readLine(file, line); ++i) {
    lines.bytes += line.size() + 1;
    ++lines.lines;
    if (!line.empty() && line.back() == '\r')
      line.pop_back();
    if (line.empty() || line.front() == '#')
      continue;
    const std::size_t space = line.find(' ');
    const std::string name = line.substr(0, space);
    if (!isKnownWord(name) || space == std::string::npos) {
      lines.unknown_line = line;
      continue;
    }
    lines.values[name == "COLUMNS" ? "FIELDS" : name] = line.substr(space + 1);
    if (name == "DATA")
      return lines;
  }
  return std::nullopt;
}

std::vector<std::string>
wordsOf(const std::string& text)
{
  std::istringstream stream(text);
  std::vector<std::string> words;
  std::string word;
  while (stream >> word)
    words.push_back(word);
  return words;
}

/** \brief A number of a header.
 * \throws std::runtime_error if it is none, or too large for a cloud
 */
std::uint64_t
countOf(const std::string& name, const std::string& text)
{
  constexpr std::size_t most_digits = 18;
  if (text.empty() || text.size() > most_digits ||
      text.find_first_not_of("0123456789") != std::string::npos)
    fail("its header has no valid " + name);
  return std::stoull(text);
}

/** \brief A text of a file for messages: short, and in letters of ASCII. */
std::string
shown(std::string text)
{
  constexpr std::size_t longest = 40;
  text.resize(std::min(text.size(), longest));
  for (char& character : text)
    if (std::isprint(static_cast<unsigned char>(character)) == 0)
      character = '?';
  return text;
}

/** \brief The fields of a point as the header of a PCD file tells. */
std::vector<TextField>
pcdFields(const std::map<std::string, std::string>& values)
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
  std::vector<TextField> fields;
  std::uint64_t point_bytes = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    using Kind = TextField::Kind;
    TextField field;
    field.name = names[i];
    field.kind = names[i] == "_"   ? Kind::Ignored // fills a point up
                 : types[i] == "I" ? Kind::Signed
                 : types[i] == "U" ? Kind::Unsigned
                                   : Kind::Real;
    field.bytes = countOf("SIZE", sizes[i]);
    field.count = counts.empty() ? 1 : countOf("COUNT", counts[i]);
    point_bytes += field.bytes * field.count;
    constexpr std::uint64_t most_point_bytes = 1 << 20;
    if (field.bytes == 0 || field.bytes > 8 || field.count > most_point_bytes ||
        point_bytes > most_point_bytes)
      fail("its header has no valid SIZE or COUNT");
    fields.push_back(field);
  }
  return fields;
}

/** \brief Checks the sizes that compressed points of a PCD file have before them. PCL's
 * reader would take memory for any size, and reads past the end of one that is too small.
 * \param[in] point_bytes bytes of a point
 * \return bytes that they take in the file
 */
std::uint64_t
checkCompressedSizes(const std::string& path,
                     std::uint64_t header_bytes,
                     std::uint64_t points,
                     std::uint64_t point_bytes)
{
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(header_bytes));
  std::array<std::uint8_t, 8> sizes{}; // compressed, uncompressed; little-endian
  file.read(reinterpret_cast<char*>(sizes.data()), sizes.size());
  const auto sizeAt = [&sizes](std::size_t at) {
    return std::uint64_t{sizes[at]} | std::uint64_t{sizes[at + 1]} << 8 |
           std::uint64_t{sizes[at + 2]} << 16 | std::uint64_t{sizes[at + 3]} << 24;
  };
  const std::uint64_t compressed = sizeAt(0);
  const std::uint64_t uncompressed = sizeAt(4);
  if (file && uncompressed != points * point_bytes)
    fail("its points have " + std::to_string(uncompressed) +
         " bytes uncompressed, not the " + std::to_string(points * point_bytes) +
         " that its header promises");
  // Of LZF, three bytes stand for at most 264.
  constexpr std::uint64_t most_times = 88;
  if (file && uncompressed > most_times * compressed)
    fail("its compressed points are damaged: " + std::to_string(compressed) +
         " bytes cannot stand for " + std::to_string(uncompressed));
  return sizes.size() + compressed;
}

/** \brief Refuses a text in which more lines follow the points that its header promises. */
void
checkNoLinesFollow(std::istream& file)
{
  std::string line;
  while (readLine(file, line))
    if (line.find_first_not_of(" \t\r") != std::string::npos)
      fail("lines follow the points that its header promises: '" + shown(line) + "'");
}

/** \brief Refuses a file with bytes of further points. */
void
checkNoPointsFollow(std::uint64_t further_bytes, std::uint64_t point_bytes)
{
  if (point_bytes > 0 && further_bytes >= point_bytes)
    fail(std::to_string(further_bytes) +
         " bytes follow the points that its header promises");
}

/** \brief Refuses a PCD file in which another cloud, or more points, follow the points that
 * its header promises, as PCL's reader would leave them out.
 * \param[in] file after the points
 * \param[in] point_bytes of a point that is not text nor compressed, else 0
 */
void
checkNothingFollows(std::istream& file, bool is_text, std::uint64_t point_bytes)
{
  const std::istream::pos_type points_end = file.tellg();
  // PCL's writer fills compressed points up to the size of a page.
  constexpr int largest_page = 1 << 16;
  for (int i = 0; i < largest_page && file.peek() == 0; ++i)
    file.get();
  if (!file || file.peek() == std::istream::traits_type::eof())
    return;
  const std::istream::pos_type begin = file.tellg();
  std::string line;
  readLine(file, line);
  if (line.rfind("# .PCD", 0) == 0 || line.rfind("VERSION ", 0) == 0)
    fail("another cloud follows the first one: put each into a file of its own, and "
         "name the files or their folder");
  file.clear();
  if (is_text) {
    file.seekg(begin);
    checkNoLinesFollow(file);
    return;
  }
  file.seekg(0, std::ios::end);
  checkNoPointsFollow(static_cast<std::uint64_t>(file.tellg() - points_end),
                      point_bytes);
}

/** \brief Bytes of a number of a PLY file; 0: there is no such type. */
std::uint64_t
bytesOfPlyType(const std::string& type)
{
  constexpr std::pair<const char*, std::uint64_t> types[] = {{"char", 1},
                                                             {"uchar", 1},
                                                             {"int8", 1},
                                                             {"uint8", 1},
                                                             {"short", 2},
                                                             {"ushort", 2},
                                                             {"int16", 2},
                                                             {"uint16", 2},
                                                             {"int", 4},
                                                             {"uint", 4},
                                                             {"int32", 4},
                                                             {"uint32", 4},
                                                             {"float", 4},
                                                             {"float32", 4},
                                                             {"double", 8},
                                                             {"float64", 8}};
  for (const auto& [name, bytes] : types)
    if (type == name)
      return bytes;
  return 0;
}

/** \brief What the header of a PLY file tells of its points. */
struct PlyHeader {
  bool is_text = false;
  std::uint64_t vertices = 0;
  std::vector<TextField> fields; ///< of vertices
  std::uint64_t columns = 0;     ///< of an image; 0: there are none
  std::uint64_t rows = 0;
  std::uint64_t bytes = 0;       ///< of the header
  std::uint64_t lines = 0;       ///< of the header
  std::uint64_t elements = 0;    ///< before the vertices
  bool has_others_after = false; ///< other elements, after the vertices
  bool has_vertices = false;     ///< there was their line
  bool is_of_vertices = false;   ///< the properties that follow
  bool has_end = false;
};

/** \brief Reads a line of the header. */
void
readPlyLine(const std::vector<std::string>& words, PlyHeader& header)
{
  if (words.empty())
    return;
  if (words[0] == "format" && words.size() > 1)
    header.is_text = words[1] == "ascii";
  else if (words[0] == "element") {
    header.is_of_vertices = words.size() == 3 && words[1] == "vertex";
    if (header.is_of_vertices)
      header.vertices = countOf("number of vertices", words[2]);
    else if (!header.has_vertices)
      header.elements += countOf("number of elements", words.back());
    else
      header.has_others_after = true;
    header.has_vertices |= header.is_of_vertices;
  }
  else if (words[0] == "property" && header.is_of_vertices) {
    const std::uint64_t bytes = words.size() == 3 ? bytesOfPlyType(words[1]) : 0;
    if (bytes == 0)
      fail("its header has a property of vertices that is no number");
    const std::string& type = words[1];
    header.fields.push_back({words[2],
                             type[0] == 'f' || type[0] == 'd' ? TextField::Kind::Real
                             : type[0] == 'u' ? TextField::Kind::Unsigned
                                              : TextField::Kind::Signed,
                             bytes,
                             1});
  }
  else if (words[0] == "obj_info" && words.size() > 1 && words[1] == "num_cols")
    header.columns = countOf("num_cols", words.size() == 3 ? words[2] : "");
  else if (words[0] == "obj_info" && words.size() > 1 && words[1] == "num_rows")
    header.rows = countOf("num_rows", words.size() == 3 ? words[2] : "");
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

bool
isEmptyFile(const std::string& path)
{
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  return !error && bytes == 0;
}

void
checkPcd(const std::string& path)
{
  const std::optional<PcdLines> lines = readPcdLines(path);
  if (!lines)
    fail("its header has no line DATA: it was cut off, or is no PCD file");
  if (!lines->unknown_line.empty())
    fail("its header has a line that PCD has not: '" + shown(lines->unknown_line) +
         "'");
  const auto& values = lines->values;
  for (const char* name : {"FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT"})
    if (values.count(name) == 0)
      fail(std::string("its header has no line ") + name);
  const std::uint64_t width = countOf("WIDTH", values.at("WIDTH"));
  const std::uint64_t height = countOf("HEIGHT", values.at("HEIGHT"));
  constexpr std::uint64_t most_points = std::uint64_t{1} << 31;
  if (width > most_points || height > most_points || width * height > most_points)
    fail("its header promises " + values.at("WIDTH") + " x " + values.at("HEIGHT") +
         " points, which is too many");
  const std::uint64_t points = width * height;
  if (values.count("POINTS") != 0 && countOf("POINTS", values.at("POINTS")) != points)
    fail("WIDTH x HEIGHT and POINTS in its header differ");
  const std::vector<TextField> fields = pcdFields(values);
  std::uint64_t point_bytes = 0;
  std::uint64_t words = 0; // of a point as text
  bool is_filled_up = false;
  for (const TextField& field : fields) {
    point_bytes += field.bytes * field.count;
    is_filled_up |= field.kind == TextField::Kind::Ignored;
    words += field.count;
  }
  const std::uint64_t file_bytes = fs::file_size(path);
  const std::uint64_t bytes = file_bytes - std::min(file_bytes, lines->bytes);
  const std::string& storage = values.at("DATA");
  const bool is_text = storage == "ascii";
  // PCL writes no such file, and its reader would write past the memory of the points.
  if (storage == "binary_compressed" && is_filled_up)
    fail("its compressed points have a field named _");
  // A number and a space for each field is the least that text takes.
  const std::uint64_t least =
      storage == "binary" ? points * point_bytes
      : is_text           ? 2 * points * words - (points > 0 ? 1 : 0)
                : checkCompressedSizes(path, lines->bytes, points, point_bytes);
  if (bytes < least)
    fail("it was cut off: it has " + std::to_string(bytes) + " bytes of points, not " +
         std::to_string(least));
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(lines->bytes + (is_text ? 0 : least)));
  if (is_text)
    checkTextPoints(file, fields, points, lines->lines, true);
  checkNothingFollows(file, is_text, storage == "binary" ? point_bytes : 0);
}

void
checkPly(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  PlyHeader header;
  std::string line;
  constexpr int most_header_lines = 1000;
  for (int i = 0; i < most_header_lines && !header.has_end && readLine(file, line);
       ++i) {
    header.bytes += line.size() + 1;
    ++header.lines;
    const std::vector<std::string> words = wordsOf(line);
    readPlyLine(words, header);
    header.has_end = !words.empty() && words[0] == "end_header";
  }
  if (!header.has_end)
    fail("its header has no line end_header: it was cut off, or is no PLY file");
  if ((header.columns > 0 || header.rows > 0) &&
      (header.columns > header.vertices || header.rows > header.vertices ||
       header.columns * header.rows != header.vertices))
    fail("num_cols x num_rows and the number of vertices in its header differ");
  const std::uint64_t file_bytes = fs::file_size(path);
  const std::uint64_t bytes = file_bytes - std::min(file_bytes, header.bytes);
  std::uint64_t least_bytes = 0; // of a vertex
  for (const TextField& field : header.fields)
    least_bytes += header.is_text ? 2 : field.bytes;
  if (header.vertices > bytes ||
      header.vertices * least_bytes > bytes + (header.is_text ? 1 : 0))
    fail("it was cut off, or its header is wrong: it promises " +
         std::to_string(header.vertices) + " vertices, and has " +
         std::to_string(bytes) + " bytes of them");
  if (!header.is_text) {
    if (header.elements == 0 && !header.has_others_after)
      checkNoPointsFollow(bytes - header.vertices * least_bytes, least_bytes);
    return;
  }
  for (std::uint64_t i = 0; i < header.elements && readLine(file, line); ++i)
    ++header.lines;
  checkTextPoints(file, header.fields, header.vertices, header.lines, false);
  if (!header.has_others_after)
    checkNoLinesFollow(file);
}

} // namespace clouds
} // namespace pcl_ext

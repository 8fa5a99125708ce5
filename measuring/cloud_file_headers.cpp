#include "measuring/cloud_file_headers.h"

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
namespace measuring {

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

/** \brief Reads a line of a header; a file of no lines is not read as one. */
bool
readLine(std::istream& file, std::string& line)
{
  constexpr std::size_t longest = std::size_t{1} << 16;
  line.clear();
  for (int next = file.get(); next != std::char_traits<char>::eof();
       next = file.get()) {
    if (next == '\n')
      return true;
    if (line.size() == longest)
      return false;
    line += static_cast<char>(next);
  }
  return !line.empty();
}

std::optional<PcdLines>
readPcdLines(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  PcdLines lines;
  std::string line;
  constexpr int most_header_lines = 100;
  for (int i = 0; i < most_header_lines && readLine(file, line); ++i) {
    lines.bytes += line.size() + 1;
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

/** \brief Bytes of a point as the header of a PCD file tells. */
std::uint64_t
pointBytes(const std::map<std::string, std::string>& values)
{
  const auto wordsIn = [&values](const std::string& name) {
    const auto found = values.find(name);
    return found == values.end() ? std::vector<std::string>() : wordsOf(found->second);
  };
  const std::vector<std::string> fields = wordsIn("FIELDS");
  const std::vector<std::string> sizes = wordsIn("SIZE");
  const std::vector<std::string> counts = wordsIn("COUNT");
  constexpr std::size_t most_fields = 1000;
  if (fields.empty() || fields.size() > most_fields || sizes.size() != fields.size() ||
      wordsIn("TYPE").size() != fields.size() ||
      (!counts.empty() && counts.size() != fields.size()))
    fail("the numbers of FIELDS, SIZE, TYPE and COUNT in its header differ");
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::uint64_t size = countOf("SIZE", sizes[i]);
    const std::uint64_t count = counts.empty() ? 1 : countOf("COUNT", counts[i]);
    constexpr std::uint64_t most = 1 << 20;
    if (size > 8 || count > most)
      fail("its header has no valid SIZE or COUNT");
    bytes += size * count;
  }
  return bytes;
}

/** \brief Bytes that the compressed points of a PCD file take, as they tell. */
std::uint64_t
compressedBytes(const std::string& path, std::uint64_t header_bytes)
{
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(header_bytes));
  std::array<std::uint8_t, 8> sizes{}; // compressed, uncompressed; little-endian
  file.read(reinterpret_cast<char*>(sizes.data()), sizes.size());
  return sizes.size() + (std::uint64_t{sizes[0]} | std::uint64_t{sizes[1]} << 8 |
                         std::uint64_t{sizes[2]} << 16 | std::uint64_t{sizes[3]} << 24);
}

/** \brief Refuses a file in which another cloud follows the first one, as PCL's reader would
 * leave it out.
 * \param[in] header_bytes bytes before the points
 * \param[in] lines of points in text; 0: there are bytes instead
 * \param[in] bytes of points, if they are no text
 */
void
checkNothingFollows(const std::string& path,
                    std::uint64_t header_bytes,
                    std::uint64_t lines,
                    std::uint64_t bytes)
{
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(header_bytes + bytes));
  // PCL's writer fills compressed points up to the size of a page.
  constexpr int largest_page = 1 << 16;
  for (int i = 0; i < largest_page && file.peek() == 0; ++i)
    file.get();
  std::string line;
  for (std::uint64_t i = 0; i < lines && readLine(file, line); ++i)
    continue;
  if (readLine(file, line) &&
      (line.rfind("# .PCD", 0) == 0 || line.rfind("VERSION ", 0) == 0))
    fail("another cloud follows the first one: put each into a file of its own, and "
         "name "
         "the files or their folder");
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
  std::uint64_t vertex_bytes = 0;
  std::uint64_t columns = 0; ///< of an image; 0: there are none
  std::uint64_t rows = 0;
  std::uint64_t bytes = 0;     ///< of the header
  bool is_of_vertices = false; ///< the properties that follow
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
  }
  else if (words[0] == "property" && header.is_of_vertices) {
    const std::uint64_t bytes = words.size() == 3 ? bytesOfPlyType(words[1]) : 0;
    if (bytes == 0)
      fail("its header has a property of vertices that is no number");
    header.vertex_bytes += bytes;
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
  const std::uint64_t point_bytes = pointBytes(values);
  const std::uint64_t file_bytes = fs::file_size(path);
  const std::uint64_t bytes = file_bytes - std::min(file_bytes, lines->bytes);
  const std::string& storage = values.at("DATA");
  // A number and a space for each field is the least that text takes.
  const std::uint64_t least =
      storage == "binary" ? points * point_bytes
      : storage == "ascii"
          ? 2 * points * wordsOf(values.at("FIELDS")).size() - (points > 0 ? 1 : 0)
          : compressedBytes(path, lines->bytes);
  if (bytes < least)
    fail("it was cut off: it has " + std::to_string(bytes) + " bytes of points, not " +
         std::to_string(least));
  const bool is_text = storage == "ascii";
  checkNothingFollows(path, lines->bytes, is_text ? points : 0, is_text ? 0 : least);
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
  const std::uint64_t least_bytes = header.is_text ? 2 : header.vertex_bytes;
  if (header.vertices > bytes || header.vertices * least_bytes > bytes + 1)
    fail("it was cut off, or its header is wrong: it promises " +
         std::to_string(header.vertices) + " vertices, and has " +
         std::to_string(bytes) + " bytes of them");
}

} // namespace measuring
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_text.h"
#include "clouds/ply_file.h"
#include "clouds/ply_header.h"
#include "clouds/point_fields.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;
/** \brief Reads the elements of a file one after the other. */
class PlyReader {
public:
  PlyReader(std::istream& file, const PlyHeader& header, std::uint64_t bytes)
  : file_(file), header_(header), lines_(header.lines), bytes_(bytes)
  {}

  void
  skip(const PlyElement& element)
  {
    std::string line;
    if (header_.is_text)
      for (std::uint64_t i = 0;
           i < element.count && readLine(file_, line, header_.line_end);
           ++i)
        ++lines_;
    else if (element.has_unknown)
      fail("before its vertices are elements '" + shownText(element.name) +
           "' with a property that PLY has not");
    else if (hasList(element))
      for (std::uint64_t i = 0; i < element.count; ++i)
        skipOne(element);
    else if (element.properties.empty() || element.count <= bytes_)
      skipBytes(element.count * bytesOf(fieldsOf(element)));
    else
      fail("it was cut off, or its header is wrong");
  }

  /** \brief The vertices, each property after the other, as this machine has numbers. */
  std::vector<std::uint8_t>
  readVertices(const PlyElement& element)
  {
    const std::vector<FileField> fields = fieldsOf(element);
    std::vector<std::uint8_t> vertices;
    if (header_.is_text) {
      readTextPoints(file_,
                     header_.line_end,
                     textFieldsOf(element),
                     element.count,
                     lines_,
                     vertices);
      lines_ += element.count;
      return vertices;
    }
    vertices.resize(element.count * bytesOf(fields));
    if (hasList(element))
      readBetweenLists(element, vertices);
    else
      read(vertices.data(), vertices.size());
    if (header_.is_big_endian != isBigEndianMachine())
      for (std::size_t at = 0; at < vertices.size();)
        for (const FileField& field : fields) {
          std::reverse(&vertices[at], &vertices[at] + field.bytes);
          at += field.bytes;
        }
    return vertices;
  }

  /** \brief For each cell of an image the number of its vertex, or -1. */
  std::vector<std::int64_t>
  readGrid(const PlyElement& element)
  {
    std::vector<std::int64_t> vertices(element.count, -1);
    for (std::int64_t& vertex : vertices) {
      const std::vector<std::uint64_t> cell =
          header_.is_text ? readTextCell() : readBinaryCell(element.properties[0]);
      if (cell.size() != (cell[0] == 0 ? 1u : 2u) || cell[0] > 1)
        fail("its image has a cell that is neither empty nor the number of a vertex");
      if (cell[0] == 1)
        vertex = static_cast<std::int64_t>(cell[1]);
    }
    return vertices;
  }

  /** \brief The properties that are no lists. */
  static std::vector<FileField>
  fieldsOf(const PlyElement& element)
  {
    std::vector<FileField> fields;
    for (const PlyProperty& property : element.properties)
      if (!property.count)
        fields.push_back(property.field);
    return fields;
  }

private:
  static std::vector<FileField>
  textFieldsOf(const PlyElement& element)
  {
    std::vector<FileField> fields;
    for (const PlyProperty& property : element.properties)
      fields.push_back(
          property.count ? FileField{property.field.name, FieldKind::IgnoredList, 0, 1}
                         : property.field);
    return fields;
  }

  /** \brief Reads numbers of elements that have lists, too. */
  void
  readBetweenLists(const PlyElement& element, std::vector<std::uint8_t>& numbers)
  {
    std::size_t at = 0;
    for (std::uint64_t i = 0; i < element.count; ++i)
      for (const PlyProperty& property : element.properties)
        if (property.count)
          skipBytes(readInteger(*property.count) * property.field.bytes);
        else {
          read(&numbers[at], property.field.bytes);
          at += property.field.bytes;
        }
  }

  /** \brief A list with the number of its numbers before them. */
  std::vector<std::uint64_t>
  readTextCell()
  {
    std::string line;
    if (!readLine(file_, line, header_.line_end))
      fail("it was cut off in its image");
    std::vector<std::uint64_t> numbers;
    for (const std::string& word : wordsOf(line)) {
      if (!isCount(word))
        fail("its image has '" + shownText(word) + "' in place of a number");
      numbers.push_back(countOf("number", word));
    }
    if (numbers.empty())
      fail("its image has an empty line");
    return numbers;
  }

  std::vector<std::uint64_t>
  readBinaryCell(const PlyProperty& list)
  {
    std::vector<std::uint64_t> numbers = {readInteger(*list.count)};
    if (numbers[0] == 1)
      numbers.push_back(readInteger(list.field));
    return numbers;
  }

  void
  read(std::uint8_t* bytes, std::size_t size)
  {
    if (!file_.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(size)))
      fail("it was cut off");
  }

  void
  skipBytes(std::uint64_t bytes)
  {
    if (bytes > bytes_)
      fail("it was cut off, or its header is wrong");
    constexpr std::uint64_t most_ignored = 4096; // without reading the buffer anew
    if (bytes <= most_ignored)
      file_.ignore(static_cast<std::streamsize>(bytes));
    else
      file_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
  }

  void
  skipOne(const PlyElement& element)
  {
    for (const PlyProperty& property : element.properties)
      skipBytes(property.count ? readInteger(*property.count) * property.field.bytes
                               : property.field.bytes);
  }

  /** \brief A number of a list, or how many it has. */
  std::uint64_t
  readInteger(const FileField& field)
  {
    std::array<std::uint8_t, 8> bytes{};
    read(bytes.data(), field.bytes);
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < field.bytes; ++i)
      number = number << 8 | bytes[header_.is_big_endian ? i : field.bytes - 1 - i];
    constexpr std::uint64_t most = std::uint64_t{1} << 32;
    if (number >= most ||
        (field.kind == FieldKind::Signed && (number >> (8 * field.bytes - 1)) != 0))
      fail(
          "it has a list with a number of numbers, or of a vertex, that is negative or "
          "too large");
    return number;
  }

  std::istream& file_;
  const PlyHeader& header_;
  std::uint64_t lines_; ///< that were read
  std::uint64_t bytes_; ///< after the header
};

/** \brief The fields of a cloud: the properties by PCL's names. */
std::vector<FileField>
cloudFieldsOf(const PlyElement& vertices)
{
  std::vector<FileField> fields = PlyReader::fieldsOf(vertices);
  for (FileField& field : fields)
    field.name = plyNameToField(field.name);
  return fields;
}

/** \brief Whether points can have coordinates that are NaN. */
bool
mayBeMissing(const std::vector<FileField>& fields)
{
  return std::any_of(fields.begin(), fields.end(), [](const FileField& field) {
    return isCoordinateName(field.name) && field.kind == FieldKind::Real;
  });
}

/** \brief Makes a point one that is not there. */
void
setMissing(const std::vector<FileField>& fields, std::uint8_t* point)
{
  for (const FileField& field : fields) {
    const double missing = std::numeric_limits<double>::quiet_NaN();
    const auto missing_float = static_cast<float>(missing);
    if (isCoordinateName(field.name) && field.kind == FieldKind::Real)
      std::memcpy(point,
                  field.bytes == 8 ? static_cast<const void*>(&missing)
                                   : static_cast<const void*>(&missing_float),
                  field.bytes);
    point += field.bytes;
  }
}

/** \brief The range_grid of an image; null: there is none.
 * \throws std::runtime_error if it cannot be that of the header's columns and rows
 */
const PlyElement*
findGrid(const PlyHeader& header)
{
  const auto grid = std::find_if(
      header.elements.begin(), header.elements.end(), [](const PlyElement& element) {
        return element.name == "range_grid";
      });
  if (grid == header.elements.end() || header.columns == 0 || header.rows == 0)
    return nullptr;
  if (header.columns > grid->count || header.rows > grid->count ||
      header.columns * header.rows != grid->count)
    fail("num_cols x num_rows and the number of elements range_grid in its header "
         "differ");
  if (grid->has_unknown || grid->properties.size() != 1 || !grid->properties[0].count ||
      grid->properties[0].field.kind == FieldKind::Real)
    fail("the elements range_grid in its header are no lists of vertices");
  return &*grid;
}

/** \brief Refuses sizes that do not agree. */
void
checkSizes(const PlyHeader& header, const PlyElement& vertices, std::uint64_t bytes)
{
  const std::uint64_t point_bytes = bytesOf(PlyReader::fieldsOf(vertices));
  const std::uint64_t least_bytes =
      header.is_text ? 2 * vertices.properties.size() : point_bytes;
  constexpr std::uint64_t most_points = std::uint64_t{1} << 31;
  if (vertices.count > most_points)
    fail("its header promises " + std::to_string(vertices.count) +
         " vertices, which is too many");
  if (vertices.count > bytes ||
      vertices.count * least_bytes > bytes + (header.is_text ? 1 : 0))
    fail("it was cut off, or its header is wrong: it promises " +
         std::to_string(vertices.count) + " vertices, and has " +
         std::to_string(bytes) + " bytes of them");
  const PlyElement* const grid = findGrid(header);
  if (grid == nullptr && header.columns > 0 && header.rows > 0 &&
      (header.columns > vertices.count || header.rows > vertices.count ||
       header.columns * header.rows != vertices.count))
    fail("num_cols x num_rows and the number of vertices in its header differ");
  // Each cell takes a byte of the file at least; empty ones become points, too.
  constexpr std::uint64_t most_times = 176;
  if (grid != nullptr && (grid->count > bytes || grid->count > most_points ||
                          grid->count * point_bytes > most_times * bytes))
    fail("its header promises an image that its points cannot fill");
}

/** \brief Sets the points of an image.
 * \param[in] grid the number of each point's vertex, or -1
 */
void
fillImage(const std::vector<FileField>& fields,
          const std::vector<std::uint8_t>& vertices,
          const std::vector<std::int64_t>& grid,
          pcl::PCLPointCloud2& cloud)
{
  const std::size_t step = cloud.point_step;
  cloud.data.assign(grid.size() * step, 0);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    std::uint8_t* const point = cloud.data.data() + i * step;
    if (grid[i] < 0)
      setMissing(fields, point);
    else if (static_cast<std::uint64_t>(grid[i]) < vertices.size() / step)
      std::memcpy(point, &vertices[static_cast<std::size_t>(grid[i]) * step], step);
    else
      fail("its image has a vertex that is not there");
  }
}

/** \brief What follows the vertices, the last elements of a file; empty if nothing
 * does. */
std::string
describeRest(std::istream& file,
             const PlyHeader& header,
             const PlyElement& vertices,
             std::uint64_t file_bytes)
{
  if (header.is_text)
    return describeFurtherLines(file, header.line_end);
  return describeFurtherPoints(file_bytes - static_cast<std::uint64_t>(file.tellg()),
                               bytesOf(PlyReader::fieldsOf(vertices)));
}

} // namespace

std::vector<std::string>
readPly(const std::string& path, pcl::PCLPointCloud2& cloud)
{
  std::ifstream file(path, std::ios::binary);
  const PlyHeader header = readPlyHeader(file);
  const std::uint64_t all_bytes = fs::file_size(path);
  const std::uint64_t bytes = all_bytes - std::min(all_bytes, header.bytes);
  const auto vertices =
      std::find_if(header.elements.begin(),
                   header.elements.end(),
                   [](const PlyElement& element) { return element.name == "vertex"; });
  if (vertices == header.elements.end())
    fail("its header has no vertices");
  const std::vector<FileField> fields = cloudFieldsOf(*vertices);
  if (fields.empty())
    fail("its vertices have no numbers");
  checkSizes(header, *vertices, bytes);
  const PlyElement* const grid_element = findGrid(header);
  PlyReader reader(file, header, bytes);
  std::vector<std::uint8_t> points;
  std::vector<std::int64_t> grid;
  for (auto element = header.elements.begin(); element != header.elements.end();
       ++element)
    if (element == vertices)
      points = reader.readVertices(*element);
    else if (&*element == grid_element)
      grid = reader.readGrid(*element);
    else if (element < vertices || grid_element != nullptr)
      reader.skip(*element);
  std::vector<std::string> remarks;
  if (header.elements.back().name == "vertex")
    if (std::string rest = describeRest(file, header, *vertices, all_bytes);
        !rest.empty())
      remarks.push_back(std::move(rest));
  bool is_image = header.columns > 0 && header.rows > 0;
  const bool has_gaps = grid_element != nullptr && mayBeMissing(fields);
  if (grid_element != nullptr && !has_gaps) {
    is_image = false;
    remarks.emplace_back(
        "its rows and columns are left out: whole numbers of x, y and z "
        "cannot tell where a point is missing");
  }
  startCloud(fields,
             is_image ? header.columns : vertices->count,
             is_image ? header.rows : 1,
             cloud);
  if (has_gaps)
    fillImage(fields, points, grid, cloud);
  else
    cloud.data = std::move(points);
  // PCL writes a camera into each file.
  for (const PlyElement& element : header.elements)
    if (element.count > 0 && element.name != "vertex" && element.name != "camera" &&
        &element != grid_element)
      remarks.push_back("its elements '" + shownText(element.name) + "' (" +
                        std::to_string(element.count) + ") are left out");
  for (const PlyProperty& property : vertices->properties)
    if (property.count)
      remarks.push_back("the property '" + shownText(property.field.name) +
                        "' of vertices is left out: it is a list");
  return remarks;
}

} // namespace clouds
} // namespace pcl_ext

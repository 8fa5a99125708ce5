// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Text in files of clouds: the words of headers, and points.
 */
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Throws std::runtime_error: a file cannot be read. */
[[noreturn]] void
fail(const std::string& reason);

/** \brief Type of the numbers of a field in a file. */
enum class FieldKind {
  Real,
  Signed,
  Unsigned,
  Ignored,
  IgnoredList ///< in text: how many numbers follow, and these; it has no bytes
};

/** \brief A field of points in a file: numbers that follow each other. */
struct FileField {
  std::string name;
  FieldKind kind = FieldKind::Real;
  std::uint64_t bytes = 4; ///< of a number
  std::uint64_t count = 1; ///< numbers
};

/** \brief Calls a function with a 0 of the type of a field's numbers.
 * \param[in] visit gives the same type of result for all
 */
template <typename VisitorT>
auto
visitZero(const FileField& field, const VisitorT& visit)
{
  if (field.kind == FieldKind::Real)
    return field.bytes == sizeof(float) ? visit(0.0f) : visit(0.0);
  const bool is_signed = field.kind == FieldKind::Signed;
  switch (field.bytes) {
  case 1:
    return is_signed ? visit(std::int8_t{}) : visit(std::uint8_t{});
  case 2:
    return is_signed ? visit(std::int16_t{}) : visit(std::uint16_t{});
  case 4:
    return is_signed ? visit(std::int32_t{}) : visit(std::uint32_t{});
  default:
    return is_signed ? visit(std::int64_t{}) : visit(std::uint64_t{});
  }
}

/** \brief A word in capitals, and in small letters, those of ASCII. */
std::string
upperCase(std::string word);
std::string
lowerCase(std::string word);

/** \brief Whether a field is x, y or z, in small letters or capitals. */
bool
isCoordinateName(const std::string& name);

/** \brief Bytes of a point of some fields. */
std::uint64_t
bytesOf(const std::vector<FileField>& fields);

/** \brief A text of a file for messages: short, and in letters of ASCII. */
std::string
shownText(std::string text);

/** \brief Most bytes of a header, so that files without one are known early. */
constexpr std::uint64_t most_header_bytes = std::uint64_t{1} << 20;

/** \brief The words of a line. */
std::vector<std::string>
wordsOf(const std::string& line);

/** \brief Whether a text is a number that countOf() takes. */
bool
isCount(const std::string& text);

/** \brief A number of a header.
 * \throws std::runtime_error if it is none, or too large for a cloud
 */
std::uint64_t
countOf(const std::string& name, const std::string& text);

/** \brief What some editors write before text in UTF-8. */
constexpr char byte_order_mark[] = "\xef\xbb\xbf";

/** \brief Most bytes of a line. */
constexpr std::uint64_t most_line_bytes = std::uint64_t{1} << 24;

/** \brief What ends the lines of a file: CR if the first one ends with CR alone, else
 * LF, before which lines may have a CR. The place in the file stays. */
char
lineEndOf(std::istream& file);

/** \brief Reads a line; a file of no lines is not read as one.
 * \param[in] end see lineEndOf()
 * \return false at the end, and if the line is longer than so many bytes
 */
bool
readLine(std::istream& file,
         std::string& line,
         char end,
         std::uint64_t most = most_line_bytes);

/** \brief Reads lines of points, which must have the numbers that the header promises;
 * lines between them may be blank.
 * \param[in] file at the first of the lines
 * \param[in] end of lines
 * \param[in] fields of a point; numbers of ignored ones become 0
 * \param[in] points their number
 * \param[in] header_lines before them, for messages
 * \param[out] bytes the numbers in the order of this machine, point after point
 * \throws std::runtime_error with the line and what is wrong in it
 */
void
readTextPoints(std::istream& file,
               char end,
               const std::vector<FileField>& fields,
               std::uint64_t points,
               std::uint64_t header_lines,
               std::vector<std::uint8_t>& bytes);

/** \brief Says that more lines of a text follow the points that its header promises;
 * empty if none do. */
std::string
describeFurtherLines(std::istream& file, char end);

/** \brief The same of bytes of further points. */
std::string
describeFurtherPoints(std::uint64_t further_bytes, std::uint64_t point_bytes);

} // namespace clouds
} // namespace pcl_ext

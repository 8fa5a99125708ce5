/** \file
 * \brief Points that files have as text.
 */
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief A field of points: numbers that follow each other in a line. */
struct TextField {
  enum class Kind { Real, Signed, Unsigned, Ignored };

  std::string name;
  Kind kind = Kind::Real;
  std::uint64_t bytes = 4; ///< of a number
  std::uint64_t count = 1; ///< numbers
};

/** \brief Reads a line; a file of no lines is not read as one.
 * \return false at the end, and if the line is longer than 64 KiB
 */
bool
readLine(std::istream& file, std::string& line);

/** \brief Checks that lines of points have the numbers that the header promises. PCL's reader
 * takes what it can of a word, or 0, and leaves out lines that are too many.
 * \param[in] file at the first of the lines
 * \param[in] fields of a point
 * \param[in] points their number
 * \param[in] header_lines before them, for messages
 * \param[in] may_have_empty_lines between points; PCL's reader of PLY takes none
 * \throws std::runtime_error with the line and what is wrong in it
 */
void
checkTextPoints(std::istream& file,
                const std::vector<TextField>& fields,
                std::uint64_t points,
                std::uint64_t header_lines,
                bool may_have_empty_lines);

} // namespace clouds
} // namespace pcl_ext

/** \file
 * \brief Headers of PCD and PLY files.
 */
#pragma once

#include <optional>
#include <string>

namespace pcl_ext {
namespace clouds {

/** \brief The lines of a PCD file's header that tell sensors apart. */
struct PcdHeader {
  std::string fields;
  std::string width;
  std::string height;
  std::string viewpoint;
};

/** \brief Reads the header of a PCD file.
 * \return nothing if the file is none, or lacks lines that a header must have
 */
std::optional<PcdHeader>
readPcdHeader(const std::string& path);

/** \brief True if the system tells that a file has no bytes. Some such files, as
 * /proc/kmsg, let their readers wait without end. */
bool
isEmptyFile(const std::string& path);

/** \brief Checks what PCL 1.13's reader does not, and crashes on: that the header is whole,
 * and that the points that it promises are in the file; that words are numbers; and that
 * nothing follows which it would leave out. A cloud that passes takes at most 176 bytes of
 * memory for each byte of its file.
 * \throws std::runtime_error with what is wrong
 */
void
checkPcd(const std::string& path);

/** \brief Checks what PCL's reader only asserts: that the header agrees with itself, and that
 * the points that it promises can be in the file; and that words are numbers.
 * \throws std::runtime_error with what is wrong
 */
void
checkPly(const std::string& path);

} // namespace clouds
} // namespace pcl_ext

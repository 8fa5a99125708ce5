#pragma once

#include <string>

namespace pcl_ext {
namespace tools {

/** \brief Copies the standard input to a file that has no name, as reading a recording needs
 * to go back and forth.
 * \return a path to it, valid until the program ends
 * \throws std::runtime_error if that fails
 */
std::string
keepStandardInput();

/** \brief The path itself, or that of the standard input if it is "-". */
std::string
pathOfInput(const std::string& path);

/** \brief A path, or a message with paths, for people: the standard input has a name there.
 */
std::string
shown(std::string text);

} // namespace tools
} // namespace pcl_ext

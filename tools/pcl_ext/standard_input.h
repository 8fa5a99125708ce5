#pragma once

#include <string>

namespace pcl_ext {
namespace tools {

/** \brief A path at which an input can be read at any place and more than once: its own; for
 * the standard input, which is "-", and for a pipe that of a copy without a name, which is
 * there until the program ends.
 * \throws std::runtime_error if it cannot be copied
 */
std::string
pathOfInput(const std::string& path);

/** \brief The name that an input has in names of streams: that of its file without
 * extension, "stdin" for the standard input. */
std::string
streamNameOfInput(const std::string& path);

/** \brief A path, or a message with paths, for people: inputs that were copied have the
 * names that the user gave.
 */
std::string
shown(std::string text);

} // namespace tools
} // namespace pcl_ext

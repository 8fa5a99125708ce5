#pragma once

#include <CLI/App.hpp>

#include <iosfwd>

namespace pcl_ext {
namespace tools {

/** \brief Writes a completion for bash: commands, their options, and the values of options
 * that have a few; else the names of files. */
void
writeBashCompletion(const CLI::App& program, std::ostream& output);

} // namespace tools
} // namespace pcl_ext

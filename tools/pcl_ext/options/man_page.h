#pragma once

#include <CLI/App.hpp>

#include <iosfwd>

namespace pcl_ext {
namespace tools {

/** \brief Writes the man page of a program with subcommands, from its options. */
void
writeManPage(const CLI::App& program, std::ostream& output);

} // namespace tools
} // namespace pcl_ext

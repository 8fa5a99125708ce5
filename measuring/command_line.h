// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <exception>
#include <functional>
#include <iostream>

namespace pcl_ext {
namespace measuring {

/** \brief Reads the command line of a measuring program and runs it.
 * \param[in,out] program its options
 * \param[in] argc,argv of main
 * \param[in] run what to do then
 * \return the exit status: 1 if the command line is invalid or run throws, after a
 * message
 */
inline int
runProgram(CLI::App& program,
           int argc,
           const char* const* argv,
           const std::function<void()>& run)
{
  try {
    program.parse(argc, argv);
    run();
    return 0;
  }
  catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 1;
  }
  catch (const std::exception& error) {
    std::cerr << program.get_name() << ": " << error.what() << '\n';
    return 1;
  }
}

} // namespace measuring
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace pcl_ext::tools {

/** \brief Exit statuses of the program. */
enum ExitStatus : int {
  all_done = 0,
  something_failed = 1, ///< something was lost, damaged or could not be read or written
  wrong_command_line = 2,
  interrupted = 130 ///< by SIGINT or SIGTERM; what was done until then is complete
};

/** \brief What ends a command with something_failed is any other exception; this one
 * ends it with wrong_command_line. */
class UsageError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace pcl_ext::tools {

/** \brief A text for a terminal. Names from files may have any bytes: control
 * characters, line ends among them, and bytes that are not UTF-8 become \\x1b and so
 * on, so that a name cannot move the cursor or look like another line. */
std::string
printable(const std::string& text);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace pcl_ext {
namespace tools {

/** \brief A message of the library with the options of the program in place of the
 * names of settings: --intensity-range for intensity_range. */
std::string
withOptionNames(const std::string& message);

} // namespace tools
} // namespace pcl_ext

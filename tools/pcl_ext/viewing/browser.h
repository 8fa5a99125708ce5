// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace pcl_ext::tools {

/** \brief Opens a page in the user's browser, if there is a desktop; does not wait for
 * it.
 * \return true if a program was started
 */
bool
openBrowser(const std::string& url);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "clouds/file_text.h"

#include <CLI/App.hpp>

#include <vector>

namespace pcl_ext::tools {

/** \brief Adds --bin-fields, the fields of files without a header. */
void
addBinFields(CLI::App& app, std::vector<clouds::FileField>& fields);

} // namespace pcl_ext::tools

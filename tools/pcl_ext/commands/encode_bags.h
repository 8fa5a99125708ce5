// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "commands/bag_encoding.h"

#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Encodes several bags, each into a recording of a folder, and goes on where a
 * run before ended: see Manifest.
 * \param[in] options whose output is the folder
 * \param[in] bags paths
 * \param[in] manifest_options with which they are encoded, as text
 * \return the exit status
 * \throws UsageError before anything is written, if the command line is not one for
 * them
 * \throws std::runtime_error if the manifest cannot be written
 */
int
encodeBags(const EncodeOptions& options,
           const std::vector<std::string>& bags,
           const std::string& manifest_options);

} // namespace pcl_ext::tools

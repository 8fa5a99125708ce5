// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace pcl_ext::tools {

/** \brief Adds a comment to a PCD or PLY file by which isOurs() knows it. */
void
markAsOurs(std::vector<std::uint8_t>& file);

/** \brief Whether a PCD or PLY file was written by this program: a later run may remove
 * it. False if it cannot be read. */
bool
isOurs(const std::filesystem::path& file);

} // namespace pcl_ext::tools

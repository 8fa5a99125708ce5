// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Names bytes of another format by their beginning, and how to read them; empty
 * if they are not recognised.
 * \param[in] bytes the first bytes, foreign_bytes_size of them if there are as many
 * \param[in] size number of bytes
 */
std::string
describeForeignBytes(const std::uint8_t* bytes, std::size_t size);

/** \brief Number of bytes that identify a format. */
constexpr std::size_t foreign_bytes_size = 32;

} // namespace pcl_ext::PCL_EXT_ABI::io

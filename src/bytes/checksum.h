// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief CRC-32 (ISO-HDLC) of a checksum followed by bytes, which chains frames.
 * \param[in] reference_checksum four bytes, little-endian
 * \param[in] bytes the bytes; may be null if there are none
 * \param[in] size number of bytes
 */
std::uint32_t
chainedChecksum(std::uint32_t reference_checksum,
                const std::uint8_t* bytes,
                std::size_t size);

} // namespace pcl_ext::PCL_EXT_ABI::io

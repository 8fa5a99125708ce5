// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "stream/foreign_bytes.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The format of a frame, by its magic bytes. */
enum class FoundFormat { None, Version1, Published };

/** \brief The bytes that a search began with, to name another format. */
struct FirstBytes {
  std::array<std::uint8_t, foreign_bytes_size> bytes;
  std::size_t size = 0;
};

/** \brief Reads up to and including the next magic bytes of either format.
 * \param[in,out] source where to read
 * \param[in,out] last_bytes the last 8 bytes read, the newest one lowest; an
 * interrupted search continues with them
 * \param[out] first the first of the bytes that were read
 */
FoundFormat
findFrame(ByteSource& source, std::uint64_t& last_bytes, FirstBytes& first);

/** \brief Number of bytes at the end of the input that may be the beginning of a frame.
 * \param[in] last_bytes as above
 */
std::size_t
incompleteMagicSize(std::uint64_t last_bytes);

/** \brief The status of a search that found nothing.
 * \param[in] source after the search
 * \param[in] first the bytes that it began with
 * \param[in] max_bytes the limit of the search
 */
CompressionStatus
noFrame(const ByteSource& source, const FirstBytes& first, std::size_t max_bytes);

/** \brief The format of a frame that begins with some bytes, or may do so if more
 * arrive.
 * \param[in] bytes the first byte
 * \param[in] count number of bytes; of none Version1 may be the beginning
 */
FoundFormat
possibleFormat(const std::uint8_t* bytes, std::size_t count);

} // namespace pcl_ext::PCL_EXT_ABI::io

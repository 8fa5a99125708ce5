// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief Names of compressions in chunks. */
constexpr char no_compression[] = "";
constexpr char zstd_compression[] = "zstd";
constexpr char lz4_compression[] = "lz4";

/** \brief Decompresses the records of a chunk, as far as they are whole. Memory is
 * allocated as bytes appear, not for the size that the chunk declares.
 * \param[in] compression name of the compression
 * \param[in] bytes the compressed bytes, of which the end may be missing
 * \param[in] size number of bytes
 * \param[in] max_size more uncompressed bytes are an error
 * \param[out] records its memory is reused; what could be decompressed, also after an
 * error
 * \return empty, or what is wrong
 */
std::string
decompress(const std::string& compression,
           const std::uint8_t* bytes,
           std::size_t size,
           std::uint64_t max_size,
           std::vector<std::uint8_t>& records);

/** \brief The same for bz2, which chunks of ROS 1 may have and those of MCAP may not. */
std::string
decompressBz2(const std::uint8_t* bytes,
              std::size_t size,
              std::uint64_t max_size,
              std::vector<std::uint8_t>& records);

/** \brief Compresses the records of a chunk with zstd.
 * \param[in] records the records
 * \param[out] bytes its memory is reused
 * \return false if the bytes would not be fewer, or zstd failed
 */
bool
compress(const std::vector<std::uint8_t>& records, std::vector<std::uint8_t>& bytes);

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap

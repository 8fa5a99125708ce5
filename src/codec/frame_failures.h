// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Statuses of frames that cannot be decoded, worded alike for both formats.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"

#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

CompressionStatus
corruptFrame(const std::string& what);

/** \brief A late or repeated frame. */
CompressionStatus
oldFrame(std::uint32_t number);

/** \brief A P-frame whose previous frame was not decoded.
 * \param[in] number of the P-frame
 * \param[in] last_number of the last decoded frame, if there is one
 */
CompressionStatus
missingReference(std::uint32_t number, const std::optional<std::uint32_t>& last_number);

/** \brief A P-frame whose previous frame was decoded, and then dropped.
 * \param[in] number of the P-frame
 * \param[in] limit of the MemoryBudget, bytes
 */
CompressionStatus
droppedReference(std::uint32_t number, std::size_t limit);

/** \brief A frame that would take more memory than there is.
 * \param[in] bytes that it takes at least
 * \param[in] limit of the MemoryBudget, bytes
 */
CompressionStatus
tooMuchMemory(std::uint64_t bytes, std::size_t limit);

/** \brief A read beyond the end of the input or beyond the limit on bytes.
 * \param[in] source whose read failed
 * \param[in] part of the frame in which it failed, with its article
 */
CompressionStatus
failedRead(const ByteSource& source, const std::string& part);

/** \brief Checks the number of voxels that a header declares, or of points of a scan.
 * \param[in] what they are, in the plural
 */
CompressionStatus
checkVoxelCount(std::uint64_t count,
                std::size_t max_voxels,
                const char* what = "voxels");

/** \brief Checks the voxel edge that a header declares. */
CompressionStatus
checkResolution(double resolution);

} // namespace pcl_ext::PCL_EXT_ABI::io

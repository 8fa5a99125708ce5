// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

/** \brief The six bytes that a frame of the published layout begins with. */
constexpr char magic[] = "<HEAD>";
constexpr std::size_t magic_size = sizeof(magic) - 1;

/** \brief Header of a frame of the published layout, field by field as in
 * doc/bitstream.md. */
struct FrameHeader {
  std::uint32_t frame_number = 0; // a P-frame depends on the frame before it
  bool is_i_frame = true;
  std::uint64_t voxel_count = 0; // I only
  VoxelGrid grid;                // I only
};

/** \brief Appends magic bytes and header. */
void
writeFrameHeader(const FrameHeader& header, std::vector<std::uint8_t>& bytes);

/** \brief Reads and checks a frame header after the magic bytes.
 * \param[in,out] source after the magic bytes
 * \param[in] limits bounds on time and memory
 * \param[out] header the fields
 */
CompressionStatus
readFrameHeader(ByteSource& source, const DecoderLimits& limits, FrameHeader& header);

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

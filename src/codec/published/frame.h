// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "codec/frame_order.h"
#include "codec/published/frame_header.h"
#include "codec/published/occupancy_tree.h"

#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

/** \brief The last coded frame, which the next P-frame is coded relative to. */
struct History {
  bool has_frame = false;
  std::uint32_t frame_number = 0; // of the last frame; the first frame is 1
  VoxelGrid grid;
  OccupancyTree tree;
};

/** \brief Appends a frame in the layout that the paper's authors published
 * (doc/bitstream.md, "The published layout").
 * \param[in] frame intensities of 8 bits
 * \param[in] is_i_frame false only if the history holds a frame of the same grid
 * \param[in,out] history the previous frame; replaced by this frame, and unchanged if
 * memory runs out
 * \param[in,out] bytes the frame is appended
 * \param[out] statistics of this frame
 */
void
encodeFrame(const VoxelFrame& frame,
            bool is_i_frame,
            History& history,
            std::vector<std::uint8_t>& bytes,
            CodedFrameStatistics& statistics);

/** \brief Reads a frame after the magic bytes.
 * \param[in,out] source after the magic bytes
 * \param[in] limits bounds on time and memory
 * \param[in,out] history the previous frame; replaced by this frame on success, and
 * unchanged otherwise, also if memory runs out or the source throws
 * \param[in,out] order of the stream's frames
 * \param[out] frame the voxels; unspecified on failure
 * \param[out] statistics of this frame, without its size
 */
CompressionStatus
decodeFrame(ByteSource& source,
            const DecoderLimits& limits,
            History& history,
            FrameOrder& order,
            VoxelFrame& frame,
            CodedFrameStatistics& statistics);

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io

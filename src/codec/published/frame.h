#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "codec/frame_order.h"
#include "codec/published/occupancy_tree.h"

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace published {

/** \brief The six bytes that a frame of the published layout begins with. */
constexpr char magic[] = "<HEAD>";
constexpr std::size_t magic_size = sizeof(magic) - 1;

/** \brief The last frame that was coded, which the next P-frame is a difference to. */
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
 * \param[in,out] history the frame before this one; becomes this frame, and stays
 * untouched if memory runs out
 * \param[out] bytes where to append
 * \param[out] statistics of this frame
 */
void
encodeFrame(const VoxelFrame& frame,
            bool is_i_frame,
            History& history,
            std::vector<std::uint8_t>& bytes,
            CodedFrameStatistics& statistics);

/** \brief Reads a frame, of which the magic bytes have been read.
 * \param[in,out] source behind the magic bytes
 * \param[in] limits what decoding may cost
 * \param[in,out] history the frame before this one; becomes this frame on success and
 * stays untouched otherwise, also if memory runs out or the source throws
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
} // namespace io
} // namespace pcl_ext

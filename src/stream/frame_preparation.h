// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "codec/frame_limits.h"
#include "stream/stream_state.h"
#include "stream/version1_header.h"

#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief A frame whose header was read, and what it follows. */
struct FrameContext {
  const StreamState& last; ///< after the last frame
  const FrameLimits& limits;
  Version1Header& header;
  VoxelFrame& coarse_voxels; ///< of a frame with a refinement
};

/** \brief Completes the header of a P-frame, and sets all of a frame but what its voxels or
 * points are.
 * \param[in,out] payload is moved after the depth model
 * \return why the frame is refused; Ok
 */
CompressionStatus
prepareFrame(const FrameContext& context,
             const std::uint8_t*& payload,
             VoxelFrame& frame);

} // namespace pcl_ext::PCL_EXT_ABI::io

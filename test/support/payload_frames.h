/** \file
 * \brief Encodes payloads without a frame encoder.
 */
#pragma once

#include "codec/payload_coder.h"
#include "support/voxel_frames.h"

namespace pcl_ext {
namespace io {
namespace test {

/** \brief Appends the payload of a frame, which is matched before if it is a P-frame. */
inline PayloadSizes
encodePayload(PayloadCoder& coder,
              CodingWorkspace& memory,
              const VoxelFrame& frame,
              bool is_i_frame,
              std::vector<std::uint8_t>& payload)
{
  if (!is_i_frame)
    coder.match(memory, frame);
  return coder.encode(memory, frame, is_i_frame, payload);
}

} // namespace test
} // namespace io
} // namespace pcl_ext

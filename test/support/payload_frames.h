// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "codec/payload_coder.h"
#include "support/voxel_frames.h"

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief Appends the payload of a frame, which is matched before if it is a
 * P-frame. */
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

/** \brief Decodes a payload from memory of exactly its size, so that a sanitizer sees
 * reads after it; learn() or discard() has to follow.
 * \param[in] like grid, scale and depth model of the frame
 * \param[out] sizes of a payload that is valid
 * \return false if it is invalid
 */
inline bool
decodePayload(PayloadCoder& coder,
              CodingWorkspace& memory,
              const Bytes& payload,
              const VoxelFrame& like,
              std::size_t voxel_count,
              bool is_i_frame,
              VoxelFrame& back,
              PayloadSizes& sizes)
{
  Bytes exact = payload;
  exact.shrink_to_fit();
  back = like;
  back.keys = {1, 2, 3};
  back.intensities = {9, 9};
  PayloadSizes decoded_sizes;
  if (!coder.decode(
          memory,
          {exact.data(), exact.data() + exact.size(), voxel_count, is_i_frame},
          back,
          decoded_sizes))
    return false;
  EXPECT_TRUE(isConsistent(back));
  EXPECT_EQ(back.size(), voxel_count);
  EXPECT_EQ(decoded_sizes.occupancy + decoded_sizes.intensity, payload.size());
  sizes = decoded_sizes;
  return true;
}

inline void
expectDecoded(PayloadCoder& coder,
              CodingWorkspace& memory,
              const Bytes& payload,
              const VoxelFrame& frame,
              bool is_i_frame)
{
  VoxelFrame back;
  PayloadSizes sizes;
  ASSERT_TRUE(decodePayload(
      coder, memory, payload, frame, frame.size(), is_i_frame, back, sizes));
  expectSameFrame(back, frame);
}
} // namespace pcl_ext::PCL_EXT_ABI::io::test

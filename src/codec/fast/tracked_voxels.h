// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/fast/frame_blocks.h"
#include "codec/fast/history.h"
#include "codec/fast/models.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief For an encoder: groups the voxels into blocks, and divides these into tracked
 * and new ones.
 * \param[in] history before the frame
 * \param[in] keys Morton keys of the voxels, ascending, at least one
 * \param[out] frame occupied cells of tracked blocks, and the new blocks
 */
void
matchHistory(const History& history,
             const std::vector<std::uint64_t>& keys,
             FrameBlocks& frame);

/** \brief Number of tracked voxels of a frame, after matchHistory(). */
std::size_t
trackedVoxelCount(const History& history, const FrameBlocks& frame);

/** \brief Codes the occupancy of the tracked voxels (doc/bitstream_fast.md, "Tracked
 * voxels") bucket by bucket, and splits the buckets.
 *
 * A Coder is NibbleEncoder or NibbleDecoder.
 */
class TrackedVoxels {
public:
  /** \brief Codes a frame.
   * \param[in] before the history before the frame
   * \param[out] after its buckets are set
   * \param[in,out] frame a decoder sets the occupied cells
   * \return false if there are too few bytes; never in an encoder
   */
  template <class Coder>
  bool
  code(Coder& coder,
       Models& models,
       const History& before,
       History& after,
       FrameBlocks& frame);

private:
  template <class Coder>
  bool
  splitBucket(Coder& coder,
              Models& models,
              unsigned int past,
              const History& before,
              History& after,
              FrameBlocks& frame);

  std::vector<std::uint8_t> occupancies_; // of a bucket, eight voxels in each byte
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/supplement/coarse_voxels.h"
#include "voxels/ascending_keys.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Decides for an encoder whether I-frames are coded as coarse voxels that are
 * refined, which codes noise in a part of the time, and what is seen again in more
 * bytes. */
class RefinementChoice {
public:
  /** \brief Levels of the refinement of an I-frame; 0: none. */
  unsigned int
  levelsFor(const VoxelFrame& frame) const
  {
    return is_useful_ ? supplement::chooseRefinement(frame) : 0;
  }

  /** \brief Learns how many voxels of a P-frame without a refinement are tracked. */
  void
  followHistory(std::size_t tracked, std::size_t voxels)
  {
    is_useful_ = 4 * tracked < voxels;
  }

  /** \brief Remembers the voxels of a frame with a refinement. */
  void
  remember(const std::vector<std::uint64_t>& keys)
  {
    last_keys_.assign(keys.begin(), keys.end());
  }

  /** \brief Whether half of the voxels were in the last frame with a refinement, too:
   * then a history of them is worth more, and there is none from now on. */
  bool
  endsWith(const VoxelFrame& frame)
  {
    std::size_t repeated = 0;
    AscendingLookup<std::uint64_t> lookup(last_keys_);
    for (const std::uint64_t key : frame.keys)
      repeated += lookup.find(key) != not_in_list ? 1 : 0;
    if (frame.keys.empty() || 2 * repeated < frame.size())
      return false;
    is_useful_ = false;
    return true;
  }

  void
  releaseMemory()
  {
    last_keys_ = std::vector<std::uint64_t>();
  }

private:
  bool is_useful_ = true; // by the previous frames
  std::vector<std::uint64_t> last_keys_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

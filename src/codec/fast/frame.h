#pragma once

#include "codec/fast/history.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief One frame on its way through the fast coder: what its passes hand on. */
struct Frame {
  bool is_i_frame = false;
  unsigned int depth = 0; ///< of the grid
  std::size_t voxel_count = 0;

  // Occupied cells by block number of the history; of known voxels at first, in a
  // decoder, then of all.
  std::vector<std::uint64_t> occupied;

  // Blocks that the history does not know, ascending.
  std::vector<std::uint64_t> new_keys;
  std::vector<std::uint64_t> new_masks;

  // The frame's blocks, ascending; as many as `block_count` says.
  std::size_t block_count = 0;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint64_t> masks;
  std::vector<std::uint32_t> numbers; ///< in the history
  std::vector<VoxelPlace> places;     ///< of the voxels, in Morton order

  /** \brief Makes room for blocks. */
  void
  expectBlocks(std::size_t count)
  {
    ensureSize(keys, count);
    ensureSize(masks, count);
    ensureSize(numbers, count);
  }
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

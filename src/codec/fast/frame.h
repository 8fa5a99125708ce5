#pragma once

#include "codec/fast/history.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief One frame while it is coded: what its stages hand on. */
struct Frame {
  bool is_i_frame = false;
  unsigned int depth = 0; ///< of the grid
  std::size_t voxel_count = 0;

  /** \brief Occupied cells by block number of the history. In an encoder matchHistory()
   * fills it; in a decoder it grows with each voxel that is decoded. */
  std::vector<std::uint64_t> occupied;

  /** \brief Voxels decoded so far. */
  std::size_t found_voxels = 0;

  // Blocks that the history does not have, ascending.
  std::vector<std::uint64_t> new_keys;
  std::vector<std::uint64_t> new_masks;

  // From new voxels in known blocks. Of vectors with a count that many are in use.
  std::vector<std::uint8_t> octant_symbols; ///< by known block; 0 without new voxels
  std::size_t renewed_count = 0;
  std::vector<std::uint32_t>
      renewed_blocks; ///< known blocks with new voxels: their index

  // From the history's update: the frame's blocks, ascending.
  std::size_t block_count = 0;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint64_t> masks;
  std::vector<std::uint32_t> numbers; ///< in the history
  std::vector<VoxelPlace> places;     ///< of the voxels, in Morton order

  /** \brief Makes room for blocks. */
  void
  ensureBlocks(std::size_t count)
  {
    ensureSize(keys, count);
    ensureSize(masks, count);
    ensureSize(numbers, count);
  }
};

} // namespace fast
} // namespace io
} // namespace pcl_ext

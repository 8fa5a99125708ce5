// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "outliers/density_blocks.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Maps positions in the grids of a stream to positions in DensityBlocks. */
class PositionMap {
public:
  /** \brief Sets the grid of the stream's next frame.
   * \param[in] grid of the frame
   * \param[in] levels of the coarse voxels; of a resolution always the same
   * \return false if positions of previous frames are no longer valid, or there are
   * none
   */
  bool
  follow(const io::VoxelGrid& grid, unsigned int levels)
  {
    const bool is_same_lattice =
        has_lattice_ && grid.resolution == resolution_ && grid.origin == origin_;
    if (is_same_lattice && setOffset(grid))
      return true;
    has_lattice_ = true;
    resolution_ = grid.resolution;
    origin_ = grid.origin;
    levels_ = levels;
    // Blocks are aligned to those of the grid, with a margin on all sides. Coarse
    // voxels are aligned to the lattice, so that they are the same wherever a stream
    // begins.
    const std::int64_t width = std::int64_t{1} << levels_;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t first = grid.first_index[axis];
      index_of_0_[axis] = first - ((first % width + width) % width) - first_position;
    }
    setOffset(grid);
    return false;
  }

  /** \brief A coarse voxel is 2^levels voxels wide. */
  unsigned int
  levels() const
  {
    return levels_;
  }

  /** \brief Position of the grid's first voxel. */
  io::VoxelPosition
  first() const
  {
    return {offset_[0], offset_[1], offset_[2]};
  }

  io::VoxelPosition
  operator()(const io::VoxelPosition& position) const
  {
    return {position.x + offset_[0], position.y + offset_[1], position.z + offset_[2]};
  }

private:
  // A grid has at most 2^21 voxels on each axis.
  static constexpr std::int64_t first_position = std::int64_t{1} << 21;
  static constexpr std::int64_t margin = 4;

  bool
  setOffset(const io::VoxelGrid& grid)
  {
    std::array<std::int64_t, 3> offset;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      offset[axis] = grid.first_index[axis] - index_of_0_[axis];
      if (offset[axis] < margin << levels_ ||
          offset[axis] + grid.size() > DensityBlocks::position_end - margin)
        return false;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
      offset_[axis] = static_cast<std::uint32_t>(offset[axis]);
    return true;
  }

  bool has_lattice_ = false;
  double resolution_ = 0.0;
  std::array<double, 3> origin_{};
  unsigned int levels_ = 0;
  std::array<std::int64_t, 3> index_of_0_{}; ///< lattice index of position 0
  std::array<std::uint32_t, 3> offset_{};    ///< position of the grid's first voxel
};

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "voxels/block_directory.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief A number for each voxel of a block of 4 x 4 x 4. The index of a cell
 * increases fastest with z, then with y. */
using BlockCells = std::array<std::int16_t, 64>;

/** \brief f around a block: its 4 x 4 x 4 voxels and two more on each side. Rows are
 * along z; row 8 x + y. */
struct DensityWindow {
  static constexpr std::size_t width = 8;
  static constexpr std::size_t margin = 2;
  using Row = std::array<std::int16_t, width>;

  std::array<Row, width * width> rows;
};

/** \brief Sums of f around a voxel, in quarters of a density. */
struct NeighbourhoodSums {
  std::int32_t core;     ///< twice the voxel and its face neighbours
  std::int32_t ring;     ///< the other 3 x 3 x 3 voxels
  std::int32_t rim;      ///< the other 5 x 5 x 5 voxels
  std::int32_t all;      ///< the 5 x 5 x 5 voxels
  std::int32_t occupied; ///< number of the 5 x 5 x 5 that are not 0, if counted
};

/** \brief History of a VoxelOutlierRemoval: running means of the densities of a
 * stream's voxels, in blocks that are found by their position. Integers only, so that
 * means and sums are the same on all machines.
 */
class DensityBlocks {
public:
  /** \brief Positions of voxels are below this on each axis. */
  static constexpr std::uint32_t position_end = std::uint32_t{1} << 23;

  /** \brief What a density of 1 adds to its running mean: a quarter, in units of
   * 2^-6. */
  static constexpr std::int16_t mean_step = 16;

  /** \brief Most points of a voxel that setPoints() takes: sums of 16 fit into 15
   * bits. */
  static constexpr std::int16_t most_points = 2047;

  /** \brief Key of the block of a voxel: x, y, z in blocks, 21 bits each. Voxels must
   * be at least 4 voxels from 0 and position_end, so that every block has
   * neighbours. */
  static constexpr std::uint64_t
  blockKey(std::uint32_t x, std::uint32_t y, std::uint32_t z)
  {
    return std::uint64_t{x >> 2} << 42 | std::uint64_t{y >> 2} << 21 | z >> 2;
  }

  static constexpr unsigned int
  cell(std::uint32_t x, std::uint32_t y, std::uint32_t z)
  {
    return (x & 3) << 4 | (y & 3) << 2 | (z & 3);
  }

  /** \brief Removes all blocks. */
  void
  clear();

  /** \brief Begins a frame: updates the running means for a frame without voxels,
   * removes blocks without means, and sets f to half the mean. */
  void
  age();

  /** \brief Number of blocks. */
  std::size_t
  size() const
  {
    return keys_.size();
  }

  /** \brief Index of the block with a key, which is added if it does not exist. */
  std::uint32_t
  blockAt(std::uint64_t key);

  /** \brief Adds a voxel of the frame to its running mean, and sets f to its density.
   * \param[in] block index of its block
   * \param[in] cell of the block; each once a frame
   * \param[in] density 1..255
   */
  void
  add(std::uint32_t block, unsigned int cell, std::int16_t density);

  /** \brief Sets f to a number of points instead, without a running mean, in whole
   * points in place of quarters.
   * \param[in] block, cell as above
   * \param[in] points 1..most_points
   */
  void
  setPoints(std::uint32_t block, unsigned int cell, std::int16_t points)
  {
    fields_[block][cell] = points;
  }

  /** \brief f of a voxel. */
  std::int16_t
  field(std::uint32_t block, unsigned int cell) const
  {
    return fields_[block][cell];
  }

  /** \brief Position of a voxel, which blockKey() and cell() are made of. */
  io::VoxelPosition
  position(std::uint32_t block, unsigned int cell) const
  {
    constexpr std::uint64_t axis = (std::uint64_t{1} << 21) - 1;
    const std::uint64_t key = keys_[block];
    return {static_cast<std::uint32_t>(key >> 42) << 2 | cell >> 4,
            static_cast<std::uint32_t>(key >> 21 & axis) << 2 | (cell >> 2 & 3),
            static_cast<std::uint32_t>(key & axis) << 2 | (cell & 3)};
  }

  /** \brief Running mean of a voxel, in units of 2^-6. */
  std::int16_t
  mean(std::uint32_t block, unsigned int cell) const
  {
    return means_[block][cell];
  }

  /** \brief Removes all blocks except some.
   * \param[in] kept indices of the blocks, ascending
   */
  void
  keepOnly(const std::vector<std::uint32_t>& kept);

  /** \brief Releases unused memory. */
  void
  releaseMemory();

  /** \brief Copies f around some cells of a block.
   * \param[in] block index of the block
   * \param[in] cells mask of the cells, not 0
   * \param[out] window f in the voxels that are at most 2 from one of the cells on each
   * axis; elsewhere f or 0
   */
  void
  collect(std::uint32_t block, std::uint64_t cells, DensityWindow& window) const;

private:
  // By block.
  std::vector<std::uint64_t> keys_;
  std::vector<BlockCells> means_;  // running means of the densities, in units of 2^-6
  std::vector<BlockCells> fields_; // f of VoxelOutlierRemoval, in units of 2^-2
  io::BlockDirectory directory_;
};

/** \brief Computes the sums around some cells of a block.
 * \tparam counts whether to count the occupied voxels
 * \param[in] window from DensityBlocks::collect()
 * \param[in] cells mask of the cells
 * \param[out] sums by cell; others are not written
 */
template <bool counts>
void
sumNeighbourhoods(const DensityWindow& window,
                  std::uint64_t cells,
                  std::array<NeighbourhoodSums, 64>& sums);

} // namespace pcl_ext::PCL_EXT_ABI

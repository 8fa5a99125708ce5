#pragma once

#include "voxels/block_directory.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {

/** \brief A number for each voxel of a block of 4 x 4 x 4; cells are numbered with z the
 * fastest, then y, then x. */
using BlockCells = std::array<std::int16_t, 64>;

/** \brief The blocks around one: its own 4 x 4 x 4 voxels and two more on each side. Rows
 * run along z; row 8 x + y. */
struct DensityWindow {
  static constexpr std::size_t width = 8;
  static constexpr std::size_t margin = 2;
  using Row = std::array<std::int16_t, width>;

  std::array<Row, width * width> rows;
};

/** \brief Sums of f about one voxel, in 2^-2 of a density. */
struct NeighbourhoodSums {
  std::int32_t core;     ///< twice the voxel and its face neighbours
  std::int32_t ring;     ///< the rest of the 3 x 3 x 3 voxels
  std::int32_t rim;      ///< the rest of the 5 x 5 x 5 voxels
  std::int32_t all;      ///< the 5 x 5 x 5 voxels
  std::int32_t occupied; ///< those of the 5 x 5 x 5 that are not 0, if they are counted
};

/** \brief What a VoxelOutlierRemoval remembers: the densities of a stream's voxels, 255 at
 * most, in blocks that are found by their place. Integers only, so that means and sums
 * are the same on all machines.
 */
class DensityBlocks {
public:
  /** \brief Axis positions of voxels are below this. */
  static constexpr std::uint32_t position_end = std::uint32_t{1} << 23;

  /** \brief The place of a block: x, y, z in blocks, 21 bits each. Voxels stay 4 voxels
   * away from 0 and position_end, so that every block has neighbours. */
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

  /** \brief Forgets everything. */
  void
  clear();

  /** \brief Lets the running means fall by a frame, as where no voxel is, and forgets
   * blocks that have none; f is half the mean. */
  void
  age();

  /** \brief Number of blocks; their indices are below. */
  std::size_t
  size() const
  {
    return keys_.size();
  }

  /** \brief Index of a block, which is added if it is not there. */
  std::uint32_t
  blockAt(std::uint64_t key);

  /** \brief A voxel of the frame that the last age() began; f is its density.
   * \param[in] block index of its block
   * \param[in] cell of the block; each once a frame
   * \param[in] density 1..255
   */
  void
  add(std::uint32_t block, unsigned int cell, std::int16_t density);

  /** \brief Sets everything but some blocks to nothing.
   * \param[in] kept indices of the blocks, ascending
   */
  void
  keepOnly(const std::vector<std::uint32_t>& kept);

  /** \brief Gives back the memory that the blocks do not need. */
  void
  giveBackMemory();

  /** \brief Collects what lies around the cells of a block.
   * \param[in] block index of the block
   * \param[in] cells those for which it is wanted, not 0
   * \param[out] window f in those voxels that are at most 2 from one of the cells on every
   * axis; elsewhere f or 0
   */
  void
  collect(std::uint32_t block, std::uint64_t cells, DensityWindow& window) const;

private:
  void
  listBlocks();

  // Of each block.
  std::vector<std::uint64_t> keys_;
  std::vector<BlockCells> means_;  // running means of the densities, in 2^-6
  std::vector<BlockCells> fields_; // f of VoxelOutlierRemoval, in 2^-2
  io::BlockDirectory directory_;
};

/** \brief Sums about the voxels of a block.
 * \tparam counts count occupied voxels, too
 * \param[in] window around the block
 * \param[in] cells those for which sums are wanted
 * \param[out] sums by cell; only those are written
 */
template <bool counts>
void
sumNeighbourhoods(const DensityWindow& window,
                  std::uint64_t cells,
                  std::array<NeighbourhoodSums, 64>& sums);

} // namespace pcl_ext

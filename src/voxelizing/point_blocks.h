// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxelizing/located_points.h"
#include "voxelizing/voxel_sums.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Collects points into the occupied voxels of a grid, sorted by Morton key,
 * with sums over the points of each.
 *
 * Voxels are grouped into blocks of 4 x 4 x 4, so that only blocks are sorted. Blocks
 * are kept from cloud to cloud, so that only new ones are sorted; if too many are
 * empty, the empty ones are dropped. Runs of points in the same voxel are summed up by
 * voxel at the end, and dense clouds, which have many, also on the way: their memory is
 * that of their voxels.
 *
 * Blocks are found by a hash table with a limited number of probes. If all probed slots
 * are taken, a block takes the slot of another one; if that one occurs again it gets a
 * second entry, and the parts are united when the voxels are written. Thus even a cloud
 * constructed to collide costs at most a sort of its points, and memory is proportional
 * to the number of points, not to the size of the grid.
 */
class PointBlocks {
public:
  PointBlocks();

  /** \brief Removes all points and blocks; for another grid, or after points that were
   * not written. */
  void
  reset();

  /** \brief Begins a cloud. Points of the last one must have been written.
   * \param[in] fields what the points have and voxels sum up
   */
  void
  begin(const SummedFields& fields);

  /** \brief Adds points. */
  void
  add(const LocatedPoints& located);

  /** \brief True if there are too few points per block, so that SortedVoxels is faster
   * and takes less memory.
   * \param[in] points number of points added
   */
  bool
  areTooSparse(std::size_t points) const;

  /** \brief Writes the voxels, and removes the points.
   * \param[out] keys Morton keys of the voxels, strictly ascending
   * \param[out] sums of the points in each voxel
   */
  void
  writeVoxels(std::vector<std::uint64_t>& keys, VoxelSums& sums);

  /** \brief Number of occupied blocks, after writeVoxels(). */
  std::size_t
  occupiedBlocks() const
  {
    return occupied_count_;
  }

private:
  struct KeyedBlock {
    std::uint64_t key; ///< Morton key of the block
    std::uint32_t block;
  };

  /** \brief Sums over consecutive points in the same voxel. */
  struct Run {
    std::size_t slot;
    double intensity;
    PackedColours colours;
  };

  /** \brief Where the voxels of a block were written. */
  struct WrittenBlock {
    std::uint64_t occupied; ///< a bit for each voxel
    std::size_t first_voxel;
  };

  static constexpr std::uint8_t most_in_a_slot = 255;
  static constexpr std::uint64_t hash_factor =
      0x9e3779b97f4a7c15; // 2^64 / golden ratio

  /** \brief The hash table, for loops whose stores might alias the members. */
  struct Table {
    const std::uint32_t* entries;
    unsigned int shift;

    /** \brief First entry to probe for a block. Multiplied twice, as with one
     * multiplication the blocks of a plane collide. */
    std::size_t
    firstTry(std::uint64_t block) const
    {
      const std::uint64_t mixed = block * hash_factor;
      return static_cast<std::size_t>((mixed ^ mixed >> 32) * hash_factor >> shift);
    }
  };

  Table
  tableOf() const
  {
    return {table_.data(), hash_shift_};
  }

  std::size_t
  findOrInsert(std::uint64_t block);

  std::size_t
  findSlot(std::uint64_t block) const;

  template <bool has_intensities, bool has_colours>
  void
  addFields(const LocatedPoints& located);

  void
  makeRoomForRuns(std::size_t count);

  void
  sumRunsBySlot();

  void
  dropEmptyBlocks();

  void
  fillTable();

  void
  sortNewBlocks();

  void
  uniteParts();

  void
  unite(std::size_t block, std::size_t part);

  std::size_t
  findOccupied();

  void
  writeBlock(const KeyedBlock& block,
             std::vector<std::uint64_t>& keys,
             VoxelSums& sums);

  void
  writeSums(VoxelSums& sums);

  void
  takeSlotSums(std::size_t block, VoxelSums& sums);

  std::size_t
  voxelOf(std::size_t slot) const;

  std::vector<std::uint32_t> table_; // indices of blocks, 0 in empty slots
  unsigned int hash_shift_ = 0;
  SummedFields fields_;

  // By index of the block; index 0 is not used.
  std::vector<std::uint64_t> blocks_; // as in BlockVoxel
  std::vector<WrittenBlock> written_; // after writeVoxels()
  std::vector<std::uint8_t> counts_;  // 64 slots per block: number of points

  // What the counts have no room for: each element is most_in_a_slot points.
  std::vector<std::size_t> full_slots_;

  // The last runs. Those before are summed up by slot, of clouds that have so many.
  std::vector<Run> runs_;
  std::size_t run_count_ = 0;
  bool has_slot_sums_ = false;
  std::vector<double> slot_intensities_;
  std::vector<ColourSum> slot_colours_;

  std::vector<std::uint64_t> kept_blocks_;

  std::vector<KeyedBlock> order_; // all blocks, sorted; after writeVoxels()
  std::vector<KeyedBlock> new_blocks_;
  std::vector<KeyedBlock> spare_blocks_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> parts_; // and their first parts
  std::vector<KeyedBlock> occupied_; // those with points; after writeVoxels()
  std::size_t occupied_count_ = 0;   // of occupied_, the rest is unused
};

} // namespace pcl_ext::PCL_EXT_ABI::io

#pragma once

#include "voxelizing/block_place.h"
#include "voxelizing/voxel_sums.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Collects points into the occupied voxels of a grid, sorted by Morton key, with sums
 * over the points of each.
 *
 * Voxels are grouped into blocks of 4 x 4 x 4, so that only blocks are sorted. Blocks are
 * kept from cloud to cloud, so that only new ones are sorted; if too many are empty, the
 * empty ones are dropped. A point is added to the sums of its voxel at once, so that dense
 * clouds touch no memory but that of their voxels.
 *
 * Blocks are found by a hash table with a limited number of probes. If all probed slots are
 * taken, a block takes the slot of another one; if that one occurs again it gets a second
 * entry, and the parts are united when the voxels are written. Thus even a cloud constructed
 * to collide costs at most a sort of its points, and memory is proportional to the number of
 * points, not to the size of the grid.
 */
class PointBlocks {
public:
  PointBlocks();

  /** \brief Removes all points and blocks; for another grid, or after points that were not
   * written. */
  void
  reset();

  /** \brief Begins a cloud. Points of the last one must have been written.
   * \param[in] fields what the points have and voxels sum up
   * \param[in] expected number of points to come, at most
   */
  void
  begin(const SummedFields& fields, std::size_t expected);

  /** \brief Adds points. */
  void
  add(const PlacedPoints& placed);

  /** \brief True if there are too few points per block, so that SortedVoxels is faster and
   * takes less memory.
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
    std::uint64_t points;
    double intensity;
    PackedColours colours;
  };

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
  findPlace(std::uint64_t block) const;

  void
  makeRoom(std::size_t entries);

  template <bool has_intensities, bool has_colours>
  void
  sumRuns(const PlacedPoints& placed);

  void
  addRuns();

  void
  dropEmptyBlocks();

  void
  fillTable();

  void
  sortNewBlocks();

  std::size_t
  uniteParts();

  std::size_t
  unite(std::size_t block, std::size_t part);

  std::vector<std::uint32_t> table_; // indices of blocks, 0 in empty slots
  unsigned int hash_shift_ = 0;
  SummedFields fields_;

  // By index of the block; index 0 is not used.
  std::vector<std::uint64_t> blocks_;          // as in BlockPlace
  std::vector<std::uint64_t> occupied_voxels_; // a bit for each; 0 between two clouds
  std::vector<std::uint32_t> slots_; // 64 per block: the entries of occupied voxels

  // Voxels in the order of their first points, which for scanned clouds are near each other
  // in memory, too.
  VoxelSums entries_;
  std::uint32_t entry_count_ = 0;

  std::array<Run, PlacedPoints::capacity> runs_; // of the points that were added last
  std::size_t run_count_ = 0;

  std::vector<std::uint64_t> kept_blocks_;

  std::vector<KeyedBlock> order_; // all blocks, sorted; after writeVoxels()
  std::vector<KeyedBlock> new_blocks_;
  std::vector<KeyedBlock> spare_blocks_;
  std::vector<KeyedBlock> occupied_;    // those with points; after writeVoxels()
  std::size_t occupied_count_ = 0;      // of occupied_, the rest is unused
  std::vector<std::uint32_t> entry_of_; // of each voxel, in their order
};

} // namespace io
} // namespace pcl_ext

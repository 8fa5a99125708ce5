#pragma once

#include "voxelizing/block_place.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief The voxels of a grid that points fall into: in the order of their Morton keys,
 * how many points are in each, and which points these are.
 *
 * Voxels are gathered as blocks of 4 x 4 x 4, so that only blocks are sorted, and blocks
 * stay from cloud to cloud, so that only new ones are. Most of those that stay are
 * occupied again; when too many are not, the empty ones are dropped.
 *
 * A hash table finds a point's block again. It looks at a few places only: a block that
 * finds none free takes another's, which then begins anew and is united with its other
 * part when voxels are written. So a cloud made to collide costs a sort of its points and
 * nothing worse, and memory follows the number of points, never the size of the grid.
 */
class PointBlocks {
public:
  PointBlocks();

  /** \brief Forgets the blocks, too; for another grid. */
  void
  reset();

  /** \brief Forgets all points. */
  void
  clear();

  /** \brief Adds points.
   * \param[in] placed the points
   * \param[out] added where they are, for voxelOf()
   */
  void
  add(const PlacedPoints& placed, std::size_t* added);

  /** \brief True if so many points are in blocks of their own that SortedVoxels would
   * take less time.
   * \param[in] points that were added
   */
  bool
  areTooSparse(std::size_t points) const;

  /** \brief Writes the voxels; before anything is added again, there is to be a clear().
   * \param[out] keys Morton keys of the voxels, strictly ascending
   * \param[out] counts number of points in each voxel
   */
  void
  writeVoxels(std::vector<std::uint64_t>& keys, std::vector<std::uint32_t>& counts);

  /** \brief The voxel that a point is in, after writeVoxels(): an index into the keys.
   * \param[in] added what add() returned
   */
  std::size_t
  voxelOf(std::size_t added) const
  {
    return first_voxels_[added / 64] + voxels_[added];
  }

  /** \brief Blocks that are occupied, after writeVoxels(). */
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

  struct OccupiedBlock {
    std::uint64_t key;      ///< Morton key of the block
    std::uint64_t occupied; ///< a bit for each voxel
    std::uint32_t block;
  };

  static constexpr std::uint8_t most_in_a_byte = 255;
  static constexpr std::uint64_t hash_factor =
      0x9e3779b97f4a7c15; // 2^64 / golden ratio

  /** \brief Where the table is looked at first for a block. Mixed twice, as blocks of a
   * plane are multiples of few steps, and so are their products. */
  std::size_t
  firstTry(std::uint64_t block) const
  {
    const std::uint64_t mixed = block * hash_factor;
    return ((mixed ^ mixed >> 32) * hash_factor) >> hash_shift_;
  }

  std::size_t
  findOrInsert(std::uint64_t block, std::size_t first_try);

  std::size_t
  findPlace(std::uint64_t block, std::size_t first_try) const;

  void
  dropEmptyBlocks();

  void
  fillTable();

  void
  sortNewBlocks();

  void
  uniteParts();

  std::size_t
  findOccupied();

  void
  writeBlock(const OccupiedBlock& block, std::uint64_t* keys, std::uint32_t* counts);

  std::vector<std::uint32_t> table_; // blocks, 0 where there is none
  unsigned int hash_shift_ = 0;

  // One for each block, and one before all that is none.
  std::vector<std::uint64_t> blocks_; // as in BlockPlace
  std::vector<std::uint8_t>
      voxels_; // 64 a block: their points; when written, their rank
  std::vector<std::size_t> first_voxels_; // when written

  std::vector<std::uint64_t> kept_blocks_;

  std::vector<KeyedBlock> order_; // of all blocks, when written
  std::vector<KeyedBlock> new_blocks_;
  std::vector<KeyedBlock> spare_blocks_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> parts_; // of which blocks
  std::vector<std::size_t> further_points_; // in voxels that are full
  std::vector<OccupiedBlock> occupied_;     // when written
  std::size_t occupied_count_ = 0;          // of occupied_; the rest is spare memory
};

} // namespace io
} // namespace pcl_ext

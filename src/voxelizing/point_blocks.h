#pragma once

#include "voxelizing/block_place.h"
#include "voxelizing/colour_sum.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Collects points into the occupied voxels of a grid, sorted by Morton key, with the
 * number of points in each and the voxel of each point.
 *
 * Voxels are grouped into blocks of 4 x 4 x 4, so that only blocks are sorted. Blocks are
 * kept from cloud to cloud, so that only new ones are sorted; if too many are empty, the
 * empty ones are dropped.
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

  /** \brief Removes all points and blocks; for another grid. */
  void
  reset();

  /** \brief Removes all points. Handles are kept in any case. */
  void
  clear(std::size_t expected = 0,
        bool keeps_handles = true,
        bool keeps_colours = false);

  /** \brief Adds points.
   * \param[in] placed the points
   * \param[out] added handles of the points, for voxelOf()
   */
  void
  add(const PlacedPoints& placed, std::size_t* added);

  /** \brief Sets the colours of the points that were added last.
   * \param[in] colours as of pcl::PointXYZRGB, in the order of the points
   * \param[in] added their handles
   * \param[in] count their number
   */
  void
  addColours(const std::uint32_t* colours, const std::size_t* added, std::size_t count);

  /** \brief True if there are too few points per block, so that SortedVoxels is faster.
   * \param[in] points number of points added
   */
  bool
  areTooSparse(std::size_t points) const;

  /** \brief Writes the voxels. Call clear() before points are added again.
   * \param[out] keys Morton keys of the voxels, strictly ascending
   * \param[out] counts number of points in each voxel
   */
  void
  writeVoxels(std::vector<std::uint64_t>& keys, std::vector<std::uint32_t>& counts);

  /** \brief Voxel of a point, after writeVoxels(): an index into the keys.
   * \param[in] added handle from add()
   */
  std::size_t
  voxelOf(std::size_t added) const
  {
    return first_voxels_[added / 64] + voxels_[added];
  }

  /** \brief Calls a function with the ColourSum of each voxel, in their order, after
   * writeVoxels(). */
  template <typename VisitT>
  void
  visitColourSums(VisitT&& visit)
  {
    colour_sums_.assign(voxel_count_, ColourSum());
    for (const ColouredPoint& point : coloured_points_)
      colour_sums_[voxelOf(point.added)].add(point.colour);
    for (const ColourSum& sum : colour_sums_)
      visit(sum);
  }

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

  struct OccupiedBlock {
    std::uint64_t key;      ///< Morton key of the block
    std::uint64_t occupied; ///< a bit for each voxel
    std::uint32_t block;
  };

  struct ColouredPoint {
    std::size_t added; ///< handle of the point
    std::uint32_t colour;
  };

  static constexpr std::uint8_t most_in_a_byte = 255;
  static constexpr std::uint64_t hash_factor =
      0x9e3779b97f4a7c15; // 2^64 / golden ratio

  /** \brief First slot to probe for a block. Multiplied twice, as with one multiplication the
   * blocks of a plane collide. */
  std::size_t
  firstTry(std::uint64_t block) const
  {
    const std::uint64_t mixed = block * hash_factor;
    return static_cast<std::size_t>((mixed ^ mixed >> 32) * hash_factor >> hash_shift_);
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

  std::vector<std::uint32_t> table_; // indices of blocks, 0 in empty slots
  unsigned int hash_shift_ = 0;

  // By index of the block; index 0 is not used.
  std::vector<std::uint64_t> blocks_; // as in BlockPlace
  std::vector<std::uint8_t>
      voxels_; // 64 per block: number of points; after writeVoxels() their rank
  std::vector<std::size_t> first_voxels_; // after writeVoxels()

  std::vector<std::uint64_t> kept_blocks_;

  std::vector<KeyedBlock> order_; // all blocks, sorted; after writeVoxels()
  std::vector<KeyedBlock> new_blocks_;
  std::vector<KeyedBlock> spare_blocks_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> parts_; // and their first parts
  std::vector<std::size_t> further_points_; // of voxels with more than most_in_a_byte
  std::vector<ColouredPoint> coloured_points_;
  std::vector<ColourSum> colour_sums_;  // by voxel
  std::size_t voxel_count_ = 0;         // after writeVoxels()
  std::vector<OccupiedBlock> occupied_; // after writeVoxels()
  std::size_t occupied_count_ = 0;      // of occupied_, the rest is unused
};

} // namespace io
} // namespace pcl_ext

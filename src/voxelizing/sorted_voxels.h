#pragma once

#include "voxelizing/block_place.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief The same as PointBlocks for clouds whose voxels are so far apart that blocks
 * of them would be nearly empty: all points are sorted. */
class SortedVoxels {
public:
  /** \brief Forgets all points. */
  void
  clear()
  {
    points_.clear();
  }

  /** \brief Adds points.
   * \param[in] placed the points
   * \param[out] added where they are, for voxelOf()
   */
  void
  add(const PlacedPoints& placed, std::size_t* added);

  /** \brief No cloud is. */
  static bool
  areTooSparse(std::size_t /*points*/)
  {
    return false;
  }

  /** \brief Writes the voxels.
   * \param[out] keys Morton keys of the voxels, strictly ascending
   * \param[out] counts number of points in each voxel
   */
  void
  writeVoxels(std::vector<std::uint64_t>& keys, std::vector<std::uint32_t>& counts);

  /** \brief The voxel that a point is in, after writeVoxels(): an index into the keys. */
  std::size_t
  voxelOf(std::size_t added) const
  {
    return voxel_of_[added];
  }

  /** \brief Blocks of 4 x 4 x 4 voxels that are occupied, after writeVoxels(). */
  std::size_t
  occupiedBlocks() const
  {
    return occupied_blocks_;
  }

private:
  struct Point {
    std::uint64_t key;
    std::uint32_t added;
  };

  std::vector<Point> points_;
  std::vector<Point> spare_points_;
  std::vector<std::uint32_t> voxel_of_;
  std::size_t occupied_blocks_ = 0;
};

} // namespace io
} // namespace pcl_ext

#pragma once

#include "voxelizing/block_place.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Same interface as PointBlocks, for sparse clouds whose blocks of voxels would be
 * nearly empty: sorts the points by their voxels. */
class SortedVoxels {
public:
  /** \brief Removes all points.
   * \param[in] expected number of points to come, at most
   * \param[in] keeps_handles whether voxelOf() will be called; else sorting takes half the
   * memory
   */
  void
  clear(std::size_t expected, bool keeps_handles);

  /** \brief Adds points.
   * \param[in] placed the points
   * \param[out] added handles of the points, for voxelOf(), if they are kept
   */
  void
  add(const PlacedPoints& placed, std::size_t* added);

  /** \brief Never; see PointBlocks. */
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

  /** \brief Voxel of a point, after writeVoxels(): an index into the keys. */
  std::size_t
  voxelOf(std::size_t added) const
  {
    return voxel_of_[added];
  }

  /** \brief Number of occupied blocks of 4 x 4 x 4 voxels, after writeVoxels(). */
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

  template <typename EntryT>
  void
  writeSorted(const std::vector<EntryT>& sorted,
              std::vector<std::uint64_t>& keys,
              std::vector<std::uint32_t>& counts);

  bool keeps_handles_ = true;
  // One of the two pairs is used.
  std::vector<Point> points_;
  std::vector<Point> spare_points_;
  std::vector<std::uint64_t> point_keys_;
  std::vector<std::uint64_t> spare_keys_;
  std::vector<std::uint32_t> voxel_of_;
  std::size_t occupied_blocks_ = 0;
};

} // namespace io
} // namespace pcl_ext

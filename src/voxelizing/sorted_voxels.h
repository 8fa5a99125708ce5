#pragma once

#include "voxelizing/block_place.h"
#include "voxelizing/colour_sum.h"

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
   * \param[in] keeps_handles whether voxelOf() will be called
   * \param[in] keeps_colours whether the points have colours; with neither, sorting
   * takes half the memory
   */
  void
  clear(std::size_t expected, bool keeps_handles, bool keeps_colours);

  /** \brief Adds points.
   * \param[in] placed the points
   * \param[out] added handles of the points, for voxelOf(), if they are kept
   */
  void
  add(const PlacedPoints& placed, std::size_t* added);

  /** \brief Sets the colours of the points that were added last, if they are kept.
   * \param[in] colours as of pcl::PointXYZRGB, in the order of the points
   * \param[in] added their handles
   * \param[in] count their number
   */
  void
  addColours(const std::uint32_t* colours, const std::size_t* added, std::size_t count);

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

  /** \brief Calls a function with the ColourSum of each voxel, in their order, after
   * writeVoxels(). */
  template <typename VisitT>
  void
  visitColourSums(VisitT&& visit)
  {
    ColourSum sum;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (i > 0 && points_[i].key != points_[i - 1].key) {
        visit(sum);
        sum = ColourSum();
      }
      sum.add(points_[i].colour);
    }
    if (!points_.empty())
      visit(sum);
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
    std::uint32_t colour;
  };

  template <typename EntryT>
  void
  writeSorted(const std::vector<EntryT>& sorted,
              std::vector<std::uint64_t>& keys,
              std::vector<std::uint32_t>& counts);

  bool keeps_handles_ = true;
  bool keeps_points_ = true; // for their handles or their colours
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

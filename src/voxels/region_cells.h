#pragma once

#include <pcl_ext/compression/voxel_regions.h>

#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief No levels: a voxel is left out. */
constexpr int left_out = -1;

/** \brief True if coarse voxels do not cross the faces of a grid. */
bool
isAligned(const VoxelGrid& grid, unsigned int levels);

/** \brief Key of the voxel that stands for a coarse one: its lowest.
 * \param[in] key of any voxel of the coarse one
 * \param[in] levels of the coarse voxel
 */
constexpr std::uint64_t
keyOfCoarseVoxel(std::uint64_t key, unsigned int levels)
{
  return key >> 3 * levels << 3 * levels;
}

/** \brief Finds the coarse voxels that the voxels of a grid are in.
 *
 * From the coarsest on down, the first one whose centre is in a region of at least its
 * levels is the one: none overlap, and which there are does not depend on which voxels
 * are occupied.
 */
class RegionCells {
public:
  /** \param[in] grid aligned to the most levels of the regions
   * \param[in] regions consistent; they must outlive this
   */
  RegionCells(const VoxelGrid& grid, const VoxelRegions& regions);

  /** \brief Levels of the coarse voxel that a voxel is in, or `left_out`. Fast if keys
   * ascend. */
  int
  levelsOf(std::uint64_t key);

private:
  using Point = std::array<std::int64_t, 3>; // half voxels

  int
  levelsAt(const Point& point) const;

  bool
  isIn(const Point& from_sensor, const RegionBox& box) const;

  bool
  isTaken(std::uint64_t key, unsigned int levels) const;

  /** \brief The last coarse voxel of some levels that was judged. */
  struct Judged {
    std::uint64_t key = ~std::uint64_t{0};
    bool is_taken = false;
  };

  const VoxelRegions& regions_;
  Point first_;  // lowest corner of the grid
  Point sensor_; // centre of its voxel
  unsigned int most_levels_;
  std::array<Judged, most_region_levels + 1> judged_;
};

} // namespace io
} // namespace pcl_ext

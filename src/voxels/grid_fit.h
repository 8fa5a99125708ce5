#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Lattice indices of this library's own streams are -2^20 .. 2^20 - 1. */
constexpr std::int64_t lattice_end = std::int64_t{1} << (max_grid_depth - 1);

/** \brief A range of lattice indices, both ends included. */
struct LatticeRange {
  std::array<std::int32_t, 3> lowest{};
  std::array<std::int32_t, 3> highest{};
};

/** \brief True if a part of the grid lies beyond the lattice. */
bool
leavesLattice(const VoxelGrid& grid);

/** \brief True if the grid holds the whole range. */
bool
containsRange(const VoxelGrid& grid, const LatticeRange& range);

/** \brief Depth of the smallest grid that holds a range. */
unsigned int
requiredDepth(const LatticeRange& range);

/** \brief The range of a grid. */
LatticeRange
rangeOf(const VoxelGrid& grid);

/** \brief The smallest range that holds two others. */
LatticeRange
unite(const LatticeRange& first, const LatticeRange& second);

/** \brief The smallest grid anchored at the world origin that holds a range, with the
 * range in its middle as far as the lattice reaches.
 * \param[in] resolution voxel edge, metres
 * \param[in] range within the lattice
 */
VoxelGrid
fitGrid(double resolution, const LatticeRange& range);

/** \brief The grid of this library's own streams for a fixed box; what of the box lies
 * beyond the lattice is left out. */
VoxelGrid
gridOfBox(double resolution, const BoundingBox& box);

/** \brief The grid that PCL's octree makes of a box in setResolution and
 * defineBoundingBox, which is the published layout's: a cube of 2^depth voxels about
 * the middle of the box, anchored at its lower corner. */
VoxelGrid
pclGridOfBox(double resolution, const BoundingBox& box);

} // namespace io
} // namespace pcl_ext

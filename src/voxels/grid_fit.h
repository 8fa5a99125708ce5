// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <array>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Lattice indices of stream version 1 are -2^20 .. 2^20 - 1. */
constexpr std::int64_t lattice_end = std::int64_t{1} << (max_grid_depth - 1);

/** \brief A range of lattice indices, both ends included. */
struct LatticeRange {
  std::array<std::int32_t, 3> lowest{};
  std::array<std::int32_t, 3> highest{};
};

/** \brief True if a lattice of stream version 1 may have this origin: each coordinate
 * is finite, and within 2^21 of the largest voxels of the world's origin. */
bool
isOrigin(const std::array<double, 3>& origin);

/** \brief True if a part of the grid is outside the lattice. */
bool
leavesLattice(const VoxelGrid& grid);

/** \brief True if the grid contains a range. */
bool
containsRange(const VoxelGrid& grid, const LatticeRange& range);

/** \brief Depth of the smallest grid that contains a range. */
unsigned int
requiredDepth(const LatticeRange& range);

/** \brief The range of a grid. */
LatticeRange
rangeOf(const VoxelGrid& grid);

/** \brief The smallest range that contains two others. */
PCL_EXT_CODEC_EXPORT LatticeRange
unite(const LatticeRange& first, const LatticeRange& second);

/** \brief The smallest grid on a lattice that contains a range, centred on the range as
 * far as the lattice allows.
 * \param[in] lattice a grid of the same lattice
 * \param[in] range within the lattice
 */
VoxelGrid
fitGrid(const VoxelGrid& lattice, const LatticeRange& range);

/** \brief The grid for further points: the same while it contains them, and is not far
 * too large.
 * \param[in] grid of earlier points; none: of the same lattice
 * \param[in] has_points whether there were any
 * \param[in] may_refit a grid that is far too large is fitted again
 * \param[in] range of the points
 */
PCL_EXT_CODEC_EXPORT VoxelGrid
adaptGrid(const VoxelGrid& grid,
          bool has_points,
          bool may_refit,
          const LatticeRange& range);

/** \brief The grid of stream version 1 for a fixed box, which is clipped to the
 * lattice.
 * \param[in] lattice a grid of the lattice
 * \param[in] box world coordinates, metres
 */
VoxelGrid
gridOfBox(const VoxelGrid& lattice, const BoundingBox& box);

/** \brief The world's origin, or on an axis where the box leaves its lattice a corner
 * of one of its voxels in the middle of the box. */
std::array<double, 3>
originFor(double resolution, const BoundingBox& box);

/** \brief The grid of the published layout for a fixed box, as PCL's octree makes it in
 * setResolution and defineBoundingBox: a cube of 2^depth voxels around the middle of
 * the box, anchored at its lower corner. */
VoxelGrid
pclGridOfBox(double resolution, const BoundingBox& box);

} // namespace pcl_ext::PCL_EXT_ABI::io

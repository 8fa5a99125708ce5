// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>

#include "simd/lanes.h"
#include "simd/vector_choice.h"
#include "voxelizing/lattice.h"
#include "voxelizing/located_points.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Distance of prefetching, bytes. */
constexpr std::size_t prefetch_distance = 2048;

/** \brief What is computed of a grid to locate points in it, with any kind of lanes. */
struct LocatorGrid {
  /** \param[in] grid any grid
   * \param[in] box points outside it are reported as uncertain
   * \param[in] is_rounded coordinates are doubles, rounded to floats: all that are near
   * a face are reported as uncertain
   */
  LocatorGrid(const VoxelGrid& grid,
              const std::optional<BoundingBox>& box,
              bool is_rounded = false);

  Lattice lattice; ///< with the grid as the usable range
  std::array<std::int32_t, 3> first_index;
  std::uint32_t size; ///< voxels along each axis

  float inverse_resolution;
  std::array<float, 3> first_centre; ///< of the grid's lowest voxel, in voxels
  std::int32_t beyond_grid; ///< the bits that are 0 in all positions of the grid
  bool is_rounded;          ///< the coordinates are rounded doubles
  float certain;  ///< largest certain distance from a voxel's centre, in voxels
  bool is_useful; ///< false if most points of the grid would be uncertain
  bool has_box;
  std::array<float, 3> box_min{};
  std::array<float, 3> box_max{};
};

/** \brief Points to be located. */
struct LocatorInput {
  const unsigned char* first; ///< x of the first; need not be aligned
  std::size_t stride;         ///< bytes from one x to the next, at least 12
  std::size_t count;          ///< at most LocatedPoints::capacity
  bool may_read_on;           ///< there is a float after the last z
};

/** \brief Bit i % 8 of number i / 8 is set if point i is certainly in the grid and the
 * box. */
using CertainPoints = std::array<std::uint8_t, LocatedPoints::capacity / 8>;

/** \brief Computes the voxels of points.
 * \param[in] grid the grid, which has to be useful
 * \param[in] points the points
 * \param[out] located blocks and voxels are written from the first element on, which
 * are valid for certain points only; their number is rounded up to a multiple of eight
 * \param[out] certain which ones these are
 */
void
locatePoints(const LocatorGrid& grid,
             const LocatorInput& points,
             LocatedPoints& located,
             CertainPoints& certain);

/** \brief The same with any kind of lanes. */
template <typename LanesT>
void
locatePointsWith(const LocatorGrid& grid,
                 const LocatorInput& points,
                 LocatedPoints& located,
                 CertainPoints& certain);

#if PCL_EXT_HAS_AVX2
extern template void
locatePointsWith<Avx2Lanes>(const LocatorGrid&,
                            const LocatorInput&,
                            LocatedPoints&,
                            CertainPoints&);
#endif

} // namespace pcl_ext::PCL_EXT_ABI::io

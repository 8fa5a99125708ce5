// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "simd/bit_operations.h"
#include "simd/lanes_target.h"
#include "simd/load_points.h"
#include "voxelizing/locate_points.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Computes the voxels of as many points at once as there are lanes.
 *
 * In single precision, which is exact except near the faces of a voxel; there a
 * coordinate is divided in double precision as by Lattice. The whole millimetres of
 * depth cameras are on faces of voxels of 0.1 mm, all of them.
 */
template <typename LanesT>
class PointLocator {
public:
  /** \brief See locatePoints(). */
  PCL_EXT_LANES_TARGET static void
  locate(const LocatorGrid& grid,
         const LocatorInput& points,
         LocatedPoints& located,
         CertainPoints& certain)
  {
    const PointLocator locator(grid);
    // Four floats of a point are read.
    const std::size_t kept_back = points.may_read_on ? 0 : 1;
    std::size_t i = 0;
    for (; i + 8 + kept_back <= points.count; i += 8) {
      const unsigned char* const first = points.first + i * points.stride;
      // A cloud is usually not in the caches.
      for (std::size_t point = 0; point < 8; point += 2)
        prefetch(first + prefetch_distance + point * points.stride);
      certain[i / 8] = static_cast<std::uint8_t>(
          locator.locateEight(first, points.stride, i, located));
    }
    if (i == points.count)
      return;
    std::array<float, 32> last{};
    const std::size_t count = points.count - i;
    for (std::size_t point = 0; point < count; ++point)
      std::memcpy(&last[4 * point],
                  points.first + (i + point) * points.stride,
                  3 * sizeof(float));
    const unsigned int bits =
        locator.locateEight(reinterpret_cast<const unsigned char*>(last.data()),
                            4 * sizeof(float),
                            i,
                            located);
    certain[i / 8] = static_cast<std::uint8_t>(bits & ((1u << count) - 1));
  }

private:
  // Built-in arrays, as template arguments lose the alignment of vector types.
  using Floats = typename LanesT::Floats;
  using Ints = typename LanesT::Ints;

  static constexpr unsigned int all_lanes = (1u << LanesT::width) - 1;

  PCL_EXT_LANES_TARGET explicit PointLocator(const LocatorGrid& grid)
  : inverse_resolution_(LanesT::all(grid.inverse_resolution))
  , beyond_grid_(LanesT::all(grid.beyond_grid))
  , certain_(LanesT::all(grid.certain))
  , beyond_last_centre_(LanesT::all(static_cast<float>(grid.size)))
  , has_box_(grid.has_box)
  , grid_(grid)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first_centre_[axis] = LanesT::all(grid.first_centre[axis]);
      box_min_[axis] = LanesT::all(grid.box_min[axis]);
      box_max_[axis] = LanesT::all(grid.box_max[axis]);
    }
  }

  /** \brief Computes the voxels of eight points.
   * \param[in] index where to write the first
   * \return bit i is set if point i is certainly in the grid and the box
   */
  PCL_EXT_LANES_TARGET unsigned int
  locateEight(const unsigned char* points,
              std::size_t stride,
              std::size_t index,
              LocatedPoints& located) const
  {
    unsigned int certain =
        locateLanes(points, stride, &located.blocks[index], &located.voxels[index]);
    if constexpr (LanesT::width == 4)
      certain |= locateLanes(points + 4 * stride,
                             stride,
                             &located.blocks[index + 4],
                             &located.voxels[index + 4])
                 << 4;
    return certain;
  }

  /** \brief Computes the voxels of a point a lane.
   * \param[in] points x of the first; four floats are read of each
   * \param[in] stride bytes from one x to the next
   * \param[out] blocks,voxels as in BlockVoxel; valid for certain points only
   * \return bit i is set if point i is certainly in the grid and the box
   */
  PCL_EXT_LANES_TARGET unsigned int
  locateLanes(const unsigned char* points,
              std::size_t stride,
              std::uint64_t* blocks,
              std::uint32_t* voxels) const
  {
    Floats point[3];
    loadPoints<LanesT>(points, stride, point[0], point[1], point[2]);
    Ints position[3];
    Ints in_box = LanesT::all(-1);
    unsigned int in_grid = all_lanes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Relative to the centre of the grid's first voxel, so that the position is the
      // nearest integer. The point is certain if it is far enough from the voxel's
      // faces.
      const Floats from_first = LanesT::subtract(
          LanesT::multiply(point[axis], inverse_resolution_), first_centre_[axis]);
      position[axis] = LanesT::round(from_first);
      const Floats from_centre = LanesT::absolute(
          LanesT::subtract(from_first, LanesT::toFloats(position[axis])));
      const unsigned int certain = LanesT::bitsOf(LanesT::less(from_centre, certain_));
      if (certain != all_lanes) {
        // The others, among them NaN, are farther from the grid than any error.
        const unsigned int near_grid =
            grid_.is_rounded
                ? 0 // a division would need the coordinate before it was rounded
                : LanesT::bitsOf(LanesT::bitAnd(
                      LanesT::lessOrEqual(LanesT::all(-1.0f), from_first),
                      LanesT::lessOrEqual(from_first, beyond_last_centre_)));
        in_grid &= certain | near_grid;
        if (const unsigned int unclear = ~certain & near_grid; unclear != 0)
          in_grid &= divide(axis, unclear, point[axis], position[axis]);
      }
      if (has_box_)
        in_box = LanesT::bitAnd(
            in_box,
            LanesT::bitAnd(LanesT::lessOrEqual(box_min_[axis], point[axis]),
                           LanesT::lessOrEqual(point[axis], box_max_[axis])));
    }
    // The grid's size is a power of two: positions outside have higher bits.
    const Ints higher_bits = LanesT::bitAnd(
        LanesT::bitOr(LanesT::bitOr(position[0], position[1]), position[2]),
        beyond_grid_);
    storeVoxels(position, blocks, voxels);
    return in_grid &
           LanesT::bitsOf(LanesT::bitAnd(in_box, LanesT::isZero(higher_bits)));
  }

  /** \brief Computes the positions of some points on an axis by division.
   * \param[in] wanted bit i is set if point i is one of them
   * \return bit i is not set if point i is one of them and outside the grid
   */
  PCL_EXT_LANES_TARGET unsigned int
  divide(std::size_t axis,
         unsigned int wanted,
         const Floats& coordinates,
         Ints& positions) const
  {
    std::array<float, LanesT::width> coordinate;
    LanesT::store(coordinates, coordinate.data());
    std::array<std::int32_t, LanesT::width> position;
    std::memcpy(position.data(), &positions, sizeof(positions));
    unsigned int outside = 0;
    for (; wanted != 0; wanted &= wanted - 1) {
      const unsigned int lane = lowestBit(wanted);
      std::int32_t index = grid_.first_index[axis];
      if (!grid_.lattice.indexOn(axis, static_cast<double>(coordinate[lane]), index))
        outside |= 1u << lane;
      position[lane] = index - grid_.first_index[axis];
    }
    std::memcpy(&positions, position.data(), sizeof(positions));
    return ~outside;
  }

  PCL_EXT_LANES_TARGET static void
  storeVoxels(const Ints (&position)[3], std::uint64_t* blocks, std::uint32_t* voxels)
  {
    const Ints within_block = LanesT::all(3);
    const Ints voxel = LanesT::bitOr(
        LanesT::bitOr(
            LanesT::template shiftLeft<4>(LanesT::bitAnd(position[0], within_block)),
            LanesT::template shiftLeft<2>(LanesT::bitAnd(position[1], within_block))),
        LanesT::bitAnd(position[2], within_block));
    LanesT::store(voxel, voxels);
    const Ints x = LanesT::template shiftRight<2>(position[0]);
    const Ints y = LanesT::template shiftRight<2>(position[1]);
    const Ints z = LanesT::template shiftRight<2>(position[2]);
    // Bits 0..31 and 32..56 of a block; y is in both.
    constexpr int bits = static_cast<int>(BlockVoxel::axis_bits);
    LanesT::storePairs(LanesT::bitOr(z, LanesT::template shiftLeft<bits>(y)),
                       LanesT::bitOr(LanesT::template shiftRight<32 - bits>(y),
                                     LanesT::template shiftLeft<2 * bits - 32>(x)),
                       blocks);
  }

  Floats inverse_resolution_;
  Ints beyond_grid_;
  Floats first_centre_[3];
  Floats certain_;
  Floats beyond_last_centre_; // of the grid's highest voxel, by one voxel, in voxels
  Floats box_min_[3];
  Floats box_max_[3];
  bool has_box_;
  const LocatorGrid& grid_;
};

template <typename LanesT>
void
locatePointsWith(const LocatorGrid& grid,
                 const LocatorInput& points,
                 LocatedPoints& located,
                 CertainPoints& certain)
{
  PointLocator<LanesT>::locate(grid, points, located, certain);
}

} // namespace pcl_ext::PCL_EXT_ABI::io

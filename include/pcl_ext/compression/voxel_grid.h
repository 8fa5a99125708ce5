// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Bits of a Morton key for each axis, which is the depth of the deepest
 * grid. */
constexpr unsigned int max_grid_depth = 21;

/** \brief Range of the voxel edge, metres. */
constexpr double smallest_resolution = 1e-6;
constexpr double largest_resolution = 1e6;

/** \brief An axis-aligned box, metres; both ends are included. In world coordinates
 * unless something else is said. */
struct BoundingBox {
  std::array<double, 3> min{};
  std::array<double, 3> max{};
};

/** \brief Position of a voxel within its grid: x, y, z count voxels from the grid's
 * lower corner, each below 2^depth of the grid. */
struct VoxelPosition {
  std::uint32_t x;
  std::uint32_t y;
  std::uint32_t z;
};

namespace detail {

/** \brief Spreads the low 21 bits of a number so that two zero bits follow each. */
constexpr std::uint64_t
spreadBits(std::uint64_t bits)
{
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x001f00000000ffff;
  bits = (bits | bits << 16) & 0x001f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  bits = (bits | bits << 2) & 0x1249249249249249;
  return bits;
}

} // namespace detail

/** \brief Morton key of a position: three bits a level, x the highest of each three, so
 * that three bits are PCL's child index and key order is PCL's order of serialization.
 */
constexpr std::uint64_t
mortonKey(const VoxelPosition& position)
{
  return detail::spreadBits(position.x) << 2 | detail::spreadBits(position.y) << 1 |
         detail::spreadBits(position.z);
}

namespace detail {

/** \brief Reorders the nine bits of three levels of a Morton key: three bits of x, then
 * of y, then of z, x the lowest. Each from the key of a level less, as compilers are slow
 * at nested loops. */
constexpr std::array<std::uint16_t, 512>
makeAxisBits()
{
  constexpr std::array<unsigned int, 8> of_level{
      0, 0100, 010, 0110, 1, 0101, 011, 0111};
  std::array<std::uint16_t, 512> axis_bits{};
  for (unsigned int key = 0; key < 512; ++key)
    axis_bits[key] =
        static_cast<std::uint16_t>(2u * axis_bits[key >> 3] | of_level[key & 7]);
  return axis_bits;
}

inline constexpr std::array<std::uint16_t, 512> axis_bits = makeAxisBits();

} // namespace detail

/** \brief Inverse of mortonKey. */
constexpr VoxelPosition
voxelPosition(std::uint64_t morton_key)
{
  VoxelPosition position{0, 0, 0};
  for (unsigned int level = 0; morton_key != 0; morton_key >>= 9, level += 3) {
    const std::uint32_t bits = detail::axis_bits[morton_key & 511];
    position.x |= (bits & 7) << level;
    position.y |= (bits >> 3 & 7) << level;
    position.z |= (bits >> 6) << level;
  }
  return position;
}

/** \brief The cubic part of space that contains a frame's voxels.
 *
 * Voxels have a lattice index (i, j, k); the voxel covers [i d_v, (i+1) d_v) x ... from
 * the origin. The grid has 2^depth voxels along each axis, from `first_index` on. In
 * stream version 1 that is the world's origin, so that the voxels coincide with those
 * of a map, or for far clouds another corner of those voxels; in the published layout
 * it is the lower corner of PCL's octree.
 */
struct VoxelGrid {
  double resolution = 0.0;                   ///< voxel edge d_v, metres
  std::array<double, 3> origin{};            ///< world position of lattice 0, metres
  std::array<std::int32_t, 3> first_index{}; ///< lattice index of the lowest voxel
  unsigned int depth = 1;                    ///< levels, 1..max_grid_depth

  /** \brief Voxels along each axis: 2^depth. */
  std::int64_t
  size() const
  {
    return std::int64_t{1} << depth;
  }

  /** \brief World coordinate, in metres, of the centre of a voxel along one axis.
   * \param[in] axis 0, 1, 2 for x, y, z
   * \param[in] position voxels from the grid's lower corner
   */
  double
  centre(std::size_t axis, std::uint32_t position) const
  {
    return (static_cast<double>(first_index[axis]) + static_cast<double>(position) +
            0.5) *
               resolution +
           origin[axis];
  }

  /** \brief World coordinate, in metres, of the lower corner of the grid on one axis.
   */
  double
  lowerCorner(std::size_t axis) const
  {
    return static_cast<double>(first_index[axis]) * resolution + origin[axis];
  }

  /** \brief Coordinates that are no farther from the world's origin are held by floats to
   * 1/16 of an edge. */
  double
  farthestFloat() const
  {
    // With a quarter for the rounding of centres that are whole edges from the origin.
    return resolution * (0x1p20 + 0.25);
  }

  /** \brief True if floats do not hold the centres of all voxels to 1/16 of an edge:
   * the grid has voxels whose centres are more than 2^20 edges from the world's origin
   * on an axis, which are 42 km at 4 cm. The coordinates of decoded clouds are then
   * given in double precision. */
  bool
  needsDoubles() const
  {
    const double farthest = farthestFloat();
    const auto last = static_cast<std::uint32_t>(size() - 1);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (centre(axis, 0) < -farthest || centre(axis, last) > farthest)
        return true;
    return false;
  }

  bool
  operator==(const VoxelGrid& other) const
  {
    return resolution == other.resolution && origin == other.origin &&
           first_index == other.first_index && depth == other.depth;
  }

  bool
  operator!=(const VoxelGrid& other) const
  {
    return !(*this == other);
  }
};

/** \brief Offset to add to the coordinates of a voxel's centre, metres, to look up the
 * voxel that contains it in another grid. If the centre is on a face of the other grid,
 * as with voxels of twice the size, it is in the upper voxel, but rounded to float it
 * may be just below.
 * \param[in] resolution voxel edge of the other grid, metres
 */
constexpr float
faceMargin(double resolution)
{
  return static_cast<float>(resolution / 1024.0);
}

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io

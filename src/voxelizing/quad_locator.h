#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "simd/bit_operations.h"
#include "simd/lanes.h"
#include "voxelizing/block_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

namespace pcl_ext {
namespace io {

/** \brief Computes the voxels of four points at once.
 *
 * In single precision, which is exact except near the faces of a voxel; there a coordinate
 * is divided in double precision as by Lattice. The whole millimetres of depth cameras are
 * on faces of voxels of 0.1 mm, all of them.
 */
template <typename LanesT>
class QuadLocator {
public:
  /** \brief A locator for the voxels of a grid.
   * \param[in] grid any grid
   * \param[in] box points outside it are reported as uncertain
   */
  QuadLocator(const VoxelGrid& grid, const std::optional<BoundingBox>& box)
  : inverse_resolution_(LanesT::all(static_cast<float>(1.0 / grid.resolution)))
  , beyond_grid_(LanesT::all(static_cast<std::int32_t>(-grid.size())))
  , grid_(grid)
  , has_box_(box)
  {
    float error = 0.0f;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first_centre_[axis] =
          LanesT::all(static_cast<float>(grid.centre(axis, 0) / grid.resolution));
      error = std::max(error, maxError(grid, axis));
      if (box) {
        box_min_[axis] = LanesT::all(lowestFloatFrom(box->min[axis]));
        box_max_[axis] = LanesT::all(-lowestFloatFrom(-box->max[axis]));
      }
    }
    certain_ = LanesT::all(0.5f - error);
    is_useful_ = error < 0.25f;
  }

  /** \brief False if most points of the grid would be uncertain. */
  bool
  isUseful() const
  {
    return is_useful_;
  }

  /** \brief Computes the voxels of four points.
   * \param[in] points x of the first; four floats are read of each
   * \param[in] stride bytes from one x to the next
   * \param[out] blocks,voxels four voxels, as in BlockPlace; valid for certain points only
   * \return bit i is set if point i is certainly in the grid and the box
   */
  unsigned int
  locate(const unsigned char* points,
         std::size_t stride,
         std::uint64_t* blocks,
         std::uint32_t* voxels) const
  {
    Floats point[3];
    loadPoints<LanesT>(points, stride, point[0], point[1], point[2]);
    Ints position[3];
    Ints in_box = LanesT::all(-1);
    unsigned int in_grid = 15;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Relative to the centre of the grid's first voxel, so that the position is the
      // nearest integer. The point is certain if it is far enough from the voxel's faces.
      const Floats from_first = LanesT::subtract(
          LanesT::multiply(point[axis], inverse_resolution_), first_centre_[axis]);
      position[axis] = LanesT::round(from_first);
      const Floats from_centre = LanesT::absolute(
          LanesT::subtract(from_first, LanesT::toFloats(position[axis])));
      const unsigned int certain = LanesT::bitsOf(LanesT::less(from_centre, certain_));
      if (certain != 15)
        in_grid &= divide(axis, 15 & ~certain, point[axis], position[axis]);
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
    storePlaces(position, blocks, voxels);
    return in_grid &
           LanesT::bitsOf(LanesT::bitAnd(in_box, LanesT::isZero(higher_bits)));
  }

private:
  // Built-in arrays, as template arguments lose the alignment of vector types.
  using Floats = typename LanesT::Floats;
  using Ints = typename LanesT::Ints;

  /** \brief Computes the positions of some of four points on an axis by division.
   * \param[in] wanted bit i is set if point i is one of them
   * \return bit i is not set if point i is one of them and outside the grid
   */
  unsigned int
  divide(std::size_t axis,
         unsigned int wanted,
         const Floats& coordinates,
         Ints& positions) const
  {
    std::array<float, 4> coordinate;
    LanesT::store(coordinates, coordinate.data());
    std::array<std::int32_t, 4> position;
    std::memcpy(position.data(), &positions, sizeof(positions));
    const std::int32_t first = grid_.first_index[axis];
    const auto begin = static_cast<double>(first);
    const double end = begin + static_cast<double>(grid_.size());
    unsigned int outside = 0;
    for (; wanted != 0; wanted &= wanted - 1) {
      const unsigned int lane = lowestBit(wanted);
      const double quotient =
          (static_cast<double>(coordinate[lane]) - grid_.anchor[axis]) /
          grid_.resolution;
      const bool is_inside = quotient >= begin && quotient < end; // NaN is not
      const double inside = is_inside ? quotient : begin;
      const auto truncated = static_cast<std::int32_t>(inside);
      position[lane] =
          truncated - (static_cast<double>(truncated) > inside ? 1 : 0) - first;
      outside |= (is_inside ? 0u : 1u) << lane;
    }
    std::memcpy(&positions, position.data(), sizeof(positions));
    return ~outside;
  }

  /** \brief Bound of the difference, in voxels, between the position computed here and the
   * quotient in double precision, for points in the grid.
   *
   * The inverse, the product, the first centre and the difference have a relative error of
   * at most 2^-24 each. The terms of second order and the errors of the quotient and of
   * the bound are below the one voxel more.
   */
  static float
  maxError(const VoxelGrid& grid, std::size_t axis)
  {
    const auto size = static_cast<double>(grid.size());
    const auto first = static_cast<double>(grid.first_index[axis]);
    const double farthest = std::max(std::abs(first), std::abs(first + size)) +
                            std::abs(grid.anchor[axis]) / grid.resolution + 1.0;
    return static_cast<float>((3.0 * farthest + size) * 0x1p-24);
  }

  /** \brief The lowest float that is not below a double. */
  static float
  lowestFloatFrom(double number)
  {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    // Casting a double outside the range of float is undefined.
    if (number > static_cast<double>(std::numeric_limits<float>::max()))
      return infinity;
    if (number < static_cast<double>(std::numeric_limits<float>::lowest()))
      return std::numeric_limits<float>::lowest();
    const auto nearest = static_cast<float>(number);
    return static_cast<double>(nearest) < number ? std::nextafter(nearest, infinity)
                                                 : nearest;
  }

  static void
  storePlaces(const Ints (&position)[3], std::uint64_t* blocks, std::uint32_t* voxels)
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
    constexpr int bits = static_cast<int>(BlockPlace::axis_bits);
    LanesT::storePairs(LanesT::bitOr(z, LanesT::template shiftLeft<bits>(y)),
                       LanesT::bitOr(LanesT::template shiftRight<32 - bits>(y),
                                     LanesT::template shiftLeft<2 * bits - 32>(x)),
                       blocks);
  }

  Floats inverse_resolution_;
  Ints beyond_grid_;       // the bits that are 0 in all positions of the grid
  Floats first_centre_[3]; // of the grid's lowest voxel, in voxels
  VoxelGrid grid_;
  Floats certain_; // largest certain distance from a voxel's centre, in voxels
  Floats box_min_[3]{};
  Floats box_max_[3]{};
  bool has_box_;
  bool is_useful_ = false;
};

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Index of a voxel on a grid's lattice, which extends beyond the grid. */
using LatticeIndex = std::array<std::int32_t, 3>;

/** \brief Comparison without branches; that of std::array has one for each element. */
inline bool
isSame(const LatticeIndex& first, const LatticeIndex& second)
{
  return ((first[0] ^ second[0]) | (first[1] ^ second[1]) | (first[2] ^ second[2])) ==
         0;
}

/** \brief Computes the voxels of points on a lattice. */
class Lattice {
public:
  /** \brief A usable range of a lattice.
   * \param[in] grid its resolution and origin are used
   * \param[in] begin lowest usable index on each axis
   * \param[in] end one above the highest usable index on each axis
   */
  Lattice(const VoxelGrid& grid,
          const std::array<std::int64_t, 3>& begin,
          const std::array<std::int64_t, 3>& end)
  : origin_(grid.origin), resolution_(grid.resolution)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      begin_[axis] = static_cast<double>(begin[axis]);
      end_[axis] = static_cast<double>(end[axis]);
    }
  }

  /** \brief The lattice of a grid, of which the voxels of the grid are usable. */
  static Lattice
  within(const VoxelGrid& grid)
  {
    std::array<std::int64_t, 3> begin;
    std::array<std::int64_t, 3> end;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      begin[axis] = grid.first_index[axis];
      end[axis] = begin[axis] + grid.size();
    }
    return {grid, begin, end};
  }

  /** \brief Index of the voxel that contains a point: floor((point - origin) /
   * resolution), in double precision.
   * \param[in] point x, y, z, metres
   * \param[out] index the voxel
   * \return false if the point is not finite or not in the usable range
   */
  template <typename NumberT>
  bool
  indexOf(const NumberT* point, LatticeIndex& index) const
  {
    return indexOn(0, static_cast<double>(point[0]), index[0]) &&
           indexOn(1, static_cast<double>(point[1]), index[1]) &&
           indexOn(2, static_cast<double>(point[2]), index[2]);
  }

  /** \brief The same on one axis. */
  bool
  indexOn(std::size_t axis, double coordinate, std::int32_t& index) const
  {
    const double position = positionOf(axis, coordinate);
    // Negated, so that NaN fails.
    if (!(position >= begin_[axis] && position < end_[axis]))
      return false;
    index = floorOf(position);
    return true;
  }

  /** \brief Index of the usable voxel that is nearest to a finite point. */
  template <typename NumberT>
  LatticeIndex
  nearestIndexOf(const NumberT* point) const
  {
    LatticeIndex index;
    for (std::size_t axis = 0; axis < 3; ++axis)
      index[axis] =
          floorOf(std::clamp(positionOf(axis, static_cast<double>(point[axis])),
                             begin_[axis],
                             end_[axis] - 1.0));
    return index;
  }

  /** \brief The lowest float that is not below the usable range of each axis, metres;
   * infinity if there is none. In a fixed number of steps for any lattice. */
  std::array<float, 3>
  lowestCoordinates() const
  {
    std::array<float, 3> coordinates;
    for (std::size_t axis = 0; axis < 3; ++axis)
      coordinates[axis] = floatOfRank(lowestRankFrom(axis, begin_[axis]));
    return coordinates;
  }

  /** \brief The highest float that is not above the usable range of each axis, metres;
   * minus infinity if there is none. In a fixed number of steps for any lattice. */
  std::array<float, 3>
  highestCoordinates() const
  {
    std::array<float, 3> coordinates;
    for (std::size_t axis = 0; axis < 3; ++axis)
      coordinates[axis] = floatOfRank(lowestRankFrom(axis, end_[axis]) - 1);
    return coordinates;
  }

private:
  /** \brief Coordinate in voxels from the origin. A division, as multiplying by the
   * rounded inverse would put points at a face into the neighbouring voxel. */
  double
  positionOf(std::size_t axis, double coordinate) const
  {
    return (coordinate - origin_[axis]) / resolution_;
  }

  /** \brief Rank of the lowest float whose position is not below a bound, or of
   * infinity.
   *
   * By bisection of the ranks: between a float that is computed from the bound and the
   * one that is wanted may be a billion floats, where the bound is near zero. */
  std::int32_t
  lowestRankFrom(std::size_t axis, double bound) const
  {
    std::int32_t low = -highest_rank;
    std::int32_t high = highest_rank + 1;
    while (low < high) {
      const auto middle =
          static_cast<std::int32_t>((std::int64_t{low} + std::int64_t{high} - 1) >> 1);
      if (positionOf(axis, static_cast<double>(floatOfRank(middle))) >= bound)
        high = middle;
      else
        low = middle + 1;
    }
    return low;
  }

  /** \brief The float of a rank: ranks number the floats in ascending order, 0 is 0.0f.
   * Those beyond the highest rank are infinite. */
  static float
  floatOfRank(std::int32_t rank)
  {
    const std::int32_t bits = std::abs(rank);
    float magnitude;
    static_assert(std::numeric_limits<float>::is_iec559 && sizeof(float) == 4);
    std::memcpy(&magnitude, &bits, sizeof(magnitude));
    return rank < 0 ? -magnitude : magnitude;
  }

  /** \brief Rank of the largest finite float. */
  static constexpr std::int32_t highest_rank = 0x7f7fffff;

  /** \brief Floor of a number within the range of the type, without a call of
   * std::floor. */
  static std::int32_t
  floorOf(double number)
  {
    const auto truncated = static_cast<std::int32_t>(number);
    return truncated - (static_cast<double>(truncated) > number ? 1 : 0);
  }

  std::array<double, 3> origin_;
  double resolution_;
  std::array<double, 3> begin_;
  std::array<double, 3> end_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

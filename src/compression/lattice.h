#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Index of a voxel on a grid's lattice, which extends beyond the grid. */
using LatticeIndex = std::array<std::int32_t, 3>;

/** \brief Comparison without branches; std::array's has one for each element. */
inline bool
isSame(const LatticeIndex& first, const LatticeIndex& second)
{
  return ((first[0] ^ second[0]) | (first[1] ^ second[1]) | (first[2] ^ second[2])) ==
         0;
}

/** \brief Tells in which voxel of a lattice a coordinate lies. */
class Lattice {
public:
  /** \brief A lattice of which a part can be used.
   * \param[in] grid its resolution and anchor are used
   * \param[in] begin lowest index an axis that a point may have
   * \param[in] end first index an axis that a point may not have any more
   */
  Lattice(const VoxelGrid& grid,
          const std::array<std::int64_t, 3>& begin,
          const std::array<std::int64_t, 3>& end)
  : anchor_(grid.anchor)
  , resolution_(grid.resolution)
  , inverse_resolution_(1.0 / grid.resolution)
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      begin_[axis] = static_cast<double>(begin[axis]);
      end_[axis] = static_cast<double>(end[axis]);
    }
  }

  /** \brief Index of the voxel that holds a point: floor((point - anchor) / resolution),
   * in double precision.
   * \param[in] point x, y, z, metres
   * \param[out] index the voxel
   * \return false if the point is not finite or not in the part that can be used
   */
  bool
  indexOf(const float* point, LatticeIndex& index) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double distance = static_cast<double>(point[axis]) - anchor_[axis];
      double position = distance * inverse_resolution_;
      // One voxel of slack, so that what follows has only numbers of its range, and only
      // an exact position is refused at the ends. Written so that NaN fails.
      if (!(position >= begin_[axis] - 1.0 && position <= end_[axis]))
        return false;
      if (isNearFace(position))
        position = distance / resolution_;
      if (position < begin_[axis] || position >= end_[axis])
        return false;
      index[axis] = floorOf(position);
    }
    return true;
  }

  /** \brief Index of the usable voxel that is nearest to a finite point. */
  LatticeIndex
  nearestIndexOf(const float* point) const
  {
    LatticeIndex index;
    for (std::size_t axis = 0; axis < 3; ++axis)
      index[axis] = floorOf(
          std::clamp((static_cast<double>(point[axis]) - anchor_[axis]) / resolution_,
                     begin_[axis],
                     end_[axis] - 1.0));
    return index;
  }

private:
  /** \brief Floor of a number within the range of the type, without a call into the
   * mathematics library. */
  static std::int32_t
  floorOf(double number)
  {
    const auto truncated = static_cast<std::int32_t>(number);
    return truncated - (static_cast<double>(truncated) > number ? 1 : 0);
  }

  /** \brief True if a product with the inverse may lie on the other side of a voxel face
   * than the quotient does, so that dividing, which is slower, must decide. The two
   * differ by less than 2^-52 of the position, which is below 2^21. */
  static bool
  isNearFace(double position)
  {
    constexpr double tolerance = 1e-8;
    const double above_face = position - static_cast<double>(floorOf(position));
    return above_face < tolerance || above_face > 1.0 - tolerance;
  }

  std::array<double, 3> anchor_;
  double resolution_;
  double inverse_resolution_;
  std::array<double, 3> begin_;
  std::array<double, 3> end_;
};

} // namespace io
} // namespace pcl_ext

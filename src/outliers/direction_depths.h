// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_grid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief The least depth in each direction around a sensor.
 *
 * Directions are squares on the six faces of a cube around the sensor, 0.35 degrees
 * wide in the middle of a face and half as wide at its edges. A depth is the distance
 * along the face's axis, in any unit. Each result of floating-point arithmetic is one
 * operation, so that no compiler rounds otherwise.
 */
class DirectionDepths {
public:
  /** \brief Squares along an edge of a face. */
  static constexpr std::uint32_t width = 256;

  /** \brief Of a square without a depth. */
  static constexpr float unseen = std::numeric_limits<float>::infinity();

  /** \brief Where a point is from the sensor. */
  struct Direction {
    std::uint32_t square; ///< (face * width + row) * width + column
    float depth;          ///< 0 at the sensor, whose square means nothing
  };

  /** \brief So many points are added together, as vector instructions find several
   * directions at once. */
  static constexpr std::size_t batch_size = 64;

  /** \brief x, y and z of points, less the sensor's position; finite. */
  using Batch = std::array<std::array<float, batch_size>, 3>;

  /** \param[in] x,y,z a point, less the sensor's position; finite */
  static Direction
  directionOf(float x, float y, float z)
  {
    // The order of numbers that are not negative is that of their bits. Selections of
    // bits have no branches, so that compilers make vector instructions of them.
    const std::int32_t bits_of_x = bitsOf(x);
    const std::int32_t bits_of_y = bitsOf(y);
    const std::int32_t bits_of_z = bitsOf(z);
    const std::int32_t along_x = bits_of_x & without_sign;
    const std::int32_t along_y = bits_of_y & without_sign;
    const std::int32_t along_z = bits_of_z & without_sign;
    const std::int32_t is_y = along_y > along_x ? -1 : 0;
    const std::int32_t is_z = along_z > std::max(along_x, along_y) ? -1 : 0;
    // The axes in their order from that of the face on.
    const auto select = [=](std::int32_t of_x, std::int32_t of_y, std::int32_t of_z) {
      const std::int32_t of_others = (of_x & ~is_y) | (of_y & is_y);
      return (of_others & ~is_z) | (of_z & is_z);
    };
    const std::int32_t ahead = select(bits_of_x, bits_of_y, bits_of_z);
    const float row = floatOf(select(bits_of_y, bits_of_z, bits_of_x));
    const float column = floatOf(select(bits_of_z, bits_of_x, bits_of_y));
    const std::int32_t depth = ahead & without_sign;
    const float divisor = floatOf(std::max(depth, bits_of_least));
    const std::int32_t face = select(0, 2, 4) + (ahead < 0 ? 1 : 0);
    return {static_cast<std::uint32_t>((face * side + squareOf(row / divisor)) * side +
                                       squareOf(column / divisor)),
            floatOf(depth)};
  }

  /** \brief Takes those depths of points that are the least of their squares.
   * \param[in] points of which so many are added
   * \param[in] count up to \ref batch_size
   * \param[in] least_depth nearer points have no direction; above 0 */
  void
  add(const Batch& points, std::size_t count, float least_depth);

  /** \brief The same of all points outside of a box.
   * \param[in] points metres
   * \param[in] position of the sensor, metres; finite
   */
  void
  addBeyond(io::PointBatches& points,
            const io::BoundingBox& box,
            const std::array<double, 3>& position);

  /** \brief The least depth of a square, or \ref unseen. */
  float
  operator[](std::uint32_t square) const
  {
    const std::vector<float>& face = faces_[square / face_size];
    return face.empty() ? unseen : face[square % face_size];
  }

  /** \brief The least depth of a square and those around it on its face, or \ref unseen.
   * \param[in] radius squares between the middle and the edges of the area */
  float
  leastAround(std::uint32_t square, std::uint32_t radius) const
  {
    const std::vector<float>& face = faces_[square / face_size];
    if (face.empty())
      return unseen;
    const std::uint32_t row = square / width % width;
    const std::uint32_t column = square % width;
    const std::uint32_t left = column - std::min(column, radius);
    const std::uint32_t right = std::min(column + radius, width - 1);
    const std::uint32_t bottom = std::min(row + radius, width - 1);
    float least = unseen;
    for (std::uint32_t i = row - std::min(row, radius); i <= bottom; ++i)
      for (std::uint32_t j = left; j <= right; ++j)
        least = std::min(least, face[i * width + j]);
    return least;
  }

  void
  clear()
  {
    for (std::size_t i = 0; i < count_; ++i)
      faces_[squares_[i] / face_size][squares_[i] % face_size] = unseen;
    count_ = 0;
  }

private:
  static constexpr std::uint32_t face_size = width * width;
  static constexpr std::int32_t side = width;
  static constexpr std::int32_t without_sign = 0x7fffffff;
  static constexpr std::int32_t bits_of_least = 0x00800000; // normal number above 0

  static std::int32_t
  bitsOf(float number)
  {
    std::int32_t bits;
    std::memcpy(&bits, &number, sizeof bits);
    return bits;
  }

  static float
  floatOf(std::int32_t bits)
  {
    float number;
    std::memcpy(&number, &bits, sizeof number);
    return number;
  }

  /** \param[in] across -1..1, from one edge of a face to the other
   * \return 0..255 */
  static std::int32_t
  squareOf(float across)
  {
    return std::min(static_cast<std::int32_t>((across + 1.0f) * 128.0f), side - 1);
  }

  std::array<std::vector<float>, 6> faces_; // empty until there is a depth
  std::vector<std::uint32_t> squares_;      // count_ of them are not unseen
  std::size_t count_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "filters/moved_points.h"
#include "simd/bit_operations.h"
#include "simd/lanes_target.h"
#include "simd/load_points.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI::detail {

/** \brief Moves points, as many at once as there are lanes; see movePoints(). */
template <typename LanesT>
class PointMover {
public:
  PCL_EXT_LANES_TARGET
  PointMover(const PointMove& move, float* output, MovedPoints& moved)
  : output_(output), moved_(moved)
  {
    constexpr float largest = std::numeric_limits<float>::max();
    moved.count = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 4; ++column)
        matrix_[row][column] = LanesT::all(move.rows[row][column]);
      // Clamped, so that points within the box are also finite.
      min_[row] = LanesT::all(std::max(move.min[row], -largest));
      max_[row] = LanesT::all(std::min(move.max[row], largest));
    }
  }

  /** \brief Moves as many points as there are lanes.
   * \param[in] points four floats are read of each
   * \param[in] stride bytes from one point to the next
   * \param[in] source which point is the first
   */
  PCL_EXT_LANES_TARGET void
  moveAll(const unsigned char* points, std::size_t stride, std::uint32_t source)
  {
    Floats position[4];
    Floats depth;
    Ints is_finite;
    const unsigned int kept = move(points, stride, position, depth, is_finite);
    finite_ = LanesT::subtract(finite_, is_finite); // -1 in lanes of finite points
    if (kept == all_lanes)
      keepAll(position, depth, source);
    else if (kept != 0)
      keepSome(position, depth, source, kept, LanesT::width);
  }

  /** \brief Moves the first ones of as many points as there are lanes. */
  PCL_EXT_LANES_TARGET void
  moveFirst(const unsigned char* points,
            std::size_t stride,
            std::uint32_t source,
            unsigned int count)
  {
    const unsigned int wanted = (1u << count) - 1;
    Floats position[4];
    Floats depth;
    Ints is_finite;
    const unsigned int kept = move(points, stride, position, depth, is_finite) & wanted;
    finite_points_ += bitCount(LanesT::bitsOf(is_finite) & wanted);
    if (kept != 0)
      keepSome(position, depth, source, kept, count);
  }

  /** \brief Number of points that were finite after the move. */
  PCL_EXT_LANES_TARGET std::size_t
  countFinite() const
  {
    std::array<std::uint32_t, LanesT::width> counts;
    LanesT::store(finite_, counts.data());
    std::size_t sum = finite_points_;
    for (std::size_t lane = 0; lane < LanesT::width; ++lane)
      sum += counts[lane];
    return sum;
  }

private:
  // C arrays: as a template argument a vector type would lose its alignment.
  using Floats = typename LanesT::Floats;
  using Ints = typename LanesT::Ints;

  static constexpr unsigned int all_lanes = (1u << LanesT::width) - 1;

  /** \brief Computes the positions of a point a lane.
   * \param[out] position x, y, z and 1 of each point
   * \param[out] depth z before the move
   * \param[out] is_finite which positions are
   * \return bit i is set if position i is finite and in the crop box
   */
  PCL_EXT_LANES_TARGET unsigned int
  move(const unsigned char* points,
       std::size_t stride,
       Floats (&position)[4],
       Floats& depth,
       Ints& is_finite) const
  {
    Floats point[3];
    loadPoints<LanesT>(points, stride, point[0], point[1], point[2]);
    Floats zeros = LanesT::all(0.0f);
    Ints is_kept = LanesT::all(-1);
    for (std::size_t row = 0; row < 3; ++row) {
      // In the order of Eigen's product of matrix and vector.
      position[row] = LanesT::add(
          LanesT::add(LanesT::add(LanesT::multiply(matrix_[row][0], point[0]),
                                  LanesT::multiply(matrix_[row][1], point[1])),
                      LanesT::multiply(matrix_[row][2], point[2])),
          matrix_[row][3]);
      // NaN if any term is not finite.
      zeros = LanesT::add(zeros, LanesT::subtract(position[row], position[row]));
      is_kept = LanesT::bitAnd(is_kept, LanesT::lessOrEqual(min_[row], position[row]));
      is_kept = LanesT::bitAnd(is_kept, LanesT::lessOrEqual(position[row], max_[row]));
    }
    is_finite = LanesT::lessOrEqual(zeros, LanesT::all(0.0f));
    depth = point[2];
    position[3] = LanesT::all(1.0f);
    LanesT::transpose(position[0], position[1], position[2], position[3]);
    return LanesT::bitsOf(is_kept);
  }

  PCL_EXT_LANES_TARGET void
  keepAll(const Floats (&position)[4], const Floats& depth, std::uint32_t source)
  {
    const std::size_t count = moved_.count;
    storePositions(position, output_ + count * moved_point_floats, moved_point_floats);
    LanesT::store(depth, &moved_.depths[count]);
    for (std::uint32_t lane = 0; lane < LanesT::width; ++lane)
      moved_.sources[count + lane] = source + lane;
    moved_.count = count + LanesT::width;
  }

  PCL_EXT_LANES_TARGET void
  keepSome(const Floats (&position)[4],
           const Floats& depth,
           std::uint32_t source,
           unsigned int kept,
           std::uint32_t lanes)
  {
    std::array<float, std::size_t{4} * LanesT::width> positions;
    storePositions(position, positions.data(), 4);
    std::array<float, LanesT::width> depths;
    LanesT::store(depth, depths.data());
    // Without a branch, which would be mispredicted: written in any case, counted if
    // kept.
    std::size_t count = moved_.count;
    for (std::uint32_t lane = 0; lane < lanes; ++lane) {
      std::memcpy(output_ + count * moved_point_floats,
                  &positions[std::size_t{4} * lane],
                  4 * sizeof(float));
      moved_.depths[count] = depths[lane];
      moved_.sources[count] = source + lane;
      count += kept >> lane & 1;
    }
    moved_.count = count;
  }

  /** \brief Writes four floats a lane.
   * \param[in] to the first of them
   * \param[in] distance floats from one point to the next
   */
  PCL_EXT_LANES_TARGET static void
  storePositions(const Floats (&position)[4], float* to, std::size_t distance)
  {
    for (std::size_t lane = 0; lane < 4; ++lane)
      LanesT::template storeFour<0>(position[lane], to + lane * distance);
    if constexpr (LanesT::width == 8)
      for (std::size_t lane = 0; lane < 4; ++lane)
        LanesT::template storeFour<1>(position[lane], to + (4 + lane) * distance);
  }

  Floats matrix_[3][4];
  Floats min_[3];
  Floats max_[3];
  Ints finite_ = LanesT::all(0);  // number of finite points by lane
  std::size_t finite_points_ = 0; // of those of moveFirst()
  float* output_;
  MovedPoints& moved_;
};

template <typename LanesT>
PCL_EXT_LANES_TARGET void
moveEach(const PointBytes& points,
         const PointMove& move,
         float* output,
         MovedPoints& moved)
{
  PointMover<LanesT> mover(move, output, moved);
  std::size_t i = 0;
  // A float after z is read, which the last point may not have.
  for (; i + LanesT::width < points.count; i += LanesT::width)
    mover.moveAll(
        points.first + i * points.stride, points.stride, static_cast<std::uint32_t>(i));
  std::array<float, std::size_t{4} * LanesT::width> last{};
  const auto source = static_cast<std::uint32_t>(i);
  for (; i < points.count; ++i)
    std::memcpy(
        &last[4 * (i - source)], points.first + i * points.stride, 3 * sizeof(float));
  mover.moveFirst(reinterpret_cast<const unsigned char*>(last.data()),
                  4 * sizeof(float),
                  source,
                  static_cast<unsigned int>(points.count - source));
  moved.not_finite = points.count - mover.countFinite();
}

template <typename LanesT>
void
movePointsWith(const PointBytes& points,
               const PointMove& move,
               float* output,
               MovedPoints& moved)
{
  moveEach<LanesT>(points, move, output, moved);
}

} // namespace pcl_ext::PCL_EXT_ABI::detail

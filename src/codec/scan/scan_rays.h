// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Numbers of x, y and z. */
using Triple = std::array<std::int64_t, 3>;

/** \brief A length of 1 in the unit of directions, 2^-30. */
constexpr std::int64_t direction_length = std::int64_t{1} << 30;

/** \brief The ray of a pixel: the point at depth n is at start + n * step, edges from the
 * grid's lowest corner in units of 2^-32. */
struct Ray {
  Triple start;
  Triple step;

  /** \brief Position of a depth along an axis. */
  std::int64_t
  at(std::uint32_t depth, std::size_t axis) const
  {
    return start[axis] + static_cast<std::int64_t>(depth) * step[axis];
  }
};

/** \brief Rays of a row of a spinning sensor: the point at depth n is at
 * `along + n * run` in the direction of its column, turned by (cosine, sine), at
 * `across` to the left of that, and at `up + n * rise`. */
struct RayRow {
  std::int32_t cosine = 0; ///< units of 2^-30
  std::int32_t sine = 0;   ///< units of 2^-30
  std::int32_t run = 0;    ///< edges for a step of depth, units of 2^-24
  std::int32_t rise = 0;   ///< likewise
  std::int32_t along = 0;  ///< edges, units of 2^-16
  std::int32_t across = 0; ///< likewise
  std::int32_t up = 0;     ///< likewise

  bool
  operator==(const RayRow& other) const
  {
    return cosine == other.cosine && sine == other.sine && run == other.run &&
           rise == other.rise && along == other.along && across == other.across &&
           up == other.up;
  }
};

/** \brief What kind of sensor measures along its rays. */
enum class RayShape : std::uint8_t {
  Planar = 0,   ///< a camera: depth along the optical axis
  Spinning = 1, ///< a lidar that turns: rows are cones, columns are directions
  Free = 2      ///< no rays: points are whole edges from the origin
};

/** \brief Place and directions of rays: what changes as the sensor moves. */
struct RayPose {
  /** \brief Position of the sensor from the grid's lowest corner, edges in units of
   * 2^-16. */
  Triple origin{};
  /** \brief Of a camera x, y, z of a step of depth at row and column 0, and its changes
   * from a column to the next and from a row to the next, edges in units of 2^-40; of a
   * spinning sensor its axes x, y and z in the grid, units of 2^-30. */
  std::array<Triple, 3> vectors{};

  bool
  operator==(const RayPose& other) const
  {
    return origin == other.origin && vectors == other.vectors;
  }

  bool
  operator!=(const RayPose& other) const
  {
    return !(*this == other);
  }
};

/** \brief Where the rays of a scan are. All numbers are integers, so that all machines
 * compute the same places. */
struct ScanRays {
  RayShape shape = RayShape::Planar;

  /** \brief Of a camera: depth n is n + 1/2 steps from the sensor, so that points of a
   * camera along an axis of the grid are amid its voxels and not on faces. */
  bool has_half_depths = false;

  /** \brief At column 0. */
  RayPose pose;

  // Of a spinning sensor:

  /** \brief How the pose changes from a column to the next, as the sensor moves: of the
   * origin, edges in units of 2^-32; of the axes in units of 2^-46. */
  RayPose motion;

  /** \brief Cosine and sine of 2^k steps of an angle, units of 2^-30. */
  std::vector<std::array<std::int32_t, 2>> turns;

  std::vector<std::int32_t> columns; ///< angle of each, in these steps
  std::vector<RayRow> rows;
};

/** \brief Computes the rays of a scan, row by row. */
class ScanRayReader {
public:
  /** \param[in] rays with their columns; must not change while they are read */
  explicit ScanRayReader(const ScanRays& rays);

  /** \brief Goes to a row. */
  void
  moveTo(std::uint32_t row)
  {
    if (rays_.shape == RayShape::Spinning) {
      row_ = rays_.rows[row];
      row_direction_ = {row_.cosine, row_.sine};
      return;
    }
    const auto& vectors = rays_.pose.vectors;
    for (std::size_t axis = 0; axis < 3; ++axis)
      first_step_[axis] = vectors[0][axis] + vectors[2][axis] * row;
  }

  /** \brief The ray of a column of the row.
   * \param[in] turn how far it is turned, in steps of the angle
   */
  Ray
  at(std::uint32_t column, std::int32_t turn) const
  {
    return rays_.shape == RayShape::Spinning ? spinningRay(column, turn)
                                             : planarRay(column);
  }

  /** \brief The sensor at a column. */
  struct Column {
    Triple origin; ///< edges, units of 2^-32
    Triple ahead;  ///< of length 1, units of 2^-30
    Triple left;   ///< likewise
    Triple up;     ///< likewise
  };

  /** \brief Of a spinning sensor. */
  const std::vector<Column>&
  columns() const
  {
    return columns_;
  }

private:
  /** \brief Cosine and sine of an angle, units of 2^-30. */
  struct Direction {
    std::int64_t cosine;
    std::int64_t sine;
  };

  static Direction
  sum(const Direction& first, const Direction& second)
  {
    constexpr std::int64_t half = direction_length / 2;
    return {(first.cosine * second.cosine - first.sine * second.sine + half) >> 30,
            (first.sine * second.cosine + first.cosine * second.sine + half) >> 30};
  }

  void
  setLowTurns();

  Direction
  directionOf(std::int32_t steps) const;

  Column
  columnAt(std::size_t index) const;

  Ray
  planarRay(std::uint32_t column) const
  {
    const Triple& change = rays_.pose.vectors[1];
    Ray ray;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ray.step[axis] = (first_step_[axis] + change[axis] * column) >> 8;
      ray.start[axis] = rays_.pose.origin[axis] * (1 << 16) +
                        (rays_.has_half_depths ? ray.step[axis] >> 1 : 0);
    }
    return ray;
  }

  Ray
  spinningRay(std::uint32_t column_index, std::int32_t turn) const
  {
    const Column& column = columns_[column_index];
    const Direction direction =
        turn == 0 ? row_direction_ : sum(row_direction_, directionOf(turn));
    Ray ray;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t ahead = (direction.cosine * column.ahead[axis] +
                                  direction.sine * column.left[axis]) >>
                                 30;
      const std::int64_t left = (direction.cosine * column.left[axis] -
                                 direction.sine * column.ahead[axis]) >>
                                30;
      ray.start[axis] =
          column.origin[axis] +
          ((row_.along * ahead + row_.across * left + row_.up * column.up[axis]) >> 14);
      ray.step[axis] = (row_.run * ahead + row_.rise * column.up[axis]) >> 22;
    }
    return ray;
  }

  const ScanRays& rays_;
  std::vector<Direction> low_turns_; // of the lowest bits of an angle
  std::vector<Column> columns_;
  // Of the row:
  RayRow row_; // of a spinning sensor
  Direction row_direction_{};
  Triple first_step_{}; // of a camera, at column 0
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

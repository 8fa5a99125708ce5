// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/point_image.h>

#include "voxels/rays.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace scan {

/** \brief Where the rays of a scan are. All numbers are integers, so that all machines
 * compute the same places. */
struct ScanRays {
  RayShape shape = RayShape::Planar;

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
  /** \param[in] rays must not change while they are read
   * \param[in] width columns
   */
  ScanRayReader(const ScanRays& rays, std::uint32_t width);

  /** \brief Goes to a row. */
  void
  moveTo(std::uint32_t row)
  {
    row_ = row;
  }

  /** \brief The ray of a column of the row.
   * \param[in] turn how far it is turned, in steps of the angle
   */
  Ray
  at(std::uint32_t column, std::int32_t turn) const
  {
    return rays_.shape == RayShape::Planar ? planarRay(column)
                                           : spinningRay(column, turn);
  }

private:
  /** \brief Cosine and sine of an angle, units of 2^-30. */
  struct Direction {
    std::int64_t cosine;
    std::int64_t sine;
  };

  /** \brief The sensor at a column: edges in units of 2^-32, and of 2^-30. */
  struct Column {
    Triple origin;
    Triple ahead;
    Triple left;
    Triple up;
  };

  static Direction
  sum(const Direction& first, const Direction& second);

  Direction
  directionOf(std::int32_t steps) const;

  Direction
  directionOf(const RayRow& row, std::int32_t turn) const;

  Column
  columnAt(std::size_t index) const;

  Ray
  planarRay(std::uint32_t column) const;

  Ray
  spinningRay(std::uint32_t column, std::int32_t turn) const;

  const ScanRays& rays_;
  std::vector<Column> columns_; // of a spinning sensor
  std::uint32_t row_ = 0;
};

} // namespace scan
} // namespace io
} // namespace pcl_ext

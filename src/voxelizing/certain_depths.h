// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/scan/scan_frame.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the depths of points that are on their rays for certain, in double
 * precision. It takes a fraction of the time that whole numbers take, which are left for
 * the few other points. */
class CertainDepths {
public:
  /** \brief In the place of a depth: the point is not on its ray, or not for certain. */
  static constexpr std::uint32_t uncertain = ~std::uint32_t{0};

  using Numbers = std::array<double, 3>;

  /** \param[in] frame its grid, size and rays are given, which do not change
   * \param[in] rays of the frame
   */
  CertainDepths(const scan::ScanFrame& frame, const scan::ScanRayReader& rays);

  /** \brief Finds the depths of points of a row.
   * \param[in] columns of the rays of the points
   * \param[in] positions world coordinates of all points, metres
   * \param[in] points of the row, indices of their positions
   * \param[out] depths of them, or uncertain
   */
  void
  find(std::uint32_t row,
       const std::vector<std::uint32_t>& columns,
       const std::array<double, 3>* positions,
       const std::uint32_t* points,
       std::uint32_t* depths);

private:
  /** \brief The sensor at a column of a spinning sensor, edges. */
  struct Column {
    Numbers origin;
    Numbers ahead;
    Numbers left;
    Numbers up;
  };

  /** \brief Most points that are computed at once. */
  static constexpr std::size_t most_points = 128;
  using Lane = std::array<double, most_points>;
  using Lanes = std::array<Lane, 3>;

  /** \brief Places of points and their rays, depth n of which is at start + n * step;
   * edges from the grid's lowest corner. */
  struct Points {
    Lanes place;
    Lanes start;
    Lanes step;
  };

  void
  setPlaces(const std::array<double, 3>* positions,
            const std::uint32_t* points,
            std::size_t count);

  void
  setPlanarRays(std::uint32_t row, const std::uint32_t* columns, std::size_t count);

  void
  setSpinningRays(std::uint32_t row, const std::uint32_t* columns, std::size_t count);

  void
  findDepths(std::size_t count, std::uint32_t* depths) const;

  const scan::ScanFrame& frame_;
  Numbers corner_; // of the grid, metres
  Numbers sensor_; // edges from that
  double scale_;   // edges of a metre
  std::vector<Column> columns_;
  Points points_;
  // Of the row: bounds of the error of a place, and of a step of depth, edges.
  double place_error_ = 0.0;
  double step_error_ = 0.0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

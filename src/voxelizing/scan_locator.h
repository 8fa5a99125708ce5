// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "codec/scan/scan_frame.h"
#include "voxelizing/certain_depths.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Puts points on the rays of a scan. Each coordinate is off by at most half an
 * edge: on the ray if that is near enough, else whole edges beside it. */
class ScanLocator {
public:
  /** \param[in,out] frame its grid, size and rays are given; points are appended
   * \param[in] may_turn of a spinning sensor: points beside their rays may have turned
   * ones, see ScanFrame::turns
   */
  explicit ScanLocator(scan::ScanFrame& frame, bool may_turn = false);

  /** \brief Appends points of a row.
   * \param[in] row of their pixels; rows ascend
   * \param[in] columns of their rays, ascending
   * \param[in] positions world coordinates of all points, metres
   * \param[in] points of the row, indices of their positions
   * \return false if one is 2^26 edges or more from the grid, or not finite
   */
  bool
  append(std::uint32_t row,
         const std::vector<std::uint32_t>& columns,
         const std::vector<std::array<double, 3>>& positions,
         const std::uint32_t* points);

private:
  /** \brief A pixel, and its ray. */
  struct Place {
    std::uint32_t pixel;
    std::uint32_t column;
    std::int32_t turn;
  };

  std::int32_t
  turnOf(std::uint32_t row, std::uint32_t column, const scan::Triple& place) const;

  bool
  isAtSensor(const scan::Triple& place) const;

  std::optional<scan::Triple>
  placeOf(const std::array<double, 3>& position) const;

  void
  locate(const Place& where, const scan::Triple& place, std::uint32_t& depth);

  scan::ScanFrame& frame_;
  scan::ScanRayReader rays_;
  CertainDepths certain_depths_;
  scan::Triple sensor_;
  double scale_;                 // units of a place for a metre
  std::array<double, 3> corner_; // of the grid, metres
  double turn_step_ = 0.0;       // radians; 0: rays do not turn
};

/** \brief The points of a cloud with their pixels. */
struct ScanPoints {
  const std::vector<std::array<double, 3>>& positions; ///< world coordinates, metres
  const std::vector<std::uint32_t>& pixels;            ///< of each, no two the same
  const std::vector<std::uint32_t>& order; ///< the points in the order of their pixels
  bool may_turn;                           ///< see ScanLocator
};

/** \brief Puts all points on the rays of a scan, with several threads if they are many.
 * \param[in] threads at most so many
 * \param[in,out] scan its grid, size and rays are given; its points are set
 * \return false if one is too far from the grid
 */
bool
locateScan(const ScanPoints& points, std::size_t threads, scan::ScanFrame& scan);

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "codec/scan/scan_frame.h"
#include "voxelizing/certain_depths.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Puts points on the rays of a scan. Each coordinate is off by at most half an
 * edge: on the ray if that is near enough, else whole edges beside it. */
class ScanLocator {
public:
  /** \param[in,out] frame its grid, size and rays are given; points are appended */
  explicit ScanLocator(scan::ScanFrame& frame);

  /** \brief Appends points of a row.
   * \param[in] row of their pixels; rows ascend
   * \param[in] columns of their rays, ascending
   * \param[in] positions world coordinates of all points, metres
   * \param[in] points of the row, indices of their positions
   * \param[in] turns of all points, see ScanFrame::turns; empty: none is turned
   * \return false if one is 2^26 edges or more from the grid, or not finite
   */
  bool
  append(std::uint32_t row,
         const std::vector<std::uint32_t>& columns,
         const std::vector<std::array<double, 3>>& positions,
         const std::uint32_t* points,
         const std::vector<std::int32_t>& turns);

private:
  /** \brief A pixel, and its ray. */
  struct Place {
    std::uint32_t pixel;
    std::uint32_t column;
    std::int32_t turn;
  };

  bool
  locate(const Place& where,
         const std::array<double, 3>& position,
         std::uint32_t& depth);

  scan::ScanFrame& frame_;
  scan::ScanRayReader rays_;
  CertainDepths certain_depths_;
  scan::Triple sensor_;
  double scale_;                 // units of a place for a metre
  std::array<double, 3> corner_; // of the grid, metres
};

} // namespace io
} // namespace pcl_ext

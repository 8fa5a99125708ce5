// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "codec/scan/scan_frame.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Puts points on the rays of a scan. Each coordinate is off by at most half an
 * edge: on the ray if that is near enough, else whole edges beside it. */
class ScanLocator {
public:
  /** \param[in,out] frame its grid, size and rays are given; points are appended */
  explicit ScanLocator(scan::ScanFrame& frame);

  /** \brief Appends a point.
   * \param[in] row of its pixel; pixels ascend
   * \param[in] column of its ray
   * \param[in] position world coordinates, metres
   * \param[in] turn see ScanFrame::turns
   * \return false if it is 2^26 edges or more from the grid, or not finite
   */
  bool
  append(std::uint32_t row,
         std::uint32_t column,
         const std::array<double, 3>& position,
         std::int32_t turn = 0);

private:
  scan::ScanFrame& frame_;
  scan::ScanRayReader rays_;
  scan::Triple sensor_;
  double scale_;                 // units of a place for a metre
  std::array<double, 3> corner_; // of the grid, metres
  std::uint32_t row_ = 0;
};

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the rows of a spinning sensor whose lasers are at a few elevations, from
 * where points are. */
class ElevationRows {
public:
  /** \brief Learns the elevations.
   * \param[in] points of a cloud, some thousands are enough; in the coordinates of the
   * sensor, metres
   * \param[in] least_points that are not near, for there to be rows
   * \return false if they are not at a few ones, and there are no rows
   */
  bool
  learn(const std::vector<Eigen::Vector3d>& points, std::size_t least_points);

  /** \brief Number of rows; 0 before learn() found some. */
  std::uint32_t
  count() const
  {
    return static_cast<std::uint32_t>(ends_.size());
  }

  /** \brief The row of the next point of a cloud, the lowest one being 0: that of the
   * nearest elevation.
   * \param[in] slope of the point: height over the distance from the axis */
  std::uint32_t
  nextRow(double slope);

private:
  std::vector<double> ends_; // slopes between the rows; the last one is infinite
  std::vector<std::uint32_t> next_rows_; // the row that came behind each one
  std::uint32_t last_row_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

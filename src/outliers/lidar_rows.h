// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/version.h>

#include "voxelizing/elevation_rows.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief A point in the coordinates of a lidar. */
struct LidarPoint {
  float range = 0.0f;   ///< metres; 0: none
  float azimuth = 0.0f; ///< turns, from 0 to below 1, or 1 by rounding
  float slope = 0.0f;   ///< height over the distance from the axis
};

constexpr std::uint32_t no_row = ~std::uint32_t{0};

/** \brief Finds the rows of the points of a lidar, the lowest one first. */
class LidarRows {
public:
  /** \brief Finds the rows of a cloud.
   * \param[in] points the cloud
   * \param[in] directions of its points
   * \return false if they have none
   */
  bool
  find(const io::PointView& points, const std::vector<LidarPoint>& directions);

  /** \brief Number of rows. */
  std::uint32_t
  count() const
  {
    return count_;
  }

  /** \brief Row of each point, or no_row. */
  const std::vector<std::uint32_t>&
  ofPoints() const
  {
    return rows_;
  }

private:
  /** \brief What rows are told by. */
  enum class Source { None, Image, Ring, Elevations, Turns };

  bool
  isFoundIn(Source source,
            const io::PointView& points,
            const std::vector<LidarPoint>& directions);

  bool
  readRows(Source source,
           const io::PointView& points,
           const std::vector<LidarPoint>& directions);

  bool
  readRings(const io::FieldView& rings, const std::vector<LidarPoint>& directions);

  bool
  readImage(const io::PointView& points);

  bool
  findByElevation(const std::vector<LidarPoint>& directions);

  bool
  findByTurns(const std::vector<LidarPoint>& directions);

  bool
  areCones(Source source, const std::vector<LidarPoint>& directions) const;

  void
  sortRows(const std::vector<LidarPoint>& directions);

  void
  rankRows(const std::vector<LidarPoint>& directions);

  Source source_ = Source::None; // of the last cloud that had rows
  std::uint32_t count_ = 0;
  std::vector<std::uint32_t> rows_;
  io::ElevationRows elevation_rows_;
  std::size_t elevation_points_ = 0; // of the cloud that they were last looked for in
  // Of the last cloud whose rows were looked at.
  std::uint32_t checked_rows_ = 0;
  std::size_t checked_points_ = 0;
  std::vector<std::uint32_t> turn_rows_; // scratch memory
  // Of rows, in any cloud: means of the sines, NaN without points, and places by these.
  std::vector<double> elevations_;
  std::vector<std::uint32_t> ranks_; // no_row: without points
  std::uint32_t ranked_rows_ = 0;
  bool are_ranked_ = false; // all rows, in their order
};

} // namespace pcl_ext::PCL_EXT_ABI

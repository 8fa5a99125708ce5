// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/version.h>

#include "outliers/lidar_rows.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

constexpr std::uint32_t no_pixel = ~std::uint32_t{0};

/** \brief The image that the points of a lidar that turns are of: rows from the lowest
 * one up, columns of equal azimuth from one turn's begin to its end. */
class LidarImage {
public:
  /** \brief Finds the pixels of a cloud.
   * \return false if there are no rows; after three such clouds only each sixteenth one
   * is looked at
   */
  bool
  assign(const io::PointView& points);

  std::uint32_t
  width() const
  {
    return width_;
  }

  std::uint32_t
  height() const
  {
    return rows_.count();
  }

  /** \brief Range of each pixel, metres, row after row; 0 without a point. */
  const std::vector<float>&
  ranges() const
  {
    return ranges_;
  }

  /** \brief Pixel of each point, row * width + column; or no_pixel of points without a
   * direction, or behind another one in the same direction. */
  const std::vector<std::uint32_t>&
  pixels() const
  {
    return pixels_;
  }

private:
  /** \brief A point in the place of another one. */
  struct Repetition {
    std::uint32_t point;
    std::uint32_t of; // index in placed_
  };

  bool
  findPixels(const io::PointView& points);

  void
  readPoints(const io::PointView& points);

  void
  findWidth();

  void
  sortByDirection();

  void
  placeRow(std::uint32_t row);

  std::vector<LidarPoint> points_;
  LidarRows rows_;
  std::uint32_t width_ = 0;
  std::size_t width_points_ = 0; // of the cloud that it is of
  unsigned int failures_ = 0;    // in a row
  unsigned int skipped_ = 0;     // clouds that are not looked at
  std::vector<float> ranges_;
  std::vector<std::uint32_t> pixels_;
  // Points row after row, by azimuth; and where those of each direction begin.
  std::vector<std::uint32_t> sorted_;
  std::vector<std::uint32_t> begins_;
  std::vector<std::uint32_t> directions_; // of points, row * width + column
  // Of a row: points with columns of their own, their columns, and the others.
  std::vector<std::uint32_t> placed_;
  std::vector<std::uint32_t> columns_;
  std::vector<Repetition> repetitions_;
};

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxelizing/ray_fit.h"
#include "voxelizing/robust_fit.h"
#include "voxelizing/turn_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Angles of points against those of their columns and rows. */
class ColumnAngles {
public:
  /** \param[in] samples of which each column has one */
  explicit ColumnAngles(const std::vector<TurnPoint>& samples)
  {
    std::uint32_t count = 0;
    for (const TurnPoint& point : samples)
      count = std::max(count, point.column + 1);
    angles_.resize(count);
    // Means are of differences from these, as angles wrap.
    for (const TurnPoint& point : samples)
      angles_[point.column] = point.azimuth;
  }

  const std::vector<double>&
  angles() const
  {
    return angles_;
  }

  /** \brief Turns each column to the mean of its points, but for those that are far
   * off. */
  void
  turnColumns(const std::vector<TurnPoint>& samples,
              const std::vector<RowFit>& rows,
              double most)
  {
    sums_.assign(angles_.size(), 0.0);
    counts_.assign(angles_.size(), 0.0);
    for (const TurnPoint& point : samples)
      if (const double off = angleOff(point, rows, angles_); std::abs(off) <= most) {
        sums_[point.column] += off;
        counts_[point.column] += 1.0;
      }
    for (std::size_t column = 0; column < angles_.size(); ++column)
      angles_[column] =
          wrapped(angles_[column] + sums_[column] / std::max(1.0, counts_[column]));
  }

  /** \brief Turns each row to the middle of its points.
   * \param[out] change of the angles between rows, the largest one
   * \return half of the points were nearer to their rays than this, radians
   */
  double
  turnRows(const std::vector<TurnPoint>& samples,
           std::vector<RowFit>& rows,
           double& change)
  {
    off_of_rows_.resize(rows.size());
    for (std::vector<double>& off : off_of_rows_)
      off.clear();
    for (const TurnPoint& point : samples)
      off_of_rows_[point.row].push_back(angleOff(point, rows, angles_));
    off_.clear();
    double most = -two_pi;
    double least = two_pi;
    for (std::size_t row = 0; row < rows.size(); ++row) {
      std::vector<double>& off = off_of_rows_[row];
      if (off.empty())
        continue;
      const double turn = quantileOf(off);
      rows[row].angle += turn;
      most = std::max(most, turn);
      least = std::min(least, turn);
      for (const double of_point : off)
        off_.push_back(of_point - turn);
    }
    change = most - least;
    return medianSize(off_);
  }

private:
  std::vector<double> angles_; // radians
  // Members so that their memory is reused.
  std::vector<double> sums_;
  std::vector<double> counts_;
  std::vector<std::vector<double>> off_of_rows_;
  std::vector<double> off_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

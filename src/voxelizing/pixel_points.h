// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/rigid_pose.h>

#include "voxelizing/ray_fit.h"
#include "voxelizing/sensor_cloud.h"
#include "voxelizing/spinning_fit.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The points of a cloud as points of pixels. */
class PixelPoints {
public:
  /** \param[in] cloud with pixels */
  PixelPoints(const SensorCloud& cloud, const WorldPose& pose)
  : cloud_(cloud), missing_(pose.translation()), to_sensor_(pose.inverse())
  {}

  /** \brief Where missing points are, if not at the sensor; in world coordinates. */
  void
  setMissing(const Eigen::Vector3d& place)
  {
    missing_ = place;
  }

  std::uint32_t
  rowOf(std::size_t point) const
  {
    return cloud_.pixels[point] / cloud_.columns;
  }

  std::uint32_t
  columnOf(std::size_t point) const
  {
    return cloud_.pixels[point] % cloud_.columns;
  }

  /** \brief In the coordinates of the sensor. */
  PixelPoint
  at(std::size_t point) const
  {
    return {
        rowOf(point), columnOf(point), to_sensor_ * vectorOf(cloud_.positions[point])};
  }

  /** \brief The points of the columns that firings are fitted with, but for the missing
   * ones. */
  std::vector<PixelPoint>
  ofSampledColumns(const SampledColumns& sampled) const
  {
    std::vector<PixelPoint> points;
    for (std::size_t i = 0; i < cloud_.size(); ++i)
      if (sampled.has(columnOf(i)) && !isMissing(i))
        points.push_back(at(i));
    return points;
  }

  /** \brief Some points of each row, by pairs of neighbours, but for the missing
   * ones. */
  std::vector<PixelPoint>
  ofEachRow(std::uint32_t row_count) const
  {
    constexpr std::size_t enough_pairs = 32;
    std::vector<std::size_t> every(row_count);
    RowReader rows(cloud_);
    for (std::size_t i = 0; i < cloud_.size(); ++i)
      every[rows.rowOf(i)] += isMissing(i) ? 0 : 1;
    for (std::size_t& count : every)
      count = std::max<std::size_t>(1, count / 2 / enough_pairs);
    std::vector<std::size_t> seen(row_count);
    std::vector<PixelPoint> points;
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      const std::uint32_t row = rows.rowOf(i);
      if (!isMissing(i) && seen[row]++ / 2 % every[row] == 0)
        points.push_back(at(i));
    }
    return points;
  }

private:
  /** \brief Tells the rows of one point after the other without a division for each. */
  class RowReader {
  public:
    explicit RowReader(const SensorCloud& cloud) : cloud_(cloud) {}

    std::uint32_t
    rowOf(std::size_t point)
    {
      const std::uint32_t pixel = cloud_.pixels[point];
      if (pixel - row_ * cloud_.columns >= cloud_.columns)
        row_ = pixel / cloud_.columns;
      return row_;
    }

  private:
    const SensorCloud& cloud_;
    std::uint32_t row_ = 0; // of the last point
  };

  bool
  isMissing(std::size_t point) const
  {
    return isAtSensor(vectorOf(cloud_.positions[point]) - missing_);
  }

  const SensorCloud& cloud_;
  Eigen::Vector3d missing_;
  WorldPose to_sensor_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

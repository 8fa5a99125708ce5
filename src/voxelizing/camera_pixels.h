// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/rigid_pose.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds the pixels of points that a camera without distortion has seen, row by
 * row, of a cloud that has no missing points any more: the slopes of its rays are whole
 * steps apart, along rows and along columns. */
class CameraPixels {
public:
  /** \brief Finds the pixels of a cloud.
   * \param[in] positions in the order of the cloud, metres
   * \param[in] to_sensor their coordinates -> those of the camera, metres
   * \param[in] may_refit find other steps if those of before do not fit
   * \param[out] pixels of each point, row * width + column, ascending
   * \return false if there are none; pixels are unspecified
   */
  bool
  find(const std::vector<std::array<double, 3>>& positions,
       const WorldPose& to_sensor,
       bool may_refit,
       std::vector<std::uint32_t>& pixels);

  /** \brief Columns and rows. They stay until points are outside of them. */
  ImageSize
  size() const
  {
    return {columns_.count, rows_.count};
  }

private:
  /** \brief The slopes of the pixels along one side of an image. */
  struct Side {
    int axis = 0;       ///< of the camera's coordinates
    double begin = 0.0; ///< slope of the first pixel
    double step = 0.0;
    double per_slope = 0.0;  ///< 1 / step
    std::uint32_t count = 0; ///< of pixels; 0: unknown
  };

  struct Points;
  class Slopes;

  bool
  fit(const Points& points, std::vector<std::uint32_t>& pixels);

  Slopes
  slopesOf(const Points& points) const;

  static bool
  areAhead(const Slopes& slopes, const std::vector<std::uint32_t>& chosen);

  bool
  hasRowsOfSteps(const Slopes& slopes, const std::vector<std::uint32_t>& chosen);

  bool
  findColumns(const Slopes& slopes, const std::vector<std::uint32_t>& chosen);

  bool
  findRows(const Slopes& slopes);

  bool
  assign(const Slopes& slopes, std::vector<std::uint32_t>& pixels) const;

  std::uint32_t
  nearestPixel(const Slopes& slopes, std::size_t point, double& off) const;

  int depth_axis_ = 0;
  double depth_sign_ = 1.0;
  Side columns_;
  Side rows_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/scan/scan_frame.h"

#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief The place of the sensor, as that of a point. */
inline Triple
sensorPlace(const RayPose& pose)
{
  return {pose.origin[0] * (1 << 16),
          pose.origin[1] * (1 << 16),
          pose.origin[2] * (1 << 16)};
}

/** \brief Computes where the points of a frame are, one after the other. */
class PointPlaces {
public:
  /** \param[in] frame must not change meanwhile */
  explicit PointPlaces(const ScanFrame& frame) : frame_(frame), rays_(frame.rays) {}

  /** \brief The place of the next point, edges from the grid's lowest corner in units of
   * 2^-32. */
  Triple
  next()
  {
    const std::uint32_t pixel = frame_.pixels[point_];
    const std::uint32_t depth = frame_.depths[point_];
    const std::int32_t turn = frame_.turns.empty() ? 0 : frame_.turns[point_];
    ++point_;
    Triple place = sensorPlace(frame_.rays.pose);
    if (depth != at_sensor) {
      while (pixel >= row_end_) {
        row_end_ += frame_.width;
        row_begin_ = row_end_ - frame_.width + frame_.shiftOf(row_);
        rays_.moveTo(row_++);
      }
      const Ray ray = rays_.at(pixel - row_begin_, turn);
      place = {ray.at(depth, 0), ray.at(depth, 1), ray.at(depth, 2)};
    }
    if (beside_ < frame_.beside.size() && frame_.beside[beside_].pixel == pixel) {
      const PointBesideRay& point = frame_.beside[beside_++];
      for (std::size_t axis = 0; axis < 3; ++axis)
        place[axis] += std::int64_t{point.steps[axis]} * (std::int64_t{1} << 32);
    }
    return place;
  }

private:
  const ScanFrame& frame_;
  ScanRayReader rays_;
  std::uint32_t row_ = 0;       // the next one
  std::uint32_t row_end_ = 0;   // pixel after those of the current one
  std::uint32_t row_begin_ = 0; // its first pixel that has a ray
  std::size_t point_ = 0;
  std::size_t beside_ = 0;
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

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

/** \brief Computes where the points of a frame are.
 * \param[in] put called with the place of each: edges from the grid's lowest corner in
 * units of 2^-32
 */
template <class PutT>
void
visitPlaces(const ScanFrame& frame, const PutT& put)
{
  ScanRayReader rays(frame.rays);
  const Triple sensor = sensorPlace(frame.rays.pose);
  const std::int32_t* const turns = frame.turns.empty() ? nullptr : frame.turns.data();
  auto beside = frame.beside.begin();
  const std::size_t count = frame.pixels.size();
  std::size_t point = 0;
  for (std::uint32_t row = 0; point < count; ++row) {
    const std::uint32_t row_begin = row * frame.width + frame.shiftOf(row);
    const std::uint32_t row_end = (row + 1) * frame.width;
    rays.moveTo(row);
    for (; point < count && frame.pixels[point] < row_end; ++point) {
      const std::uint32_t pixel = frame.pixels[point];
      const std::uint32_t depth = frame.depths[point];
      Triple place = sensor;
      if (depth != at_sensor) {
        const std::int32_t turn = turns != nullptr ? turns[point] : 0;
        const Ray ray = rays.at(pixel - row_begin, turn);
        place = {ray.at(depth, 0), ray.at(depth, 1), ray.at(depth, 2)};
      }
      if (beside != frame.beside.end() && beside->pixel == pixel) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          place[axis] += std::int64_t{beside->steps[axis]} * (std::int64_t{1} << 32);
        ++beside;
      }
      put(place);
    }
  }
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io

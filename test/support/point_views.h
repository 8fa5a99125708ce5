// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/point_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief A view of points, of which there must be one: x, y, z, and of four numbers the
 * intensity. */
template <typename NumberT, std::size_t size>
PointView
viewOf(const std::vector<std::array<NumberT, size>>& points, ImageSize image = {})
{
  PointView view;
  view.count = points.size();
  view.image = image;
  view.coordinate_stride = sizeof(points.front());
  if constexpr (std::is_same<NumberT, double>::value)
    view.double_coordinates = points.front().data();
  else
    view.coordinates = points.front().data();
  if constexpr (size == 4) {
    view.intensities = points.front().data() + 3;
    view.intensity_stride = view.coordinate_stride;
  }
  return view;
}

/** \brief A point with an intensity and a colour. */
struct ColouredPoint {
  float x, y, z;
  float intensity;
  std::uint32_t colour;
};

inline PointView
viewOf(const std::vector<ColouredPoint>& points)
{
  static const ColouredPoint none{};
  const ColouredPoint& first = points.empty() ? none : points.front();
  PointView view;
  view.count = points.size();
  view.coordinates = &first.x;
  view.intensities = &first.intensity;
  view.colours = &first.colour;
  view.coordinate_stride = view.intensity_stride = view.colour_stride = sizeof(first);
  return view;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test

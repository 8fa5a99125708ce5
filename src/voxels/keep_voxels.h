// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "voxels/point_voxels.h"

#include <algorithm>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Removes voxels of a frame, with their intensities, colours, numbers of
 * points, fields and points. A cloud of one row has no missing points afterwards.
 * \param[in,out] frame as isConsistent() demands; the voxels that stay keep their order
 * \param[in] is_kept is called with the index of each voxel, in order
 * \return number of voxels removed
 */
template <typename IsKeptT>
std::size_t
keepVoxels(VoxelFrame& frame, IsKeptT&& is_kept)
{
  const std::size_t count = frame.size();
  const auto move =
      [](auto& values, std::size_t from, std::size_t number, std::size_t to) {
        if (from != to && !values.empty())
          std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(from),
                      number,
                      values.begin() + static_cast<std::ptrdiff_t>(to));
      };
  // Calls change(values, values of a point) for all that the frame has of each point.
  const auto of_points = [&frame](auto change) {
    for (FrameField& field : frame.fields)
      change(field.numbers, field.count);
    change(frame.points.indices, 1);
    change(frame.points.positions, 1);
    change(frame.points.intensities, 1);
    change(frame.points.colours, 1);
  };
  const bool has_values = frame.points.areThere() || !frame.fields.empty();
  std::size_t kept = 0;
  std::size_t point = 0;
  std::size_t kept_points = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t points = frame.point_counts.empty() ? 1 : frame.point_counts[i];
    if (has_values)
      of_points([&](auto& values, std::size_t of_point) {
        move(values, point * of_point, points * of_point, kept_points * of_point);
      });
    point += points;
    // Written in any case, as a branch would be mispredicted.
    frame.keys[kept] = frame.keys[i];
    if (!frame.intensities.empty())
      frame.intensities[kept] = frame.intensities[i];
    if (!frame.colours.empty())
      frame.colours[kept] = frame.colours[i];
    if (!frame.point_counts.empty())
      frame.point_counts[kept] = frame.point_counts[i];
    const bool is_kept_one = is_kept(i);
    kept += is_kept_one ? 1 : 0;
    kept_points += is_kept_one ? points : 0;
  }
  frame.keys.resize(kept);
  frame.intensities.resize(frame.intensities.empty() ? 0 : kept);
  frame.colours.resize(frame.colours.empty() ? 0 : kept);
  frame.point_counts.resize(frame.point_counts.empty() ? 0 : kept);
  of_points([&](auto& values, std::size_t of_point) {
    values.resize(values.empty() ? 0 : kept_points * of_point);
  });
  if (frame.points.height == 1)
    closeGaps(frame.points);
  return count - kept;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

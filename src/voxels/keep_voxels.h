#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <algorithm>
#include <cstddef>

namespace pcl_ext {
namespace io {

/** \brief Removes voxels of a frame, with their intensities, colours, numbers of points
 * and fields.
 * \param[in,out] frame as isConsistent() demands; the voxels that stay keep their order
 * \param[in] is_kept is called with the index of each voxel, in order
 * \return number of voxels removed
 */
template <typename IsKeptT>
std::size_t
keepVoxels(VoxelFrame& frame, IsKeptT&& is_kept)
{
  const std::size_t count = frame.size();
  std::size_t kept = 0;
  std::size_t point = 0;
  std::size_t kept_points = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t points = frame.point_counts.empty() ? 1 : frame.point_counts[i];
    for (FrameField& field : frame.fields)
      if (kept_points != point)
        std::copy_n(field.numbers.begin() +
                        static_cast<std::ptrdiff_t>(point * field.count),
                    points * field.count,
                    field.numbers.begin() +
                        static_cast<std::ptrdiff_t>(kept_points * field.count));
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
  for (FrameField& field : frame.fields)
    field.numbers.resize(kept_points * field.count);
  return count - kept;
}

} // namespace io
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/point_contents.h"

#include "codec/frame_limits.h"
#include "voxelizing/voxel_locator.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_ext {
namespace io {

namespace {

/** \brief The voxel of a position, from which fields are predicted; far away it is at the
 * farthest one. */
std::array<std::int32_t, 3>
viewpointOf(const Eigen::Vector3d& position, const VoxelGrid& grid)
{
  std::array<std::int32_t, 3> viewpoint{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double voxels =
        (position[static_cast<Eigen::Index>(axis)] - grid.origin[axis]) /
            grid.resolution -
        static_cast<double>(grid.first_index[axis]);
    constexpr double far = farthest_viewpoint;
    viewpoint[axis] =
        std::isfinite(voxels)
            ? static_cast<std::int32_t>(std::clamp(std::floor(voxels), -far, far))
            : 0;
  }
  return viewpoint;
}

} // namespace

/** \brief How many pixels an image of a frame's points may have: where voxels have many
 * points, or pixels few, it would take more bytes than voxels. */
std::uint64_t
PointContents::mostPixels(const EncoderSettings& settings,
                          const Frame& next,
                          const VoxelFrame& frame) const
{
  constexpr std::size_t most_points_of_voxel = 4;
  constexpr std::size_t most_pixels_of_point = 64;
  if (frame.keys.empty() || !frame.has_point_counts || !next.takes_images)
    return 0;
  // Without missing points, which are all in the same voxel.
  const std::size_t points =
      next.points_used -
      *std::max_element(frame.point_counts.begin(), frame.point_counts.end());
  // An image takes a byte for four points, or more.
  const FrameLimits limits = frameLimits(settings.decoder_limits, points / 4);
  const std::size_t values = fields_.valuesOfPoint();
  // Fields are those of pixels, whatever the voxels.
  const bool has_many = values == 0 && points > most_points_of_voxel * frame.size();
  if (next.is_i_frame_due && has_many)
    return 0;
  std::uint64_t most = std::min<std::uint64_t>(most_image_pixels, limits.max_points);
  if (values > 0)
    most = std::min<std::uint64_t>(most, limits.max_field_values / values);
  return next.is_i_frame_due
             ? std::min<std::uint64_t>(most, most_pixels_of_point * points)
             : most;
}

CompressionStatus
PointContents::collect(PointBatches& points,
                       const WorldPose& sensor_pose,
                       const EncoderSettings& settings,
                       const Frame& next,
                       VoxelFrame& frame)
{
  const std::uint64_t most_pixels = mostPixels(settings, next, frame);
  const bool wants_image =
      most_pixels > 0 && image_.begin(points, sensor_pose, most_pixels);
  const bool collects = wants_image || !settings.fields.empty();
  if (memory_rule_.shouldRelease(collects ? 64 * next.points_used : 0)) {
    fields_.releaseMemory();
    image_.releaseMemory();
  }
  frame.image = PointImage();
  // A cloud without points has no other order than those before it.
  if (frame.keys.empty() && !next.is_i_frame_due && next.takes_images)
    frame.image = image_.rays();
  if (!collects) {
    frame.fields.clear();
    return {};
  }
  EncoderSettings of_voxels = settings;
  of_voxels.resolution = frame.grid.resolution;
  VoxelLocator locator(of_voxels);
  if (!settings.bounding_box)
    locator.setGrid(frame.grid);
  if (CompressionStatus status = fields_.collect(
          points, locator, wants_image ? &image_ : nullptr, next.is_i_frame_due, frame);
      !status.ok())
    return status;
  frame.viewpoint = viewpointOf(sensor_pose.translation(), frame.grid);
  return {};
}

} // namespace io
} // namespace pcl_ext

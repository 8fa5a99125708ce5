// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/point_image.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/rigid_pose.h>

#include "voxelizing/located_points.h"
#include "voxelizing/ray_fit.h"
#include "voxelizing/ring_columns.h"
#include "voxels/rays.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Collects the pixels of the points of clouds that have a sensor's order, and
 * fits the rays of their images. Clouds without rows and columns have an order if their
 * points have a field `ring`, the row of a spinning sensor. */
class ImageCollector {
public:
  ImageCollector() = default;
  ImageCollector(const ImageCollector&) = delete;
  ImageCollector&
  operator=(const ImageCollector&) = delete;

  /** \brief Begins a cloud.
   * \param[in] points the cloud
   * \param[in] sensor_pose sensor -> cloud, metres
   * \param[in] most_pixels that its image may have
   * \return false if it has no order, or too many pixels
   */
  bool
  begin(const PointBatches& points,
        const WorldPose& sensor_pose,
        std::uint64_t most_pixels);

  /** \brief Adds the located points of the next points of the cloud.
   * \param[in] points the batch
   * \param[in] first index in the cloud of the first point of the batch
   */
  void
  add(const PointView& points, std::size_t first, const LocatedPoints& located);

  /** \brief Number of points that were added. */
  std::size_t
  size() const
  {
    return points_.size();
  }

  /** \brief Pixel of a point that was added. */
  std::uint32_t
  pixel(std::size_t point) const
  {
    return points_[point].row * size_.width + points_[point].column;
  }

  /** \brief Sets size and rays of an image: those of the last cloud, turned where the
   * pose or the grid is another one, or new ones where the size is.
   * \param[in] may_refit fit new ones, too, if those of the last cloud do not fit
   * \param[in] grid of the voxels
   * \param[out] image without points
   * \return false if points are not along rays, or share a pixel, or if there are too
   * many pixels
   */
  bool
  fit(bool may_refit, const VoxelGrid& grid, PointImage& image);

  /** \brief Size and rays of the last fit(), without points. */
  const PointImage&
  rays() const
  {
    return rays_;
  }

  /** \brief The depth of a point that was added, on the rays of the last fit().
   * \param[in] key Morton key of its voxel
   */
  std::uint32_t
  depth(std::size_t point, std::uint64_t key);

  /** \brief Releases the memory of the last cloud; the rays stay. */
  void
  releaseMemory();

private:
  bool
  arePixels();

  bool
  arePointsAtSensor() const;

  void
  fitRaysOfSize(const VoxelGrid& grid, double shift);

  void
  turnRays(const VoxelGrid& grid, const WorldPose& pose);

  bool
  hasManyMorePoints() const;

  bool
  areAlongRays() const;

  double
  distanceFromRays() const;

  bool
  setColumns(bool may_refit, double& shift, bool& is_refitted);

  ImageSize size_{};
  std::uint64_t most_pixels_ = 0;
  std::optional<std::size_t> ring_; // field; nothing: the cloud has rows and columns
  bool has_other_ring_ = false;     // than a number of a row
  RingColumns ring_columns_;
  WorldPose from_sensor_ = WorldPose::Identity();
  WorldPose to_sensor_ = WorldPose::Identity();
  std::vector<PixelPoint> points_; // of the current cloud
  std::vector<bool> is_taken_;
  std::optional<FittedRays> fitted_;       // last
  std::size_t fitted_points_ = 0;          // that they were fitted to
  double fitted_distance_ = 0.0;           // of these from the rays, median, voxels
  PointImage rays_;                        // of these, without points
  VoxelGrid grid_;                         // of rays_
  WorldPose pose_ = WorldPose::Identity(); // likewise
  std::optional<RayReader> reader_;        // of rays_, if points are along them
};

} // namespace io
} // namespace pcl_ext

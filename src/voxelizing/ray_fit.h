// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/rigid_pose.h>

#include "codec/scan/scan_frame.h"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief A point of a scan, in the coordinates of its sensor, metres. */
struct PixelPoint {
  std::uint32_t row;
  std::uint32_t column;
  Eigen::Vector3d position;
};

/** \brief Whether a point is at the sensor, as drivers write missing ones; a
 * thousandth of a millimetre is lost in poses. */
inline bool
isAtSensor(const PixelPoint& point)
{
  return point.position.squaredNorm() < 1e-12;
}

/** \brief Rays in the coordinates of a sensor, metres; see scan::ScanRays. */
struct FittedRays {
  /** \brief Of a row of a spinning sensor; see scan::RayRow. */
  struct Row {
    double angle = 0.0; ///< radians
    double run = 0.0;   ///< metres for a metre of depth, as rise
    double rise = 0.0;
    double along = 0.0; ///< metres, as across and up
    double across = 0.0;
    double up = 0.0;
  };

  scan::RayShape shape = scan::RayShape::Planar;
  Eigen::Matrix3d plane = Eigen::Matrix3d::Zero(); ///< columns as RayPose::vectors
  double turn = 0.0;                               ///< of a column, radians
  std::vector<Row> rows;
  /** \brief Distance of the depths that there are, metres; 0: depths of any size. */
  double depth_step = 0.0;
};

/** \brief Fits the rays of a camera.
 * \return nothing if there are too few points for it
 */
std::optional<FittedRays>
fitPlanarRays(const std::vector<PixelPoint>& points);

/** \brief Fits the rays of a spinning sensor, whose axis is z.
 * \param[in] points row after row, if the turn is not known
 * \param[in] size of the image
 * \param[in] turn of a column, radians, if it is known
 */
std::optional<FittedRays>
fitSpinningRays(const std::vector<PixelPoint>& points,
                const ImageSize& size,
                const std::optional<double>& turn);

/** \brief Fits the rays of an image of either kind of sensor.
 * \param[in] points row after row
 * \param[in] sensor_pose sensor -> grid, metres
 * \param[in] grid where the rays are to be
 * \param[in] size of the image
 * \return nothing if there are no such rays
 */
std::optional<FittedRays>
fitRays(const std::vector<PixelPoint>& points,
        const WorldPose& sensor_pose,
        const VoxelGrid& grid,
        const ImageSize& size);

/** \brief The distance of the depths on rays, metres: that of the sensor, if it is neither
 * much smaller than an edge, which nobody sees, nor too large for a scan. */
double
depthStepFor(double fitted_step, double resolution);

/** \brief Sets the rays of a scan to fitted ones.
 * \param[in] sensor_pose sensor -> grid, metres
 * \param[in] grid where the rays are to be
 * \param[in,out] layout its size is given, rays are set, with columns a step apart
 * \return whether they are within their ranges
 */
bool
setRays(const FittedRays& fitted,
        const WorldPose& sensor_pose,
        const VoxelGrid& grid,
        scan::ScanLayout& layout);

} // namespace io
} // namespace pcl_ext

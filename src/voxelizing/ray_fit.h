// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/rigid_pose.h>

#include "codec/scan/scan_frame.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief A point of a scan, in the coordinates of its sensor, metres. */
struct PixelPoint {
  std::uint32_t row;
  std::uint32_t column;
  Eigen::Vector3d position;
};

/** \brief Whether a position is that of the sensor, as drivers write missing points; a
 * thousandth of a millimetre is lost in poses. */
inline bool
isAtSensor(const Eigen::Vector3d& from_sensor)
{
  return from_sensor.squaredNorm() < 1e-12;
}

/** \brief Where points are, and how far from there, metres. */
struct Extent {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double mean_distance = 0.0;

  explicit Extent(const std::vector<PixelPoint>& points)
  {
    const auto count = static_cast<double>(points.size());
    for (const PixelPoint& point : points)
      middle += point.position / count;
    for (const PixelPoint& point : points)
      mean_distance += (point.position - middle).norm() / count;
  }
};

/** \brief Rays of a row of a spinning sensor, in its coordinates; see scan::RayRow. */
struct RowFit {
  double angle = 0.0; ///< radians
  double run = 0.0;   ///< metres for a metre of depth, as rise
  double rise = 0.0;
  double along = 0.0; ///< metres, as across and up
  double across = 0.0;
  double up = 0.0;
};

/** \brief Depths on the rays of a camera, where those of the sensor are finer. */
struct PlanarDepths {
  double edges = 1.0;          ///< from one to the next
  bool has_half_depths = true; ///< see scan::ScanRays
};

/** \brief Rays of a camera, in its coordinates, metres. */
struct PlanarFit {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< of all rays
  Eigen::Matrix3d plane = Eigen::Matrix3d::Zero();  ///< columns as RayPose::vectors
  /** \brief Distance of the depths that there are, metres; 0: depths of any size. */
  double depth_step = 0.0;
  PlanarDepths depths;
};

/** \brief Fits the rays of a camera at the origin that looks along an axis.
 * \return nothing if there are too few points for it
 */
std::optional<PlanarFit>
fitPlanar(const std::vector<PixelPoint>& points);

/** \brief Fits the rays of a camera anywhere (direct linear transformation).
 * \param[in] points finite
 * \return nothing if there are too few points for it
 */
std::optional<PlanarFit>
fitPlanarAnywhere(const std::vector<PixelPoint>& points);

/** \brief The distance of the depths on rays, metres: that of the sensor, if it is
 * neither much smaller than an edge, which nobody sees, nor too large for a scan. */
double
depthStepFor(double fitted_step, double resolution);

/** \brief Chooses depths on rays so that scans take few bytes: where the camera does not
 * look along an axis of the grid, many points may be beside depths that are an edge apart.
 * \param[in] points of the fit
 * \param[in] sensor_pose sensor -> grid, metres
 * \param[in] resolution edge of the voxels, metres
 */
PlanarDepths
chooseDepths(const std::vector<PixelPoint>& points,
             const WorldPose& sensor_pose,
             double resolution,
             const PlanarFit& fit);

/** \brief Sets the rays of a scan to those of a camera.
 * \param[in] sensor_pose sensor -> grid, metres
 * \param[in] grid where the rays are to be
 * \param[in,out] layout its size is given
 * \return whether they are within their ranges
 */
bool
setPlanarRays(const PlanarFit& fit,
              const WorldPose& sensor_pose,
              const VoxelGrid& grid,
              scan::ScanLayout& layout);

/** \brief Median distance of points from the rays of their pixels, edges.
 * \param[in] points in the coordinates of the sensor; of none it is 0
 * \param[in] pose sensor -> grid, metres
 * \param[in] layout isConsistent(); its rays, with columns
 */
double
distanceFromRays(const std::vector<PixelPoint>& points,
                 const WorldPose& pose,
                 const VoxelGrid& grid,
                 const scan::ScanLayout& layout);

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxelizing/ray_fit.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief How a sensor moved during a turn, to places of its middle. Times are those of
 * columns, from -1/2 to 1/2. */
struct TurnMotion {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();    ///< metres, at time 0
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(); ///< metres a turn
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();     ///< radians a turn, small

  /** \brief Where a point would be if the sensor stood still. */
  Eigen::Vector3d
  stillPosition(const Eigen::Vector3d& position, double time) const
  {
    const Eigen::Vector3d from_sensor = position - shift - time * velocity;
    return from_sensor - time * spin.cross(from_sensor);
  }
};

/** \brief The time of a column. */
inline double
timeOf(std::uint32_t column, std::uint32_t column_count)
{
  return static_cast<double>(column) / column_count - 0.5;
}

/** \brief A point of a row and a column, where it would be if the sensor stood still. */
struct TurnPoint {
  std::uint32_t row;
  std::uint32_t column; // among those that are used
  double time;          // of its column, from -1/2 to 1/2
  Eigen::Vector3d measured;
  Eigen::Vector3d position;
  double azimuth;
  double distance; // from the axis

  /** \param[in] used_column among those that are used
   * \param[in] time_of_column from -1/2 to 1/2
   */
  TurnPoint(const PixelPoint& point,
            std::uint32_t used_column,
            double time_of_column,
            const TurnMotion& motion)
  : row(point.row), column(used_column), time(time_of_column), measured(point.position)
  {
    place(motion);
  }

  void
  place(const TurnMotion& motion)
  {
    position = motion.stillPosition(measured, time);
    azimuth = std::atan2(position.y(), position.x());
    distance = std::hypot(position.x(), position.y());
  }
};

/** \brief How far a point is above the rays of its row, metres. */
double
heightOff(const TurnPoint& point, const std::vector<RowFit>& rows);

/** \brief An angle of a point against that of its column and its row, radians. */
double
angleOff(const TurnPoint& point,
         const std::vector<RowFit>& rows,
         const std::vector<double>& columns);

/** \brief One step towards the motion with which points are on the rays of their rows and
 * columns: least squares of the angles that they are off.
 * \param[in,out] points are placed by the motion
 * \param[in] rows fitted to them
 * \param[in] columns angles of them, radians; empty: only heights are compared
 * \param[in,out] motion the one before
 * \return how far the step moves points that are some metres away, at most, metres
 */
double
improveMotion(std::vector<TurnPoint>& points,
              const std::vector<RowFit>& rows,
              const std::vector<double>& columns,
              TurnMotion& motion);

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The simulated robot cell: six Kinect V2 and a lidar that look at moving
 * robots.
 */
#pragma once

#include "simulator/lidar_weather.h"
#include "simulator/sensor_motion.h"
#include "simulator/time_of_flight_camera.h"
#include "simulator/velodyne_lidar.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace cell {

/** \brief What a pixel looks at, as far as it can move. */
enum class Mover : std::uint8_t {
  None,    ///< what never moves, or nothing at all
  Machine, ///< an arm, its carriage or the gantry, also while it pauses
  Person   ///< the person, also while standing
};

/** \brief One frame of one sensor. */
struct CellFrame {
  /** \brief Organised 512 x 424, in the sensor's frame (x right, y down, z along the
   * optical axis), metres, NaN where there is no return. header.stamp is in
   * microseconds since the stream's start, header.frame_id is "kinect_1" .. */
  pcl::PointCloud<pcl::PointXYZ> cloud;
  std::vector<PointTruth> truth; ///< one per point
  /** \brief Of the sensor in this frame, sensor frame -> world. */
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/** \brief One revolution of the lidar. */
struct LidarFrame {
  /** \brief Organised 1800 x 16, a ring a row, in the lidar's frame (x ahead, y left, z
   * up), metres, NaN where there is no return; intensity is the calibrated
   * reflectivity, whole numbers of 0..255. header.stamp is in microseconds since the
   * stream's start, header.frame_id is "velodyne_7". */
  pcl::PointCloud<pcl::PointXYZI> cloud;
  std::vector<PointTruth> truth; ///< one per point
  /** \brief Of the lidar in this revolution, its frame -> world. */
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/** \brief The 10 x 10 x 4 m cell of Dybedal, Aalerud, Hovland, Sensors 2019, 19(3),
 * 636, seen by the six Kinect V2 of its Table 1 and by a VLP-16 in a corner.
 *
 * World frame: origin in a floor corner, z up, metres. A frame depends on the seed, the
 * sensor, its motion and the frame number only, so frames may be asked for in any
 * order. Not safe for use by several threads at once; each thread needs a cell of its
 * own.
 */
class RobotCell {
public:
  static constexpr unsigned int sensor_count = 6;
  static constexpr double frame_rate = 20.0; ///< Hz
  static constexpr unsigned int lidar = 7;   ///< number of the lidar beside the sensors
  static constexpr double lidar_rate = 10.0; ///< revolutions a second

  explicit RobotCell(std::uint32_t seed = 1, const ErrorModel& model = ErrorModel());

  /** \brief Makes a sensor move. All rays of a frame, or of a revolution, are cast from
   * the pose at its start. The random numbers stay those of the sensor: a motion that
   * rests at a fixed sensor's pose gives the fixed sensor's frames.
   * \param[in] sensor 1 .. 6, or \ref lidar
   * \param[in] motion from now on; empty: the sensor is fixed in its own place again
   * \throws std::out_of_range for any other number
   */
  void
  moveSensor(unsigned int sensor, SensorMotion motion);

  /** \brief Pose of a sensor, sensor frame -> world.
   * \param[in] sensor 1 .. 6
   * \param[in] frame number of the frame, for a sensor that moves
   * \throws std::out_of_range for any other number
   */
  Eigen::Isometry3d
  sensorPose(unsigned int sensor, std::uint32_t frame = 0) const;

  /** \brief Corners of the crop box in the world frame, metres: the cell less 10 cm
   * above the floor. The paper does not give the limits of its own. */
  static Eigen::Vector3d
  cropMin();
  static Eigen::Vector3d
  cropMax();

  /** \brief Take one frame.
   * \param[in] sensor 1 .. 6
   * \param[in] frame number of the frame, from 0, at \ref frame_rate
   * \throws std::out_of_range for a sensor that is not there
   */
  void
  capture(unsigned int sensor, std::uint32_t frame, CellFrame& out);

  /** \brief Pose of the lidar, its frame -> world: the corner without a sensor, 2.5 m
   * up and tilted by 10 degrees towards the middle. The paper says "one of the corner
   * locations" and gives no pose.
   * \param[in] revolution its number, for a lidar that moves
   */
  Eigen::Isometry3d
  lidarPose(std::uint32_t revolution = 0) const;

  /** \brief Sets what is in the air between the lidar and the surfaces, from now on; the
   * cameras do not see it. The random numbers of the lidar itself stay the same. */
  void
  setLidarWeather(const LidarWeather& weather)
  {
    lidar_weather_ = weather;
  }

  /** \brief Take one revolution of the lidar.
   * \param[in] revolution its number, from 0, at \ref lidar_rate
   */
  void
  captureLidar(std::uint32_t revolution, LidarFrame& out);

  /** \brief What the lidar looks at in a revolution, without any error of measurement.
   * The reference is valid until the next call of this or of captureLidar(). */
  const SurfaceImage&
  lidarSurfaces(std::uint32_t revolution);

  /** \brief What the sensor looks at in a frame, without any error of measurement. The
   * reference is valid until the next call of this or of capture().
   * \throws std::out_of_range for a sensor that is not there
   */
  const SurfaceImage&
  surfaces(unsigned int sensor, std::uint32_t frame);

  /** \brief What each pixel of the last frame looks at, of the last call of capture()
   * or surfaces().
   * \param[out] movers one per pixel
   */
  void
  movers(std::vector<Mover>& movers) const;

  const ErrorModel&
  errorModel() const
  {
    return model_;
  }

private:
  /** \brief What a sensor sees from a pose of all that never moves. */
  struct StaticView {
    bool drawn = false;
    Eigen::Isometry3d pose;
    SurfaceImage surfaces;
    std::vector<PixelError> errors; ///< empty for the lidar
  };

  /** \brief Prepares a view for a pose.
   * \return true if it has to be drawn
   */
  static bool
  needsDrawing(const Eigen::Isometry3d& pose, std::size_t pixels, StaticView& view);

  const StaticView&
  staticView(unsigned int sensor, std::uint32_t frame);

  std::uint32_t seed_;
  ErrorModel model_;
  RayGrid rays_;
  std::array<SensorMotion, lidar> motions_; // by number from 1; empty: fixed
  std::array<StaticView, lidar> static_views_;

  // The frame being worked on; members to keep their memory.
  SurfaceImage surfaces_;
  std::vector<PixelError> errors_;
  std::vector<std::size_t> changed_; // pixels of the machines, then of the person
  std::size_t first_of_person_ = 0;  // index into the above
  Measurement measurement_;

  LidarErrorModel lidar_model_;
  LidarWeather lidar_weather_;
  LidarRays lidar_rays_;
  SurfaceImage lidar_surfaces_;
  LidarMeasurement lidar_measurement_;
};

} // namespace cell
} // namespace pcl_ext

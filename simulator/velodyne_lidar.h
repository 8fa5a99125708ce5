// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The rays of a Velodyne VLP-16 and the errors of its measurement.
 *
 * Sources. Of the manual only the pages named here were used.
 *
 * [M] Velodyne, "VLP-16 User Manual", 63-9243 Rev. D, 2018. Table 9-1: lasers at -15 to
 *     +15 degrees, 2 degrees apart. Section 6.1: a byte of calibrated reflectivity with
 *     each measurement, 0 to 100 for diffuse reflectors of 0 to 100 %, 101 to 255 for
 *     retroreflectors, "independent of laser power and distances involved".
 * [S] velodyne_simulator, the Gazebo plugin: 10 Hz, range 0.9 to 130 m, Gaussian noise
 * of
 *     8 mm by default.
 *
 * Everything else in \ref LidarErrorModel is a free parameter and documented as such.
 */
#pragma once

#include "simulator/shapes.h"
#include "simulator/time_of_flight_camera.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace cell {

/** \brief 16 rings ([M]) of 1800 rays, 0.2 degrees apart, in one revolution.
 *
 * The lidar's frame has x ahead, y to the left and z up. Ring 0 looks down the most;
 * columns begin ahead and run clockwise, as seen from above. Images are row by row, a
 * row is a ring, and the depth of a SurfaceImage is here the range along the ray.
 */
class LidarRays {
public:
  static constexpr std::size_t columns = 1800;
  static constexpr std::size_t rings = 16;
  static constexpr std::size_t size = columns * rings;

  LidarRays();

  /** \brief Unit vector of a ray in the lidar's frame. */
  Eigen::Vector3d
  direction(std::size_t pixel) const;

  /** \brief Draw solids into an image, in front of what it holds behind them. All rays
   * of a revolution are cast at once: what moves is not drawn out. */
  void
  trace(const Solids& solids,
        const Eigen::Isometry3d& world_to_lidar,
        SurfaceImage& image) const;

private:
  /** \brief A quarter of a revolution is an image plane of its own, so that solids are
   * met as by a camera. */
  static constexpr std::size_t quarters = 4;
  static constexpr std::size_t quarter_columns = columns / quarters;

  template <typename TargetT>
  void
  traceTarget(const TargetT& target,
              Material material,
              std::size_t quarter,
              SurfaceImage& image) const;

  std::array<double, quarter_columns> sideways_; ///< angle from the plane's centre
  std::array<double, rings> elevation_;          ///< radians
};

/** \brief One measured revolution; row by row as the rays. */
struct LidarMeasurement {
  std::vector<float> range;            ///< metres; 0: no return
  std::vector<std::uint8_t> intensity; ///< calibrated reflectivity
  std::vector<PointTruth> truth;
};

/** \brief The lidar's error model; its defaults are the simulator's. */
struct LidarErrorModel {
  /** \brief Standard deviation of the range, metres ([S]). */
  double range_noise = 0.008;

  /** \brief Steps of the range, metres. Free parameter. */
  double range_step = 0.002;

  /** \brief Ranges that are measured, metres ([S]). */
  double nearest = 0.9;
  double farthest = 130.0;

  /** \brief Probability that a return of any strength is missed. Free parameter. */
  double random_loss = 0.003;

  /** \brief Returned signal, reflectivity * cos(incidence) / range^2 in 1/m^2, above
   * which nothing is lost and below which everything is; smooth in between. Free
   * parameters: in the cell only dark surfaces that are grazed are lost. */
  double safe_signal = 0.0005;
  double lost_signal = 0.00005;

  /** \brief Step between neighbours of a ring that makes an echo of both, metres: below
   * the first figure it is one surface, above the second the device separates the
   * echoes and takes the stronger one. Free parameters. */
  double smallest_mixed_step = 0.1;
  double largest_mixed_step = 0.8;

  /** \brief Share of the rays at such a step whose echo is mixed. Free parameter. */
  double mixed_share = 0.3;

  /** \brief Range at which half of the intensity is lost although it is calibrated
   * ([M]: nothing is lost), metres. Free parameter. */
  double half_intensity_range = 30.0;

  /** \brief Standard deviation of the intensity, in its steps. Free parameter. */
  double intensity_noise = 2.0;

  /** \brief Measure an image once.
   * \param[in] random_seed of the revolution
   */
  void
  measure(const SurfaceImage& surfaces,
          std::uint32_t random_seed,
          LidarMeasurement& measurement) const;

  /** \brief Calibrated reflectivity without noise, 0..100: that of the material, which
   * falls with the angle of incidence and a little with the range.
   * \param[in] range metres
   */
  double
  intensity(Material material, double cos_incidence, double range) const;

  /** \brief Signal of a surface, reflectivity * cos(incidence) / range^2, 1/m^2. */
  static double
  signal(const SurfaceImage& surfaces, std::size_t pixel);

  /** \brief Share of the echoes of a signal that are returns, but for random losses. */
  double
  visibleShare(double signal) const;

  /** \brief A range in its steps, metres. */
  float
  rounded(double range) const;

private:
  /** \brief 0 for signals of which all is lost, 1 for those that are safe. */
  double
  strength(double signal) const;

  double
  lossProbability(const SurfaceImage& surfaces, std::size_t pixel) const;

  double
  mixedRange(const SurfaceImage& surfaces, std::size_t pixel, double share) const;
};

} // namespace cell
} // namespace pcl_ext

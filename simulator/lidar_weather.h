// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Falling snow and a cloud of dust between a lidar and what it looks at.
 *
 * Sources.
 *
 * [G] K. L. S. Gunn, J. S. Marshall, "The distribution with size of aggregate
 * snowflakes",
 *     Journal of Meteorology 15, 1958, pp. 452-461. Diameters of the melted flakes are
 *     exponential: N(D) = N0 exp(-L D), with the rate R in mm/h of water:
 *     N0 = 3800 R^-0.87 per m^3 and mm, L = 2.55 R^-0.48 per mm.
 * [H] M. Hahner, C. Sakaridis, M. Bijelic, F. Heide, F. Yu, D. Dai, L. Van Gool, "LiDAR
 *     Snowfall Simulation for Robust 3D Object Detection", CVPR 2022. Flakes of such
 *     diameters in each beam; an echo's power follows the share of the beam that a flake
 *     or the surface behind it fills, over range^2; the strongest echo is the return.
 *     Beams of 3 mrad, flakes that reflect 0.9, density of snow 0.1 g/cm^3, rates of 0.5
 *     to 2.5 mm/h. The idea only; nothing of their program is used.
 * [F] M. Hahner, C. Sakaridis, D. Dai, L. Van Gool, "Fog Simulation on Real LiDAR Point
 *     Clouds for 3D Object Detection in Adverse Weather", ICCV 2021. Extinction by
 *     Beer-Lambert, twice on the way, and backscatter of 0.046 / MOR per m and sr, with
 *     the meteorological optical range MOR = ln(20) / extinction; after R. Rasshofer, M.
 *     Spies, H. Spies, "Influences of weather phenomena on automotive laser radar
 *     systems", Advances in Radio Science 9, 2011. Of fog: for dust it is an assumption.
 *
 * Of [G] the formula was taken as later articles quote it. Everything else is a free
 * parameter and documented as such.
 */
#pragma once

#include "simulator/velodyne_lidar.h"

#include <Eigen/Geometry>

#include <cstdint>

namespace pcl_ext {
namespace cell {

/** \brief What is in the air. */
enum class Weather : std::uint8_t { None, Snow, Dust };

/** \brief Falling snow, everywhere. Each revolution has flakes of its own: at 10 Hz a
 * flake falls by a decimetre, which is many beams. */
struct Snowfall {
  /** \brief Rate, mm of water an hour, above 0 ([H]: 0.5 to 2.5). */
  double rate = 1.5;

  /** \brief Reflectivity of a flake ([H]). */
  double reflectivity = 0.9;

  /** \brief Of the flakes, g/cm^3 ([H]): a flake is larger than its water ([G]). */
  double density = 0.1;

  /** \brief Flakes are drawn up to this range, metres; further ones are far too weak to
   * be seen by a VLP-16. Free parameter. */
  double farthest = 20.0;
};

/** \brief A cloud of dust that stands in the cell. Its density falls with the distance
 * from the centre as a Gaussian, and is lumpy. */
struct DustCloud {
  /** \brief Centre, world, metres, and standard deviation of the density, metres. Free
   * parameters: between the lidar and the middle of the cell. */
  Eigen::Vector3d centre{6.5, 3.5, 1.0};
  double radius = 1.2;

  /** \brief Extinction in the centre, 1/m, at least 0. Free parameter. */
  double extinction = 0.6;

  /** \brief Backscatter over extinction, 1/sr ([F]: 0.046 / ln 20). */
  double backscatter_share = 0.0153;

  /** \brief Edge of the lumps, metres; the density in each is that of the cloud times an
   * exponential random number, new in each revolution. Free parameter. */
  double lump_edge = 0.4;

  /** \brief Half of a pulse's length, metres: echoes of one such part of a beam are one.
   * Free parameter, of pulses of 6 ns. */
  double half_pulse = 0.9;
};

/** \brief The air and what it does to a revolution that was measured without it. */
struct LidarWeather {
  Weather kind = Weather::None;
  Snowfall snow;
  DustCloud dust;

  /** \brief Divergence of the beams, radians ([H]), and their diameter at the lidar,
   * metres; free parameter. */
  double divergence = 0.003;
  double first_diameter = 0.01;

  /** \brief Standard deviation of the intensity of what is in the air, in its steps.
   * Free parameter. */
  double intensity_noise = 2.0;

  /** \brief Replaces returns by what is stronger in front of them, and removes those
   * that become too weak. Without weather nothing changes. What had no return gets one
   * only of snow or dust.
   * \param[in] surfaces that were measured
   * \param[in] pose of the lidar, lidar -> world
   * \param[in] model of the lidar
   * \param[in] random_seed of the revolution
   * \param[in,out] measurement of the surfaces by the model
   */
  void
  apply(const SurfaceImage& surfaces,
        const Eigen::Isometry3d& pose,
        const LidarErrorModel& model,
        std::uint32_t random_seed,
        LidarMeasurement& measurement) const;
};

} // namespace cell
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/lidar_weather.h"

#include "simulator/random_numbers.h"

#include <boost/random/mersenne_twister.hpp>
#include <boost/random/normal_distribution.hpp>

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace cell {

namespace {

/** \brief The strongest echo of what is in the air along one beam, and what is left of
 * the beam behind it. */
struct AirEcho {
  double signal = 0.0; ///< as LidarErrorModel's: reflectivity / range^2, 1/m^2
  double range = 0.0;  ///< metres
  double transmission = 1.0;
};

/** \brief Positive, exponential with mean 1, of 32 random bits. */
double
exponential(std::uint32_t bits)
{
  return -std::log((bits + 0.5) / 4294967296.0);
}

/** \brief Flakes in beams. */
class Flakes {
public:
  Flakes(const LidarWeather& weather, double nearest)
  : weather_(weather)
  , nearest_(nearest)
  , first_volume_(volume(nearest))
  , steepness_(2.55 * std::pow(weather.snow.rate, -0.48))
  , number_(3800.0 * std::pow(weather.snow.rate, -0.87) / steepness_)
  , growth_(std::cbrt(1.0 / weather.snow.density))
  {}

  /** \brief The flakes of a beam from the nearest range to its surface, or to the
   * farthest flake. */
  template <typename RandomT>
  AirEcho
  echo(double surface_range, RandomT& random) const
  {
    const double end = surface_range > 0.0
                           ? std::min(surface_range, weather_.snow.farthest)
                           : weather_.snow.farthest;
    AirEcho echo;
    if (end <= nearest_)
      return echo;
    const double end_volume = volume(end);
    // From flake to flake the volume that the beam covers is exponential.
    for (double at = first_volume_ + exponential(random()) / number_; at < end_volume;
         at += exponential(random()) / number_) {
      const double range = rangeOf(at);
      const double diameter = growth_ * exponential(random()) / steepness_ / 1000.0;
      const double beam = beamDiameter(range);
      const double share =
          std::min(echo.transmission, diameter * diameter / (beam * beam));
      const double signal = weather_.snow.reflectivity * share / (range * range);
      echo.transmission -= share;
      if (signal > echo.signal) {
        echo.signal = signal;
        echo.range = range;
      }
    }
    return echo;
  }

private:
  double
  beamDiameter(double range) const
  {
    return weather_.first_diameter + weather_.divergence * range;
  }

  /** \brief Volume of the cone whose tip is behind the lidar, up to a range, m^3. */
  double
  volume(double range) const
  {
    return pi / 12.0 * std::pow(beamDiameter(range), 3.0) / weather_.divergence;
  }

  double
  rangeOf(double of_volume) const
  {
    return (std::cbrt(of_volume * weather_.divergence * 12.0 / pi) -
            weather_.first_diameter) /
           weather_.divergence;
  }

  const LidarWeather& weather_;
  double nearest_;
  double first_volume_;
  double steepness_; ///< of the melted diameters, 1/mm
  double number_;    ///< flakes in a cubic metre
  double growth_;    ///< diameter of a flake over that of its water
};

/** \brief Dust in beams. */
class Dust {
public:
  Dust(const DustCloud& cloud,
       const Eigen::Isometry3d& pose,
       double nearest,
       std::uint32_t seed)
  : cloud_(cloud), pose_(pose), nearest_(nearest), seed_(seed)
  {}

  /** \brief The dust of a beam from the nearest range to its surface.
   * \param[in] ray direction in the lidar's frame
   */
  AirEcho
  echo(double surface_range, const Eigen::Vector3d& ray) const
  {
    const Eigen::Vector3d direction = pose_.linear() * ray;
    const Eigen::Vector3d to_centre = cloud_.centre - pose_.translation();
    const double along = to_centre.dot(direction);
    const double aside = to_centre.squaredNorm() - along * along;
    const double reach = 3.0 * cloud_.radius; // beyond it there is hardly any dust
    AirEcho echo;
    if (aside >= reach * reach)
      return echo;
    const double half = std::sqrt(reach * reach - aside);
    const double begin = std::max(nearest_, along - half);
    const double end =
        surface_range > 0.0 ? std::min(along + half, surface_range) : along + half;
    double depth = 0.0; // optical
    for (double part = begin; part < end; part += cloud_.half_pulse)
      addPart(part, std::min(end, part + cloud_.half_pulse), direction, depth, echo);
    echo.transmission = std::exp(-2.0 * depth);
    return echo;
  }

private:
  /** \brief One echo of all dust between two ranges. */
  void
  addPart(double begin,
          double end,
          const Eigen::Vector3d& direction,
          double& depth,
          AirEcho& echo) const
  {
    constexpr double longest_step = 0.1;
    const double steps = std::ceil((end - begin) / longest_step);
    const double step = (end - begin) / steps;
    double sum = 0.0;
    double sum_of_ranges = 0.0;
    for (double i = 0.5; i < steps; i += 1.0) {
      const double range = begin + i * step;
      const double extinction = extinctionAt(pose_.translation() + range * direction);
      depth += 0.5 * extinction * step;
      // A surface of reflectivity 1 sends back 1 / pi of the light per steradian.
      const double signal = pi * cloud_.backscatter_share * extinction * step *
                            std::exp(-2.0 * depth) / (range * range);
      depth += 0.5 * extinction * step;
      sum += signal;
      sum_of_ranges += signal * range;
    }
    if (sum > echo.signal) {
      echo.signal = sum;
      echo.range = sum_of_ranges / sum;
    }
  }

  double
  extinctionAt(const Eigen::Vector3d& place) const
  {
    const double distance = (place - cloud_.centre).squaredNorm();
    const auto lump = [&](int axis) {
      return static_cast<std::uint32_t>(
          static_cast<std::int32_t>(std::floor(place[axis] / cloud_.lump_edge)));
    };
    const std::uint32_t bits = mixSeeds(mixSeeds(seed_, lump(0)), lump(1), lump(2));
    return cloud_.extinction * exponential(bits) *
           std::exp(-0.5 * distance / (cloud_.radius * cloud_.radius));
  }

  DustCloud cloud_;
  Eigen::Isometry3d pose_;
  double nearest_;
  std::uint32_t seed_;
};

/** \brief Decides for one beam what is returned. */
class ReturnChoice {
public:
  ReturnChoice(const LidarWeather& weather,
               const LidarErrorModel& model,
               std::uint32_t seed)
  : weather_(weather), model_(model), random_(seed)
  {}

  void
  decide(const SurfaceImage& surfaces,
         std::size_t pixel,
         const AirEcho& echo,
         LidarMeasurement& measurement)
  {
    const double surface = measurement.truth[pixel] == PointTruth::None
                               ? 0.0
                               : model_.signal(surfaces, pixel);
    const double weakened = surface * echo.transmission;
    // Drawn for each beam, used or not, so that other beams do not depend on it.
    const std::uint32_t surface_chance = random_();
    const std::uint32_t echo_chance = random_();
    const float range_error = normal_(random_);
    const float intensity_error = normal_(random_);
    const bool is_seen = echo_chance < asThreshold(model_.visibleShare(echo.signal));
    if (is_seen && echo.signal > weakened) {
      setEcho(pixel, echo, range_error, intensity_error, measurement);
      return;
    }
    // Of the returns that the full signal has, those that the weakened one has, too.
    const double kept =
        surface > 0.0 ? model_.visibleShare(weakened) / model_.visibleShare(surface)
                      : 1.0;
    if (kept < 1.0 && surface_chance >= asThreshold(kept))
      remove(pixel, measurement);
  }

private:
  void
  setEcho(std::size_t pixel,
          const AirEcho& echo,
          float range_error,
          float intensity_error,
          LidarMeasurement& measurement) const
  {
    const double range = echo.range + model_.range_noise * range_error;
    // What a surface that fills the beam there would have with that signal.
    const double intensity = 100.0 * echo.signal * echo.range * echo.range +
                             weather_.intensity_noise * intensity_error;
    measurement.range[pixel] = model_.rounded(range);
    measurement.intensity[pixel] =
        static_cast<std::uint8_t>(std::min(100.0, std::max(0.0, intensity + 0.5)));
    measurement.truth[pixel] =
        weather_.kind == Weather::Snow ? PointTruth::Snow : PointTruth::Dust;
  }

  static void
  remove(std::size_t pixel, LidarMeasurement& measurement)
  {
    measurement.range[pixel] = 0.0f;
    measurement.intensity[pixel] = 0;
    measurement.truth[pixel] = PointTruth::None;
  }

  const LidarWeather& weather_;
  const LidarErrorModel& model_;
  boost::random::mt19937 random_;
  boost::random::normal_distribution<float> normal_;
};

} // namespace

void
LidarWeather::apply(const SurfaceImage& surfaces,
                    const Eigen::Isometry3d& pose,
                    const LidarErrorModel& model,
                    std::uint32_t random_seed,
                    LidarMeasurement& measurement) const
{
  if (kind == Weather::None)
    return;
  const LidarRays rays;
  const Flakes flakes(*this, model.nearest);
  const Dust dust_in_air(dust, pose, model.nearest, random_seed);
  boost::random::mt19937 random(mixSeeds(random_seed, 1));
  ReturnChoice choice(*this, model, mixSeeds(random_seed, 2));
  for (std::size_t pixel = 0; pixel < measurement.range.size(); ++pixel) {
    const double range = surfaces.depth[pixel];
    const AirEcho echo = kind == Weather::Snow
                             ? flakes.echo(range, random)
                             : dust_in_air.echo(range, rays.direction(pixel));
    choice.decide(surfaces, pixel, echo, measurement);
  }
}

} // namespace cell
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/lidar_weather.h"
#include "simulator/random_numbers.h"
#include "simulator/robot_cell.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace {

using namespace pcl_ext::cell;

LidarFrame
captureIn(const LidarWeather& weather, std::uint32_t revolution = 5)
{
  RobotCell cell(3);
  cell.setLidarWeather(weather);
  LidarFrame frame;
  cell.captureLidar(revolution, frame);
  return frame;
}

LidarWeather
snowOf(double rate)
{
  LidarWeather weather;
  weather.kind = Weather::Snow;
  weather.snow.rate = rate;
  return weather;
}

LidarWeather
dustOf(double extinction)
{
  LidarWeather weather;
  weather.kind = Weather::Dust;
  weather.dust.extinction = extinction;
  return weather;
}

std::size_t
count(const LidarFrame& frame, PointTruth truth)
{
  std::size_t number = 0;
  for (const PointTruth one : frame.truth)
    number += one == truth ? 1 : 0;
  return number;
}

bool
samePoint(const LidarFrame& a, const LidarFrame& b, std::size_t i)
{
  return a.truth[i] == b.truth[i] && a.cloud[i].intensity == b.cloud[i].intensity &&
         std::memcmp(a.cloud[i].data, b.cloud[i].data, 3 * sizeof(float)) == 0;
}

/** \brief A wall all around at one range, of plaster and met head-on. */
SurfaceImage
wallAt(float range)
{
  SurfaceImage surfaces(LidarRays::size);
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    surfaces.depth[i] = range;
    surfaces.material[i] = Material::Plaster;
  }
  return surfaces;
}

LidarMeasurement
measureWall(float range, const LidarWeather& weather)
{
  const LidarErrorModel model;
  const SurfaceImage surfaces = wallAt(range);
  LidarMeasurement measurement;
  model.measure(surfaces, 7, measurement);
  weather.apply(surfaces, Eigen::Isometry3d::Identity(), model, 8, measurement);
  return measurement;
}

TEST(LidarWeather, WithoutWeatherTheStreamIsThatOfTheErrorModelAlone)
{
  const LidarFrame frame = captureIn(LidarWeather());
  RobotCell cell(3);
  LidarMeasurement measured;
  LidarErrorModel().measure(cell.lidarSurfaces(5), mixSeeds(3, 100, 5), measured);
  EXPECT_EQ(frame.truth, measured.truth);
  const LidarRays rays;
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    ASSERT_EQ(frame.cloud[i].intensity, measured.intensity[i]);
    if (measured.truth[i] == PointTruth::None)
      continue;
    const Eigen::Vector3f point = (rays.direction(i) * measured.range[i]).cast<float>();
    ASSERT_EQ(std::memcmp(frame.cloud[i].data, point.data(), sizeof(point)), 0) << i;
  }
}

TEST(LidarWeather, EverythingElseStaysAsItWas)
{
  const LidarFrame clear = captureIn(LidarWeather());
  for (const LidarWeather& weather : {snowOf(2.0), dustOf(0.6)}) {
    const PointTruth noise =
        weather.kind == Weather::Snow ? PointTruth::Snow : PointTruth::Dust;
    const LidarFrame frame = captureIn(weather);
    for (std::size_t i = 0; i < LidarRays::size; ++i) {
      // No surface appears that was not seen in clear air, and those that are seen have
      // not moved.
      if (frame.truth[i] == PointTruth::None || frame.truth[i] == noise)
        continue;
      ASSERT_TRUE(samePoint(frame, clear, i)) << i;
    }
    EXPECT_GT(count(frame, noise), 50u);
    EXPECT_LT(count(frame, noise), LidarRays::size / 4);
  }
}

TEST(LidarWeather, IsTheSameForASeedAndNewInEachRevolution)
{
  for (const LidarWeather& weather : {snowOf(2.0), dustOf(0.6)}) {
    const LidarFrame frame = captureIn(weather);
    const LidarFrame again = captureIn(weather);
    const LidarFrame next = captureIn(weather, 6);
    for (std::size_t i = 0; i < LidarRays::size; ++i)
      ASSERT_TRUE(samePoint(frame, again, i)) << i;
    std::size_t both = 0;
    for (std::size_t i = 0; i < LidarRays::size; ++i)
      both += frame.truth[i] == next.truth[i] && frame.truth[i] == PointTruth::Snow &&
                      samePoint(frame, next, i)
                  ? 1
                  : 0;
    EXPECT_LT(both, 3u);
  }
}

TEST(LidarWeather, NoiseIsInFrontOfTheSurface)
{
  RobotCell cell(3);
  const SurfaceImage surfaces = cell.lidarSurfaces(5);
  const LidarErrorModel model;
  for (const LidarWeather& weather : {snowOf(2.0), dustOf(0.6)}) {
    const LidarFrame frame = captureIn(weather);
    for (std::size_t i = 0; i < LidarRays::size; ++i) {
      if (frame.truth[i] != PointTruth::Snow && frame.truth[i] != PointTruth::Dust)
        continue;
      const float range = frame.cloud[i].getVector3fMap().norm();
      const auto margin = static_cast<float>(6.0 * model.range_noise);
      ASSERT_GT(range, model.nearest - 0.1);
      if (surfaces.depth[i] > 0.0f) {
        ASSERT_LT(range, surfaces.depth[i] + margin) << i;
      }
    }
  }
}

TEST(LidarWeather, SnowGrowsWithTheRate)
{
  std::size_t before = 0;
  for (const double rate : {0.1, 0.5, 1.0, 2.5, 10.0}) {
    const std::size_t flakes = count(captureIn(snowOf(rate)), PointTruth::Snow);
    EXPECT_GT(flakes, before) << rate;
    before = flakes;
  }
}

TEST(LidarWeather, SnowIsSeenNearbyAndInFrontOfFarWalls)
{
  std::vector<std::size_t> of_metre(20, 0);
  std::size_t in_front_of_near_wall = 0;
  std::size_t in_front_of_far_wall = 0;
  const LidarMeasurement near = measureWall(4.0f, snowOf(2.0));
  const LidarMeasurement far = measureWall(25.0f, snowOf(2.0));
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    in_front_of_near_wall += near.truth[i] == PointTruth::Snow ? 1 : 0;
    if (far.truth[i] != PointTruth::Snow)
      continue;
    ++in_front_of_far_wall;
    ++of_metre[std::min<std::size_t>(19, static_cast<std::size_t>(far.range[i]))];
  }
  // A near wall is brighter than nearly all flakes.
  EXPECT_GT(in_front_of_far_wall, 3 * in_front_of_near_wall);
  // The beam widens and the echo weakens with the range.
  EXPECT_GT(of_metre[3], of_metre[7]);
  EXPECT_GT(of_metre[7], of_metre[12]);
  EXPECT_LT(of_metre[18], of_metre[3] / 20);
}

/** \brief Expected flakes in a beam up to a range, by the distribution's integral and
 * the beam's volume summed in slices. */
double
expectedFlakes(double rate, double end)
{
  double flakes_in_cubic_metre = 0.0;
  const double steepness = 2.55 * std::pow(rate, -0.48);
  for (double diameter = 0.0005; diameter < 30.0; diameter += 0.001)
    flakes_in_cubic_metre +=
        3800.0 * std::pow(rate, -0.87) * std::exp(-steepness * diameter) * 0.001;
  double volume = 0.0;
  for (double range = 0.9 + 0.0005; range < end; range += 0.001) {
    const double beam = 0.01 + 0.003 * range;
    volume += 3.14159265358979 / 4.0 * beam * beam * 0.001;
  }
  return flakes_in_cubic_metre * volume;
}

TEST(LidarWeather, AllFlakesOfABeamAreThoseOfTheDistribution)
{
  // Flakes that nothing hides: where every flake is seen and there is no wall, a beam is
  // empty with the probability of a Poisson distribution.
  const LidarErrorModel lidar;
  LidarErrorModel sharp = lidar;
  sharp.lost_signal = -1.0;
  sharp.safe_signal = 0.0;
  LidarWeather weather = snowOf(1.5);
  weather.snow.farthest = 3.0;
  const SurfaceImage nothing(LidarRays::size);
  LidarMeasurement measurement;
  sharp.measure(nothing, 7, measurement);
  weather.apply(nothing, Eigen::Isometry3d::Identity(), sharp, 8, measurement);
  double empty = 0.0;
  for (const PointTruth truth : measurement.truth)
    empty += truth == PointTruth::Snow ? 0.0 : 1.0 / LidarRays::size;
  const double expected = std::exp(-expectedFlakes(1.5, 3.0));
  // Four standard deviations of the share.
  EXPECT_NEAR(
      empty, expected, 4.0 * std::sqrt(expected * (1.0 - expected) / LidarRays::size));
}

TEST(LidarWeather, DustIsInItsCloudAndHidesWhatIsBehindIt)
{
  LidarWeather weather = dustOf(1.0);
  weather.dust.centre = {8.0, 0.0, 0.0};
  weather.dust.radius = 1.0;
  const LidarMeasurement clear = measureWall(15.0f, LidarWeather());
  const LidarMeasurement measurement = measureWall(15.0f, weather);
  const LidarRays rays;
  std::size_t dust = 0;
  std::size_t hidden = 0;
  std::size_t lost = 0;
  for (std::size_t i = 0; i < LidarRays::size; ++i) {
    const Eigen::Vector3d ray = rays.direction(i);
    const double aside = std::acos(std::min(1.0, ray.x())) * 8.0;
    if (measurement.truth[i] == PointTruth::Dust) {
      ++dust;
      ASSERT_LT((ray * measurement.range[i] - weather.dust.centre).norm(), 3.1);
    }
    if (aside > 3.3) {
      ASSERT_EQ(measurement.range[i], clear.range[i]) << i;
    }
    if (aside < 0.5) {
      hidden += measurement.truth[i] == PointTruth::Surface ? 0 : 1;
      lost +=
          measurement.truth[i] == PointTruth::None && clear.truth[i] != PointTruth::None
              ? 1
              : 0;
    }
  }
  EXPECT_GT(dust, 100u);
  EXPECT_GT(hidden, 20u);
  EXPECT_GT(lost, 0u);
  EXPECT_LT(lost, hidden);
  const LidarMeasurement thin = measureWall(15.0f, dustOf(0.0));
  EXPECT_EQ(thin.range, clear.range);
}

} // namespace

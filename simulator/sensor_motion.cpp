// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/sensor_motion.h"

#include "simulator/scene.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace cell {

Eigen::Isometry3d
handCamera(double time)
{
  Eigen::Isometry3d pose = handPose(time) * Eigen::Translation3d(0.0, -0.4, 0.0);
  pose.rotate(Eigen::AngleAxisd(pi / 4.0, Eigen::Vector3d::UnitX()));
  return pose;
}

Eigen::Isometry3d
mobileLidar(double time)
{
  constexpr double speed = 1.0;    // m/s
  constexpr double straight = 5.6; // metres
  constexpr double radius = 0.6;   // metres
  constexpr double half_lap = straight + pi * radius;
  // Shortly before a turn, so that short streams have one.
  constexpr double start = 4.0; // metres

  const double distance = start + speed * time;
  const double half_laps = std::floor(distance / half_lap);
  const double along = distance - half_lap * half_laps;
  const double turned = std::max(0.0, along - straight) / radius;
  // One half of the way; the other one is the same, turned by 180 degrees.
  const Eigen::Vector3d place(std::min(along, straight) - straight / 2.0 +
                                  radius * std::sin(turned),
                              -radius * std::cos(turned),
                              0.0);
  const bool is_way_back = std::fmod(half_laps, 2.0) != 0.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(5.0, 1.3, 1.0) + (is_way_back ? -place : place));
  pose.rotate(
      Eigen::AngleAxisd(turned + (is_way_back ? pi : 0.0), Eigen::Vector3d::UnitZ()));
  return pose;
}

} // namespace cell
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sensor_rows.h"

#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

bool
SensorRows::find(const WorldPose& to_sensor, bool may_refit, SensorCloud& cloud)
{
  if (untried_clouds_ > 0 && !may_refit) {
    --untried_clouds_;
    return false;
  }
  if (camera_.find(cloud.positions, to_sensor, may_refit, cloud.pixels)) {
    cloud.image = camera_.size();
    next_untried_ = 0;
    return true;
  }
  if (findRings(to_sensor, may_refit, cloud)) {
    next_untried_ = 0;
    return true;
  }
  // Most such clouds have none, and looking for them takes time.
  constexpr unsigned int most_untried = 15;
  untried_clouds_ =
      std::exchange(next_untried_, std::min(2 * next_untried_ + 1, most_untried));
  return false;
}

bool
SensorRows::findRings(const WorldPose& to_sensor, bool may_refit, SensorCloud& cloud)
{
  const auto in_sensor = [&to_sensor](const std::array<double, 3>& position) {
    return to_sensor * Eigen::Vector3d(position[0], position[1], position[2]);
  };
  if (may_refit || elevations_.count() == 0) {
    constexpr std::size_t enough = 16384;
    constexpr std::size_t least_points = 1024;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t point = 0; point < cloud.size(); ++point)
      if (isChosen(point, cloud.size(), enough))
        points.emplace_back(in_sensor(cloud.positions[point]));
    if (!elevations_.learn(points, least_points))
      return false;
  }
  cloud.rings.resize(cloud.size());
  for (std::size_t point = 0; point < cloud.size(); ++point) {
    const Eigen::Vector3d at = in_sensor(cloud.positions[point]);
    cloud.rings[point] =
        elevations_.nextRow(at.z() / std::max(at.head<2>().norm(), 1e-9));
  }
  return true;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

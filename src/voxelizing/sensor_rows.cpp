// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/sensor_rows.h"

#include "voxelizing/robust_fit.h"
#include "voxelizing/scan_columns.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::uint32_t no_row = ~std::uint32_t{0};

} // namespace

bool
SensorRows::find(const WorldPose& to_sensor, bool may_refit, SensorCloud& cloud)
{
  if (ScanColumns::areRows(cloud.rings))
    return number(may_refit, cloud.rings);
  if (untried_clouds_ > 0 && !may_refit) {
    --untried_clouds_;
    return false;
  }
  if (camera_.find(cloud.positions, to_sensor, may_refit, cloud.pixels)) {
    cloud.image = camera_.size();
    cloud.columns = cloud.image.width;
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

/** \brief Replaces rings by rows: where many rings are without points, as each fourth one
 * was kept, only those that have some are rows. Else points would have no neighbours in
 * the rows beside theirs.
 * \param[in] may_learn the rows may be others than those of the clouds before
 * \return false if one has no row, and they may not be learnt
 */
bool
SensorRows::number(bool may_learn, std::vector<std::uint32_t>& rings)
{
  std::vector<std::uint32_t>& rows = rows_of_rings_;
  if (may_learn) {
    rows.assign(*std::max_element(rings.begin(), rings.end()) + std::size_t{1}, no_row);
    for (const std::uint32_t ring : rings)
      rows[ring] = 0;
    std::uint32_t count = 0;
    for (std::uint32_t& row : rows)
      if (row != no_row)
        row = count++;
    if (4 * std::size_t{count} > 3 * rows.size())
      rows.clear();
  }
  if (rows.empty())
    return true;
  for (std::uint32_t& ring : rings) {
    ring = ring < rows.size() ? rows[ring] : no_row;
    if (ring == no_row)
      return false;
  }
  return true;
}

bool
SensorRows::findRings(const WorldPose& to_sensor, bool may_refit, SensorCloud& cloud)
{
  if (may_refit || elevations_.count() == 0) {
    constexpr std::size_t enough = 16384;
    constexpr std::size_t least_points = 1024;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t point = 0; point < cloud.size(); ++point)
      if (isChosen(point, cloud.size(), enough))
        points.emplace_back(to_sensor * vectorOf(cloud.positions[point]));
    if (!elevations_.learn(points, least_points))
      return false;
  }
  cloud.rings.resize(cloud.size());
  for (std::size_t point = 0; point < cloud.size(); ++point) {
    const Eigen::Vector3d at = to_sensor * vectorOf(cloud.positions[point]);
    cloud.rings[point] =
        elevations_.nextRow(at.z() / std::max(at.head<2>().norm(), 1e-9));
  }
  return true;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

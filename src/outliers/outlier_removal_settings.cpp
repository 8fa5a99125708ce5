// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

DensityUnit
densityUnitOf(IntensityLaw law)
{
  switch (law) {
  case IntensityLaw::Count:
    return DensityUnit::Points;
  case IntensityLaw::Quadratic:
    return DensityUnit::Faces;
  case IntensityLaw::Native:
  case IntensityLaw::None:
    return DensityUnit::Voxels;
  default:
    return DensityUnit::Automatic;
  }
}

OutlierRemovalStatus
checkSettings(const VoxelOutlierRemovalSettings& settings)
{
  const auto invalid = [](const std::string& message) {
    return OutlierRemovalStatus(OutlierRemovalCode::InvalidSettings, message);
  };
  if (!std::isfinite(settings.min_log_odds))
    return invalid("min_log_odds is " + std::to_string(settings.min_log_odds) +
                   "; it must be a finite number");
  if (std::none_of(density_units.begin(), density_units.end(), [&](const auto& known) {
        return known.value == settings.unit;
      }))
    return invalid("unit is " + std::to_string(static_cast<int>(settings.unit)) +
                   "; it must be Automatic, Faces, Points, Voxels or Rays");
  if (!std::isfinite(settings.full_intensity) || !(settings.full_intensity > 0.0f))
    return invalid("full_intensity is " + std::to_string(settings.full_intensity) +
                   "; it must be a finite number above 0");
  if (settings.sensor_position)
    for (const double coordinate : *settings.sensor_position)
      if (!std::isfinite(coordinate))
        return invalid("sensor_position has " + std::to_string(coordinate) +
                       "; it must be finite numbers");
  for (const auto& [name, step] :
       {std::pair("azimuth_step", settings.azimuth_step),
        std::pair("elevation_step", settings.elevation_step)})
    if (!(step >= VoxelOutlierRemovalSettings::min_ray_step &&
          step <= VoxelOutlierRemovalSettings::max_ray_step))
      return invalid(std::string(name) + " is " + std::to_string(step) +
                     "; it must be 0.0001 to 1 radians");
  return {};
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

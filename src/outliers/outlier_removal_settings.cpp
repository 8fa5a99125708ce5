// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/exact_text.h"
#include "outliers/outlier_setting_table.h"
#include "outliers/unit_choice.h"

#include <array>
#include <string>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

/** \brief Checks each setting for itself. */
template <typename SettingsT>
OutlierRemovalStatus
checkEach(const SettingsT& settings)
{
  OutlierRemovalStatus status;
  const auto check = [&](const OutlierSetting& setting, auto value, const char* is) {
    const bool is_allowed = value >= setting.lowest && value <= setting.highest;
    if (status.ok() && !is_allowed)
      status = {OutlierRemovalCode::InvalidSettings,
                std::string(setting.name) + is + exactText(value) + "; it must be " +
                    setting.demand};
  };
  visitSettings(settings, [&](const OutlierSetting& setting, const auto& value) {
    using ValueT = std::decay_t<decltype(value)>;
    if constexpr (std::is_floating_point_v<ValueT>)
      check(setting, value, " is ");
    else if constexpr (!std::is_integral_v<ValueT>)
      for (const double number : value.value_or(std::array<double, 3>()))
        check(setting, number, " has ");
  });
  return status;
}

} // namespace

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

DensityUnitSettings
densityUnitSettings(DensityUnit unit, const AutomaticUnit& automatic)
{
  switch (unit) {
  case DensityUnit::Faces:
    return FacesUnit{{automatic}};
  case DensityUnit::Points:
    return PointsUnit{{automatic}};
  case DensityUnit::Voxels:
    return VoxelsUnit{{automatic}};
  case DensityUnit::Rays: {
    RaysUnit rays;
    rays.intensities_are_counts = automatic.intensities_are_counts;
    return rays;
  }
  default:
    return automatic;
  }
}

DensityUnitSettings
automaticUnitOf(const io::VoxelFrame& first,
                const std::optional<IntensityLaw>& law,
                bool is_of_lidar,
                const AutomaticUnit& automatic)
{
  // The points of a lidar tell more than its law.
  if (!law || first.points.sensor) {
    AutomaticUnit unit = automatic;
    unit.intensities_are_counts |= law == IntensityLaw::Count;
    return unit;
  }
  // Few points in a voxel of a lidar are no sign of noise.
  return densityUnitSettings(is_of_lidar && law == IntensityLaw::Count
                                 ? DensityUnit::Voxels
                                 : densityUnitOf(*law),
                             automatic);
}

std::string
unitFault(DensityUnit unit, IntensityLaw law)
{
  const bool is_faces = unit == DensityUnit::Faces;
  if (!is_faces && unit != DensityUnit::Points)
    return {};
  if (law == IntensityLaw::Native)
    return "native, whose intensities are no densities; choose automatic, voxels or "
           "rays";
  if (law == IntensityLaw::None)
    return "none, which has no intensities; choose automatic, voxels or rays";
  if (is_faces && law == IntensityLaw::Count)
    return "count, whose intensities are numbers of points; choose automatic or points";
  return {};
}

OutlierRemovalStatus
checkSettings(const VoxelOutlierRemovalSettings& settings)
{
  return checkEach(settings);
}

OutlierRemovalStatus
checkSettings(const PointOutlierRemovalSettings& settings)
{
  return checkEach(settings);
}

} // namespace pcl_ext::PCL_EXT_ABI

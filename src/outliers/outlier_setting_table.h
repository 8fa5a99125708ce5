// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/filters/point_outlier_removal.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <limits>
#include <type_traits>
#include <variant>

// The settings of outlier removal as rows of a table, from which their checks and the
// keywords of Python are made.

namespace pcl_ext::PCL_EXT_ABI {

/** \brief A setting: its name and, of numbers, what they may be. */
struct OutlierSetting {
  const char* name; ///< of the field
  const char* demand = "finite numbers";
  double lowest = std::numeric_limits<double>::lowest();
  double highest = std::numeric_limits<double>::max();
};

/** \brief Calls a function with each setting of a unit, and its value. */
template <typename UnitT, typename VisitT>
void
visitUnit(UnitT& unit, const VisitT& visit)
{
  constexpr bool is_rays = std::is_same_v<std::remove_const_t<UnitT>, RaysUnit>;
  if constexpr (!is_rays)
    visit(OutlierSetting{"use_history"}, unit.use_history);
  if constexpr (std::is_same_v<std::remove_const_t<UnitT>, FacesUnit>)
    visit(OutlierSetting{"full_intensity",
                         "a finite number above 0",
                         std::numeric_limits<double>::denorm_min()},
          unit.full_intensity);
  if constexpr (is_rays) {
    const auto step = [](const char* name) {
      return OutlierSetting{name, "0.0001 to 1 radians", 0.0001, 1.0};
    };
    visit(OutlierSetting{"sensor_position"}, unit.sensor_position);
    visit(step("azimuth_step"), unit.azimuth_step);
    visit(step("elevation_step"), unit.elevation_step);
  }
  if constexpr (is_rays || std::is_same_v<std::remove_const_t<UnitT>, AutomaticUnit>)
    visit(OutlierSetting{"intensities_are_counts"}, unit.intensities_are_counts);
}

/** \brief Calls a function with each setting but the unit, and its value.
 * \param[in,out] settings of a VoxelOutlierRemoval or a PointOutlierRemoval
 * \param[in] visit called with an OutlierSetting and the field
 */
template <typename SettingsT, typename VisitT>
void
visitSettings(SettingsT& settings, const VisitT& visit)
{
  visit(OutlierSetting{"min_log_odds", "a finite number"}, settings.min_log_odds);
  if constexpr (std::is_same_v<std::remove_const_t<SettingsT>,
                               PointOutlierRemovalSettings>)
    visit(OutlierSetting{"use_history"}, settings.use_history);
  else {
    visit(OutlierSetting{"max_blocks"}, settings.max_blocks);
    std::visit([&](auto& unit) { visitUnit(unit, visit); }, settings.unit);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI

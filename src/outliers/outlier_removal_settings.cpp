#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <cmath>
#include <string>

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
  if (settings.unit != DensityUnit::Automatic && settings.unit != DensityUnit::Faces &&
      settings.unit != DensityUnit::Points && settings.unit != DensityUnit::Voxels)
    return invalid("unit is " + std::to_string(static_cast<int>(settings.unit)) +
                   "; it must be Automatic, Faces, Points or Voxels");
  if (!std::isfinite(settings.full_intensity) || !(settings.full_intensity > 0.0f))
    return invalid("full_intensity is " + std::to_string(settings.full_intensity) +
                   "; it must be a finite number above 0");
  return {};
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext

#include "stream_noise.h"

namespace pcl_ext_ros {

StreamNoise::StreamNoise(const std::string& topic,
                         const StreamParameters& from_streams,
                         const NoiseParameters& for_all)
: min_intensity_(
      "min_intensity", topic, from_streams.min_intensity, for_all.min_intensity)
, remove_outliers_(
      "remove_outliers", topic, from_streams.remove_outliers, for_all.remove_outliers)
, min_log_odds_("min_log_odds", topic, from_streams.min_log_odds, for_all.min_log_odds)
{}

bool
StreamNoise::updateOutlierRemoval()
{
  // Both are read in any case.
  const bool is_switched = remove_outliers_.update();
  const bool is_moved = min_log_odds_.update();
  return is_switched || (is_moved && remove_outliers_.current());
}

std::optional<pcl_ext::VoxelOutlierRemovalSettings>
StreamNoise::outlierRemoval() const
{
  if (!remove_outliers_.current())
    return std::nullopt;
  pcl_ext::VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = min_log_odds_.current();
  return settings;
}

} // namespace pcl_ext_ros

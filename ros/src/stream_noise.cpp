#include "stream_noise.h"

#include "parameter_reader.h"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include <type_traits>

namespace pcl_ext_ros {

template <typename ValueT>
StreamSetting<ValueT>::StreamSetting(const std::string& name,
                                     const std::string& topic,
                                     std::optional<ValueT> from_streams,
                                     ValueT for_all)
: own_name_(ros::this_node::getName() + "/" + name + "_of" + topic)
, name_for_all_(ros::this_node::getName() + "/" + name)
, from_streams_(from_streams)
{
  ParameterReader reader;
  const ValueT default_value = from_streams.value_or(for_all);
  if constexpr (std::is_same_v<ValueT, bool>)
    current_ = reader.flag(name + "_of" + topic, default_value);
  else
    current_ = reader.finite(name + "_of" + topic, default_value);
}

template <typename ValueT>
bool
StreamSetting<ValueT>::update()
{
  std::optional<ValueT> value = read(own_name_);
  if (!value)
    value = from_streams_;
  if (!value)
    value = read(name_for_all_);
  if (!value || *value == current_)
    return false;
  current_ = *value;
  return true;
}

template <typename ValueT>
std::optional<ValueT>
StreamSetting<ValueT>::read(const std::string& name)
{
  XmlRpc::XmlRpcValue value;
  if (!ros::param::getCached(name, value))
    return std::nullopt;
  // A deleted parameter is an empty struct in roscpp's cache.
  if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct && value.size() == 0)
    return std::nullopt;
  std::optional<ValueT> converted;
  if constexpr (std::is_same_v<ValueT, bool>)
    converted = toFlag(value);
  else
    converted = toFloat(value);
  if (converted)
    return converted;
  const std::string allowed =
      std::is_same_v<ValueT, bool> ? "true or false" : "a finite number";
  const std::string warning = "Parameter " + name + " is " + toText(value) +
                              "; it must be " + allowed + ". It is ignored";
  if (warning != last_warning_)
    ROS_WARN("%s", warning.c_str());
  last_warning_ = warning;
  return current_;
}

template class StreamSetting<float>;
template class StreamSetting<bool>;

StreamNoise::StreamNoise(const std::string& topic,
                         const StreamParameters& from_streams,
                         const NoiseParameters& for_all)
: min_intensity(
      "min_intensity", topic, from_streams.min_intensity, for_all.min_intensity)
, remove_outliers(
      "remove_outliers", topic, from_streams.remove_outliers, for_all.remove_outliers)
, min_log_odds("min_log_odds", topic, from_streams.min_log_odds, for_all.min_log_odds)
, density_unit(from_streams.density_unit.value_or(for_all.density_unit))
{}

std::optional<pcl_ext::VoxelOutlierRemovalSettings>
StreamNoise::outlierRemoval() const
{
  if (!remove_outliers.current())
    return std::nullopt;
  pcl_ext::VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = min_log_odds.current();
  settings.unit = density_unit;
  return settings;
}

bool
StreamNoise::updateOutlierRemoval()
{
  // Both are read in any case.
  const bool is_switched = remove_outliers.update();
  const bool is_moved = min_log_odds.update();
  return is_switched || (is_moved && remove_outliers.current());
}

} // namespace pcl_ext_ros

#include "stream_noise.h"

#include "parameter_reader.h"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

namespace pcl_ext_ros {

using pcl_ext::nodes::noiseParameters;
using pcl_ext::nodes::ParameterValue;
using pcl_ext::nodes::ParameterValues;

namespace {

/** \brief A value from several sources, of which the first that has it counts. */
ParameterValue
firstOf(const std::string& name,
        const ParameterValues& from_streams,
        const ParameterValues& for_all)
{
  for (const ParameterValues* const values : {&from_streams, &for_all})
    if (const auto value = values->find(name); value != values->end())
      return value->second;
  return descriptionOf(noiseParameters(), name).default_value;
}

} // namespace

template <typename ValueT>
StreamSetting<ValueT>::StreamSetting(const std::string& name,
                                     const std::string& topic,
                                     const ParameterValues& from_streams,
                                     const ParameterValues& for_all)
: parameter_(descriptionOf(noiseParameters(), name))
, own_name_(ros::this_node::getName() + "/" + name + "_of" + topic)
, name_for_all_(ros::this_node::getName() + "/" + name)
{
  if (const auto value = from_streams.find(name); value != from_streams.end())
    from_streams_ = std::get<ValueT>(value->second);
  const auto own = ParameterReader().value(name + "_of" + topic, parameter_);
  current_ = std::get<ValueT>(own ? *own : firstOf(name, from_streams, for_all));
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
  if (const auto converted = convertedValue(parameter_, value))
    return std::get<ValueT>(*converted);
  const std::string warning = "Parameter " + name + " is " + toText(value) +
                              "; it must be " + allowedValues(parameter_) +
                              ". It is ignored";
  if (warning != last_warning_)
    ROS_WARN("%s", warning.c_str());
  last_warning_ = warning;
  return current_;
}

template class StreamSetting<double>;
template class StreamSetting<bool>;

StreamNoise::StreamNoise(const std::string& topic,
                         const ParameterValues& from_streams,
                         const ParameterValues& for_all)
: min_intensity_("min_intensity", topic, from_streams, for_all)
, remove_outliers_("remove_outliers", topic, from_streams, for_all)
, min_log_odds_("min_log_odds", topic, from_streams, for_all)
, constant_values_{{"density_unit", firstOf("density_unit", from_streams, for_all)}}
{}

float
StreamNoise::minIntensity() const
{
  return settings().min_intensity;
}

std::optional<pcl_ext::VoxelOutlierRemovalSettings>
StreamNoise::outlierRemoval() const
{
  return settings().outlier_removal;
}

bool
StreamNoise::updateOutlierRemoval()
{
  // Both are read in any case.
  const bool is_switched = remove_outliers_.update();
  const bool is_moved = min_log_odds_.update();
  return is_switched || (is_moved && remove_outliers_.current());
}

bool
StreamNoise::updateMinIntensity()
{
  return min_intensity_.update();
}

pcl_ext::nodes::NoiseSettings
StreamNoise::settings() const
{
  ParameterValues values = constant_values_;
  values["min_intensity"] = min_intensity_.current();
  values["remove_outliers"] = remove_outliers_.current();
  values["min_log_odds"] = min_log_odds_.current();
  return pcl_ext::nodes::readNoiseParameters(values);
}

} // namespace pcl_ext_ros

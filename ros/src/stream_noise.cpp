#include "stream_noise.h"

#include "parameter_reader.h"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include <utility>

namespace pcl_ext_ros1 {

using pcl_ext::nodes::noiseParameters;
using pcl_ext::nodes::ParameterDescription;
using pcl_ext::nodes::ParameterValues;

namespace {

bool
isConstant(const ParameterDescription& parameter)
{
  return parameter.name == "density_unit";
}

std::string
ownName(const ParameterDescription& parameter, const std::string& topic)
{
  return parameter.name + "_of" + topic;
}

} // namespace

StreamNoise::StreamNoise(std::string topic,
                         const ParameterValues& from_streams,
                         const ParameterValues& for_all)
: topic_(std::move(topic)), from_streams_(from_streams), values_(from_streams)
{
  values_.insert(for_all.begin(), for_all.end());
  ParameterReader reader;
  for (const ParameterDescription& parameter : noiseParameters())
    if (!isConstant(parameter))
      if (const auto own = reader.value(ownName(parameter, topic_), parameter))
        values_[parameter.name] = *own;
}

ParameterValues
StreamNoise::values() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return values_;
}

void
StreamNoise::update()
{
  for (const ParameterDescription& parameter : noiseParameters()) {
    if (isConstant(parameter) || take(ownName(parameter, topic_), parameter))
      continue;
    const auto from_streams = from_streams_.find(parameter.name);
    if (from_streams == from_streams_.end()) {
      take(parameter.name, parameter);
      continue;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    values_[parameter.name] = from_streams->second;
  }
}

bool
StreamNoise::take(const std::string& name, const ParameterDescription& description)
{
  const std::string full_name = ros::this_node::getName() + "/" + name;
  XmlRpc::XmlRpcValue value;
  if (!ros::param::getCached(full_name, value))
    return false;
  // A deleted parameter is an empty struct in roscpp's cache.
  if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct && value.size() == 0)
    return false;
  if (const auto converted = convertedValue(description, value)) {
    const std::lock_guard<std::mutex> lock(mutex_);
    values_[description.name] = *converted;
    return true;
  }
  const std::string warning = "Parameter " + full_name + " is " + toText(value) +
                              "; it must be " + allowedValues(description) +
                              ". It is ignored";
  if (warnings_.insert(warning).second)
    ROS_WARN("%s", warning.c_str());
  return true;
}

} // namespace pcl_ext_ros1

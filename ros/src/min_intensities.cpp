#include "min_intensities.h"

#include "decompressor_parameters.h"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include <cmath>

namespace pcl_ext_ros {

MinIntensity::MinIntensity(const std::string& topic,
                           std::optional<float> from_streams,
                           float current)
: name_of_own_(ros::this_node::getName() + "/min_intensity_of" + topic)
, name_for_all_(ros::this_node::getName() + "/min_intensity")
, from_streams_(from_streams)
, current_(current)
{}

bool
MinIntensity::update()
{
  std::optional<float> wanted = read(name_of_own_);
  if (!wanted)
    wanted = from_streams_;
  if (!wanted)
    wanted = read(name_for_all_);
  if (!wanted || *wanted == current_)
    return false;
  current_ = *wanted;
  return true;
}

std::optional<float>
MinIntensity::read(const std::string& name)
{
  XmlRpc::XmlRpcValue value;
  if (!ros::param::getCached(name, value))
    return std::nullopt;
  // That is how the master tells of a parameter that is not set any more.
  if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct && value.size() == 0)
    return std::nullopt;
  const std::optional<double> number = toNumber(value);
  if (number && std::abs(*number) <= highest_min_intensity)
    return static_cast<float>(*number);
  const std::string warning = "Parameter " + name + " is " + toText(value) +
                              "; it must be a finite number. It is ignored";
  if (warning != last_warning_)
    ROS_WARN("%s", warning.c_str());
  last_warning_ = warning;
  return current_;
}

} // namespace pcl_ext_ros

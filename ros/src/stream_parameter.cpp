#include "stream_parameter.h"

#include "parameter_reader.h"

#include <ros/console.h>
#include <ros/param.h>
#include <ros/this_node.h>

#include <type_traits>

namespace pcl_ext_ros {

namespace {

template <typename ValueT>
ValueT
readAtStart(const std::string& name, ValueT default_value)
{
  ParameterReader reader;
  if constexpr (std::is_same_v<ValueT, bool>)
    return reader.flag(name, default_value);
  else
    return reader.finite(name, default_value);
}

template <typename ValueT>
std::optional<ValueT>
toValue(const XmlRpc::XmlRpcValue& value)
{
  if constexpr (std::is_same_v<ValueT, bool>)
    return toFlag(value);
  else
    return toFloat(value);
}

} // namespace

template <typename ValueT>
StreamParameter<ValueT>::StreamParameter(const std::string& name,
                                         const std::string& topic,
                                         std::optional<ValueT> from_streams,
                                         ValueT for_all)
: name_of_own_(ros::this_node::getName() + "/" + name + "_of" + topic)
, name_for_all_(ros::this_node::getName() + "/" + name)
, from_streams_(from_streams)
, current_(readAtStart(name + "_of" + topic, from_streams.value_or(for_all)))
{}

template <typename ValueT>
bool
StreamParameter<ValueT>::update()
{
  std::optional<ValueT> wanted = read(name_of_own_);
  if (!wanted)
    wanted = from_streams_;
  if (!wanted)
    wanted = read(name_for_all_);
  if (!wanted || *wanted == current_)
    return false;
  current_ = *wanted;
  return true;
}

template <typename ValueT>
std::optional<ValueT>
StreamParameter<ValueT>::read(const std::string& name)
{
  XmlRpc::XmlRpcValue value;
  if (!ros::param::getCached(name, value))
    return std::nullopt;
  // That is how the master tells of a parameter that is not set any more.
  if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct && value.size() == 0)
    return std::nullopt;
  if (const std::optional<ValueT> right = toValue<ValueT>(value))
    return right;
  const std::string allowed =
      std::is_same_v<ValueT, bool> ? "true or false" : "a finite number";
  const std::string warning = "Parameter " + name + " is " + toText(value) +
                              "; it must be " + allowed + ". It is ignored";
  if (warning != last_warning_)
    ROS_WARN("%s", warning.c_str());
  last_warning_ = warning;
  return current_;
}

template class StreamParameter<float>;
template class StreamParameter<bool>;

} // namespace pcl_ext_ros

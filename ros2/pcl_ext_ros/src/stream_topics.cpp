// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream_topics.h"

#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

namespace pcl_ext_ros {

namespace {

const char* const name = "streams";

/** \brief The topics of a value of any type.
 * \param[in] topics_of_node resolves names
 * \throws std::invalid_argument that says what is wrong
 */
StreamTopics::Topics
resolved(rclcpp::node_interfaces::NodeTopicsInterface& topics_of_node,
         const rclcpp::ParameterValue& value)
{
  const auto refuse = [&](const std::string& reason) {
    throw std::invalid_argument("streams is " + rclcpp::to_string(value) + "; " +
                                reason);
  };
  std::vector<std::string> names;
  if (value.get_type() == rclcpp::ParameterType::PARAMETER_STRING_ARRAY)
    names = value.get<std::vector<std::string>>();
  if (names.empty())
    refuse("it must be a list of topics");
  StreamTopics::Topics topics;
  for (const std::string& given : names) {
    std::string topic;
    try {
      topic = topics_of_node.resolve_topic_name(given);
    }
    catch (const std::exception& failure) {
      refuse("'" + given + "' is no topic: " + failure.what());
    }
    if (topic == topics_of_node.resolve_topic_name("~/merged/pcl_ext"))
      refuse(topic + " is what this node itself merges");
    if (!topics.emplace(topic, given).second)
      refuse(topic + " is twice in it");
  }
  return topics;
}

} // namespace

StreamTopics::StreamTopics(rclcpp::Node& node, std::function<void(Topics)> on_change)
{
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = "Topics of the streams.";
  // Of any type, as rclcpp ends the program where a value has another type.
  descriptor.dynamic_typing = true;
  const std::vector<std::string> by_default{"input"};
  const auto value =
      node.declare_parameter(name, rclcpp::ParameterValue(by_default), descriptor);
  const auto topics_of_node = node.get_node_topics_interface();
  try {
    initial_ = resolved(*topics_of_node, value);
  }
  catch (const std::invalid_argument& fault) {
    fault_ = fault.what();
  }
  on_set_ = node.add_on_set_parameters_callback(
      [topics_of_node](const std::vector<rclcpp::Parameter>& parameters) {
        rcl_interfaces::msg::SetParametersResult result;
        result.successful = true;
        for (const rclcpp::Parameter& parameter : parameters)
          if (parameter.get_name() == name)
            try {
              resolved(*topics_of_node, parameter.get_parameter_value());
            }
            catch (const std::invalid_argument& fault) {
              result.successful = false;
              result.reason = fault.what();
            }
        return result;
      });
  post_set_ = node.add_post_set_parameters_callback(
      [topics_of_node, change = std::move(on_change)](
          const std::vector<rclcpp::Parameter>& parameters) {
        for (const rclcpp::Parameter& parameter : parameters)
          if (parameter.get_name() == name)
            change(resolved(*topics_of_node, parameter.get_parameter_value()));
      });
}

} // namespace pcl_ext_ros

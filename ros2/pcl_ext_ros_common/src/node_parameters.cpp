// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_ros_common/node_parameters.hpp"

#include <rclcpp/logging.hpp>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

namespace pcl_ext_ros_common {

namespace {

using pcl_ext::nodes::ParameterDescription;
using pcl_ext::nodes::ParameterValue;
using pcl_ext::nodes::ParameterValues;
using Parameters = rclcpp::node_interfaces::NodeParametersInterface;

/** \brief Nothing for a type that no parameter of a table has. */
std::optional<ParameterValue>
toValue(const rclcpp::Parameter& parameter)
{
  const ParameterValue no_numbers = std::vector<double>();
  switch (parameter.get_type()) {
  case rclcpp::ParameterType::PARAMETER_BOOL:
    return parameter.as_bool();
  case rclcpp::ParameterType::PARAMETER_INTEGER:
    return parameter.as_int();
  case rclcpp::ParameterType::PARAMETER_DOUBLE:
    return parameter.as_double();
  case rclcpp::ParameterType::PARAMETER_STRING:
    return parameter.as_string();
  case rclcpp::ParameterType::PARAMETER_DOUBLE_ARRAY:
    return parameter.as_double_array();
  case rclcpp::ParameterType::PARAMETER_INTEGER_ARRAY: {
    const std::vector<std::int64_t> whole = parameter.as_integer_array();
    return std::vector<double>(whole.begin(), whole.end());
  }
  // An empty list has any type.
  case rclcpp::ParameterType::PARAMETER_BYTE_ARRAY:
    return parameter.as_byte_array().empty() ? std::make_optional(no_numbers)
                                             : std::nullopt;
  case rclcpp::ParameterType::PARAMETER_BOOL_ARRAY:
    return parameter.as_bool_array().empty() ? std::make_optional(no_numbers)
                                             : std::nullopt;
  case rclcpp::ParameterType::PARAMETER_STRING_ARRAY:
    return parameter.as_string_array().empty() ? std::make_optional(no_numbers)
                                               : std::nullopt;
  default:
    return std::nullopt;
  }
}

rclcpp::ParameterValue
toRos(const ParameterValue& value)
{
  return std::visit([](const auto& content) { return rclcpp::ParameterValue(content); },
                    value);
}

/** \brief Types are dynamic, as a whole number is allowed for a number. */
rcl_interfaces::msg::ParameterDescriptor
descriptorOf(const ParameterDescription& parameter, NodeParameters::Kind kind)
{
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description =
      parameter.description +
      (parameter.unit.empty() ? "" : " Unit: " + parameter.unit + ".");
  descriptor.additional_constraints = allowedValues(parameter);
  descriptor.dynamic_typing = true;
  descriptor.read_only = kind == NodeParameters::Kind::ReadOnly;
  // rclcpp would refuse what is allowed outside of the range, as it means "not set".
  if (!isInterval(parameter))
    return descriptor;
  if (std::holds_alternative<std::int64_t>(parameter.default_value)) {
    rcl_interfaces::msg::IntegerRange range;
    range.from_value = std::llround(parameter.lowest);
    range.to_value = std::llround(parameter.highest);
    descriptor.integer_range.push_back(range);
  }
  if (std::holds_alternative<double>(parameter.default_value)) {
    rcl_interfaces::msg::FloatingPointRange range;
    range.from_value = parameter.lowest;
    range.to_value = parameter.highest;
    descriptor.floating_point_range.push_back(range);
  }
  return descriptor;
}

/** \brief Why the value that a node was started with is refused: rclcpp's own check of
 * ranges tells neither the value nor the range. */
std::string
reasonOf(const std::exception& refusal,
         const Parameters& parameters,
         const std::string& name,
         const ParameterDescription& parameter)
{
  const auto& given = parameters.get_parameter_overrides();
  const auto found = given.find(name);
  const auto value = found == given.end()
                         ? std::nullopt
                         : toValue(rclcpp::Parameter(name, found->second));
  if (!value || convertedValue(parameter, *value))
    return refusal.what();
  return name.substr(0, name.size() - parameter.name.size()) +
         refusalOf(parameter, *value);
}

/** \brief Declares a parameter, or else describes one that the node has declared from
 * its overrides. One that the user has described is left as it is, and so is that of
 * another instance. */
void
declare(Parameters& parameters,
        const rclcpp::Logger& logger,
        const std::string& name,
        const rclcpp::ParameterValue& default_value,
        const ParameterDescription& parameter,
        NodeParameters::Kind kind)
{
  const auto descriptor = descriptorOf(parameter, kind);
  rclcpp::ParameterValue value = default_value;
  const bool is_declared = parameters.has_parameter(name);
  if (is_declared) {
    const auto present = parameters.describe_parameters({name}).at(0);
    if (!present.description.empty() || !present.dynamic_typing || present.read_only)
      return;
    value = parameters.get_parameter(name).get_parameter_value();
    parameters.undeclare_parameter(name);
  }
  try {
    parameters.declare_parameter(name, value, descriptor, is_declared);
  }
  catch (const rclcpp::exceptions::InvalidParameterValueException& refusal) {
    RCLCPP_ERROR(logger,
                 "%s. The default holds",
                 reasonOf(refusal, parameters, name, parameter).c_str());
    parameters.declare_parameter(name, default_value, descriptor, true);
  }
}

} // namespace

struct NodeParameters::State {
  std::string prefix;
  Descriptions descriptions;
  Kind kind = Kind::Changeable;
  mutable std::mutex mutex; // guards what follows
  Check check;
  Listener listener;
  ParameterValues values;

  const ParameterDescription*
  find(const std::string& name) const
  {
    if (name.compare(0, prefix.size(), prefix) != 0)
      return nullptr;
    const auto parameter = std::find_if(
        descriptions.begin(),
        descriptions.end(),
        [&](const ParameterDescription& known) {
          return name.compare(prefix.size(), std::string::npos, known.name) == 0;
        });
    return parameter == descriptions.end() ? nullptr : &*parameter;
  }

  /** \brief The present values with some that may replace them; nothing if all of these
   * are those of other parameters.
   * \param[out] fault what is wrong; empty if nothing
   */
  std::optional<ParameterValues>
  changed(const std::vector<rclcpp::Parameter>& parameters, std::string& fault) const
  {
    const std::lock_guard<std::mutex> lock(mutex);
    ParameterValues result = values;
    bool is_any = false;
    for (const rclcpp::Parameter& parameter : parameters) {
      const ParameterDescription* const known = find(parameter.get_name());
      if (known == nullptr)
        continue;
      is_any = true;
      if (kind == Kind::Optional &&
          parameter.get_type() == rclcpp::ParameterType::PARAMETER_NOT_SET) {
        result.erase(known->name);
        continue;
      }
      const auto value = toValue(parameter);
      const auto converted = value ? convertedValue(*known, *value) : std::nullopt;
      if (converted)
        result[known->name] = *converted;
      else
        fault = value ? refusalOf(*known, *value)
                      : known->name + " is " + parameter.value_to_string() +
                            "; it must be " + allowedValues(*known);
    }
    if (!is_any)
      return std::nullopt;
    if (fault.empty() && check)
      fault = check(result);
    if (!fault.empty())
      fault.insert(0, prefix);
    return result;
  }
};

NodeParameters::NodeParameters(const NodeInterfaces& node,
                               std::string prefix,
                               const Descriptions& descriptions,
                               Check check,
                               Listener listener,
                               Kind kind)
: state_(std::make_shared<State>())
{
  NodeInterfaces interfaces = node; // whose members are not const
  Parameters& parameters = *interfaces.get_node_parameters_interface();
  const rclcpp::Logger logger = interfaces.get_node_logging_interface()->get_logger();
  state_->prefix = std::move(prefix);
  state_->descriptions = descriptions;
  state_->kind = kind;
  if (kind != Kind::Optional)
    state_->values = pcl_ext::nodes::defaultsOf(descriptions);
  on_set_ = parameters.add_on_set_parameters_callback(
      [state = state_](const std::vector<rclcpp::Parameter>& set) {
        rcl_interfaces::msg::SetParametersResult result;
        state->changed(set, result.reason);
        result.successful = result.reason.empty();
        return result;
      });
  const auto take = [state = state_](const std::vector<rclcpp::Parameter>& set) {
    std::string fault;
    auto values = state->changed(set, fault);
    if (!values || !fault.empty())
      return fault;
    const std::lock_guard<std::mutex> lock(state->mutex);
    state->values = std::move(*values);
    return fault;
  };
  post_set_ = parameters.add_post_set_parameters_callback(
      [state = state_, take](const std::vector<rclcpp::Parameter>& set) {
        const ParameterValues before = [&] {
          const std::lock_guard<std::mutex> lock(state->mutex);
          return state->values;
        }();
        take(set);
        const std::lock_guard<std::mutex> lock(state->mutex);
        if (state->values != before && state->listener)
          state->listener(state->values);
      });
  for (const ParameterDescription& parameter : descriptions) {
    const std::string name = state_->prefix + parameter.name;
    // Two instances may have the same parameters, as those of publishers of one topic.
    const rclcpp::ParameterValue default_value = kind == Kind::Optional
                                                     ? rclcpp::ParameterValue()
                                                     : toRos(parameter.default_value);
    declare(parameters, logger, name, default_value, parameter, kind);
    if (const std::string fault = take({parameters.get_parameter(name)});
        !fault.empty())
      RCLCPP_ERROR(logger, "%s. The default holds", fault.c_str());
  }
  // Not before, as parameters that are declared one by one may contradict defaults.
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->check = std::move(check);
  state_->listener = std::move(listener);
}

ParameterValues
NodeParameters::values() const
{
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->values;
}

} // namespace pcl_ext_ros_common

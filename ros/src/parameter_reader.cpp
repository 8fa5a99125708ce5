// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "parameter_reader.h"

#include <sstream>

namespace pcl_ext_ros1 {

using pcl_ext::nodes::ParameterDescription;
using pcl_ext::nodes::ParameterValue;
using pcl_ext::nodes::ParameterValues;
using XmlRpc::XmlRpcValue;

namespace {

/** \brief Nothing if the value is of a type that no parameter of a table has, as maps,
 * and lists of other elements than numbers. */
std::optional<ParameterValue>
toParameterValue(XmlRpcValue value)
{
  switch (value.getType()) {
  case XmlRpcValue::TypeBoolean:
    return static_cast<bool>(value);
  case XmlRpcValue::TypeInt:
    return std::int64_t{static_cast<int>(value)};
  case XmlRpcValue::TypeDouble:
    return static_cast<double>(value);
  case XmlRpcValue::TypeString:
    return static_cast<std::string>(value);
  case XmlRpcValue::TypeArray: {
    std::vector<double> numbers;
    for (int i = 0; i < value.size(); ++i)
      if (value[i].getType() == XmlRpcValue::TypeInt)
        numbers.push_back(static_cast<int>(value[i]));
      else if (value[i].getType() == XmlRpcValue::TypeDouble)
        numbers.push_back(static_cast<double>(value[i]));
      else
        return std::nullopt;
    return numbers;
  }
  default:
    return std::nullopt;
  }
}

/** \brief A value in one line, for messages. */
std::string
toText(XmlRpcValue value)
{
  if (const auto known = toParameterValue(value))
    return pcl_ext::nodes::textOf(*known);
  std::ostringstream text;
  if (value.getType() != XmlRpcValue::TypeArray) {
    value.write(text);
    return text.str();
  }
  for (int i = 0; i < value.size(); ++i)
    text << (i == 0 ? "[" : ", ") << toText(value[i]);
  return text.str() + "]";
}

[[noreturn]] void
refuse(const std::string& name, const XmlRpcValue& value, const std::string& allowed)
{
  throw WrongParameter("Parameter ~" + name + " is " + toText(value) + "; it must be " +
                       allowed);
}

} // namespace

ParameterValues
ParameterReader::values(const std::vector<ParameterDescription>& parameters)
{
  ParameterValues values;
  for (const ParameterDescription& parameter : parameters) {
    values[parameter.name] = parameter.default_value;
    const auto found = find(parameter.name);
    if (!found)
      continue;
    const auto value = toParameterValue(*found);
    const auto converted =
        value ? convertedValue(parameter, *value) : std::optional<ParameterValue>();
    if (!converted)
      refuse(parameter.name, *found, allowedValues(parameter));
    values[parameter.name] = *converted;
  }
  return values;
}

std::optional<std::vector<std::string>>
ParameterReader::topics(const std::string& name)
{
  auto value = find(name);
  if (!value)
    return std::nullopt;
  const char* const allowed = "a list of topics, which is not empty";
  if (value->getType() != XmlRpcValue::TypeArray || value->size() == 0)
    refuse(name, *value, allowed);
  std::vector<std::string> topics;
  for (int i = 0; i < value->size(); ++i) {
    if ((*value)[i].getType() != XmlRpcValue::TypeString)
      refuse(name, *value, allowed);
    topics.push_back(static_cast<std::string>((*value)[i]));
  }
  return topics;
}

void
ParameterReader::refuseUnknownNames() const
{
  std::vector<std::string> full_names;
  private_node_.getParamNames(full_names);
  const std::string prefix = private_node_.getNamespace() + "/";
  for (const std::string& full_name : full_names) {
    if (full_name.compare(0, prefix.size(), prefix) != 0)
      continue;
    const std::string name = full_name.substr(prefix.size());
    // Names with a slash are of a node in this node's namespace.
    if (name.find('/') != std::string::npos || known_names_.count(name) != 0)
      continue;
    std::string known;
    for (const std::string& known_name : known_names_)
      known += (known.empty() ? "~" : ", ~") + known_name;
    throw WrongParameter("Unknown parameter ~" + name + "; known are: " + known);
  }
}

std::optional<XmlRpcValue>
ParameterReader::find(const std::string& name)
{
  known_names_.insert(name);
  XmlRpcValue value;
  if (!private_node_.getParam(name, value))
    return std::nullopt;
  return value;
}

} // namespace pcl_ext_ros1

#include "parameter_reader.h"

#include <sstream>

namespace pcl_ext_ros1 {

using pcl_ext::nodes::ParameterDescription;
using pcl_ext::nodes::ParameterValue;
using pcl_ext::nodes::ParameterValues;
using XmlRpc::XmlRpcValue;

namespace {

/** \brief Nothing unless the value is an integer or a floating-point number. */
std::optional<double>
toNumber(XmlRpcValue value)
{
  if (value.getType() == XmlRpcValue::TypeInt)
    return static_cast<int>(value);
  if (value.getType() == XmlRpcValue::TypeDouble)
    return static_cast<double>(value);
  return std::nullopt;
}

} // namespace

std::string
toText(const XmlRpcValue& value)
{
  if (const auto known = toParameterValue(value))
    return pcl_ext::nodes::textOf(*known);
  XmlRpcValue copy = value; // some versions convert non-const values only
  std::ostringstream text;
  if (copy.getType() != XmlRpcValue::TypeArray) {
    copy.write(text);
    return text.str();
  }
  for (int i = 0; i < copy.size(); ++i)
    text << (i == 0 ? "[" : ", ") << toText(copy[i]);
  return text.str() + "]";
}

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
      if (const std::optional<double> number = toNumber(value[i]))
        numbers.push_back(*number);
      else
        return std::nullopt;
    return numbers;
  }
  default:
    return std::nullopt;
  }
}

std::optional<ParameterValue>
convertedValue(const ParameterDescription& parameter, const XmlRpcValue& value)
{
  const std::optional<ParameterValue> known = toParameterValue(value);
  return known ? pcl_ext::nodes::convertedValue(parameter, *known) : std::nullopt;
}

ParameterValues
ParameterReader::values(const std::vector<ParameterDescription>& parameters)
{
  ParameterValues values;
  for (const ParameterDescription& parameter : parameters)
    values[parameter.name] =
        value(parameter.name, parameter).value_or(parameter.default_value);
  return values;
}

std::optional<ParameterValue>
ParameterReader::value(const std::string& name, const ParameterDescription& description)
{
  const auto found = find(name);
  if (!found)
    return std::nullopt;
  const std::optional<ParameterValue> converted = convertedValue(description, *found);
  if (!converted)
    refuse(name, toText(*found), allowedValues(description));
  return converted;
}

std::optional<std::vector<XmlRpcValue>>
ParameterReader::list(const std::string& name)
{
  auto value = find(name);
  if (!value)
    return std::nullopt;
  if (value->getType() != XmlRpcValue::TypeArray)
    refuse(name, toText(*value), "a list");
  std::vector<XmlRpcValue> elements;
  for (int i = 0; i < value->size(); ++i)
    elements.push_back((*value)[i]);
  return elements;
}

void
ParameterReader::refuse(const std::string& name,
                        const std::string& value,
                        const std::string& allowed)
{
  throw WrongParameter("Parameter ~" + name + " is " + value + "; it must be " +
                       allowed);
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
    // Names with a slash are of single streams, or of a node in this node's namespace.
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

#include "parameter_reader.h"

#include <cmath>
#include <sstream>

namespace pcl_ext_ros {

namespace {

std::string
toText(double number)
{
  std::ostringstream text;
  text << number;
  return text.str();
}

} // namespace

std::string
toText(const XmlRpc::XmlRpcValue& value)
{
  XmlRpc::XmlRpcValue copy = value; // some versions read only what is not const
  // By itself a double is shown with six digits behind the point.
  if (copy.getType() == XmlRpc::XmlRpcValue::TypeDouble)
    return toText(static_cast<double>(copy));
  if (copy.getType() == XmlRpc::XmlRpcValue::TypeString)
    return "'" + static_cast<std::string>(copy) + "'";
  std::ostringstream text;
  text << copy;
  return text.str();
}

std::optional<double>
toNumber(XmlRpc::XmlRpcValue value)
{
  if (value.getType() == XmlRpc::XmlRpcValue::TypeInt)
    return static_cast<int>(value);
  if (value.getType() == XmlRpc::XmlRpcValue::TypeDouble)
    return static_cast<double>(value);
  return std::nullopt;
}

std::optional<float>
toFloat(const XmlRpc::XmlRpcValue& value)
{
  const std::optional<double> number = toNumber(value);
  // NaN fails the comparison, too.
  if (!number || !(std::abs(*number) <= largest_float))
    return std::nullopt;
  return static_cast<float>(*number);
}

std::optional<bool>
toFlag(XmlRpc::XmlRpcValue value)
{
  if (value.getType() != XmlRpc::XmlRpcValue::TypeBoolean)
    return std::nullopt;
  return static_cast<bool>(value);
}

double
ParameterReader::number(const std::string& name,
                        double default_value,
                        double lowest,
                        double highest)
{
  const auto value = find(name);
  if (!value)
    return default_value;
  const std::optional<double> number = toNumber(*value);
  // NaN fails the comparisons, too.
  if (!number || !(*number >= lowest && *number <= highest))
    refuse(name,
           toText(*value),
           "a number from " + toText(lowest) + " to " + toText(highest));
  return *number;
}

float
ParameterReader::finite(const std::string& name, float default_value)
{
  return static_cast<float>(
      number(name, static_cast<double>(default_value), -largest_float, largest_float));
}

int
ParameterReader::count(const std::string& name,
                       int default_value,
                       int lowest,
                       int highest)
{
  auto value = find(name);
  if (!value)
    return default_value;
  const bool is_whole = value->getType() == XmlRpc::XmlRpcValue::TypeInt;
  const int count = is_whole ? static_cast<int>(*value) : 0;
  if (!is_whole || count < lowest || count > highest)
    refuse(name,
           toText(*value),
           "a whole number from " + std::to_string(lowest) + " to " +
               std::to_string(highest));
  return count;
}

bool
ParameterReader::flag(const std::string& name, bool default_value)
{
  const auto value = find(name);
  if (!value)
    return default_value;
  const std::optional<bool> flag = toFlag(*value);
  if (!flag)
    refuse(name, toText(*value), "true or false");
  return *flag;
}

std::string
ParameterReader::text(const std::string& name, const std::string& default_value)
{
  auto value = find(name);
  if (!value)
    return default_value;
  if (value->getType() != XmlRpc::XmlRpcValue::TypeString)
    refuse(name, toText(*value), "a text");
  return static_cast<std::string>(*value);
}

std::string
ParameterReader::nonEmptyText(const std::string& name, const std::string& default_value)
{
  const std::string found = text(name, default_value);
  if (found.empty())
    refuse(name, "''", "a text that is not empty");
  return found;
}

std::optional<std::vector<XmlRpc::XmlRpcValue>>
ParameterReader::list(const std::string& name)
{
  auto value = find(name);
  if (!value)
    return std::nullopt;
  if (value->getType() != XmlRpc::XmlRpcValue::TypeArray)
    refuse(name, toText(*value), "a list");
  std::vector<XmlRpc::XmlRpcValue> elements;
  for (int i = 0; i < value->size(); ++i)
    elements.push_back((*value)[i]);
  return elements;
}

bool
ParameterReader::isSet(const std::string& name)
{
  return find(name).has_value();
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
ParameterReader::know(const std::string& name)
{
  known_names_.insert(name);
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
    // A deeper name may belong to a node that is named below this one.
    if (name.find('/') != std::string::npos || known_names_.count(name) != 0)
      continue;
    std::string known;
    for (const std::string& known_name : known_names_)
      known += (known.empty() ? "~" : ", ~") + known_name;
    throw WrongParameter("Parameter ~" + name +
                         " is none of this node's; it knows: " + known);
  }
}

std::optional<XmlRpc::XmlRpcValue>
ParameterReader::find(const std::string& name)
{
  know(name);
  XmlRpc::XmlRpcValue value;
  if (!private_node_.getParam(name, value))
    return std::nullopt;
  return value;
}

} // namespace pcl_ext_ros

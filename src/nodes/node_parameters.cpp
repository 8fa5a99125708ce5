// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/node_parameters.h>

#include "bytes/exact_text.h"

#include <algorithm>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief The numbers of "[0, 0.5, 1]"; nothing if the text is none of the form. */
std::optional<std::vector<double>>
numbersOf(const std::string& text)
{
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  char mark = 0;
  if (!(stream >> mark) || mark != '[')
    return std::nullopt;
  if ((stream >> std::ws).peek() == ']')
    stream >> mark;
  while (mark != ']') {
    double number = 0.0;
    if (!(stream >> number >> mark) || (mark != ',' && mark != ']'))
      return std::nullopt;
    numbers.push_back(number);
  }
  return (stream >> mark) ? std::nullopt : std::make_optional(numbers);
}

std::string
quoted(const std::string& text)
{
  return "'" + text + "'";
}

/** \brief True for all numbers, except for those that a float or a double cannot
 * have. */
bool
hasAnyFiniteNumber(const ParameterDescription& parameter)
{
  constexpr double largest = std::numeric_limits<float>::max();
  return parameter.lowest <= -largest && parameter.highest >= largest;
}

bool
isInRange(const ParameterDescription& parameter, double number)
{
  // The comparisons are false for NaN, too.
  return number >= parameter.lowest && number <= parameter.highest;
}

/** \brief True if a value of the parameter's type is in its range or one of its
 * words. */
bool
isInRange(const ParameterDescription& parameter, const ParameterValue& value)
{
  if (const auto* integer = std::get_if<std::int64_t>(&value))
    return isInRange(parameter, static_cast<double>(*integer));
  if (const auto* number = std::get_if<double>(&value))
    return isInRange(parameter, *number);
  if (const auto* text = std::get_if<std::string>(&value))
    return parameter.words.empty()
               ? !text->empty()
               : std::count(parameter.words.begin(), parameter.words.end(), *text) != 0;
  if (const auto* list = std::get_if<std::vector<double>>(&value))
    return (parameter.list_size == 0 || list->size() == parameter.list_size) &&
           std::all_of(list->begin(), list->end(), [&](double element) {
             return isInRange(parameter, element);
           });
  return true;
}

/** \brief The values in the range, or the words. */
std::string
valuesInRange(const ParameterDescription& parameter)
{
  const std::string range =
      " from " + exactText(parameter.lowest) + " to " + exactText(parameter.highest);
  const ParameterValue& type = parameter.default_value;
  if (std::holds_alternative<bool>(type))
    return "true or false";
  if (std::holds_alternative<std::int64_t>(type))
    return "a whole number" + range;
  if (std::holds_alternative<double>(type))
    return hasAnyFiniteNumber(parameter) ? "a finite number" : "a number" + range;
  if (std::holds_alternative<std::vector<double>>(type)) {
    const std::string size =
        parameter.list_size == 0 ? "" : std::to_string(parameter.list_size) + " ";
    return hasAnyFiniteNumber(parameter) ? "a list of " + size + "finite numbers"
                                         : "a list of " + size + "numbers" + range;
  }
  if (parameter.words.empty())
    return "a text that is not empty";
  std::string words;
  for (const std::string& word : parameter.words)
    words += (words.empty() ? "" : ", ") + word;
  return "one of: " + words;
}

} // namespace

const ParameterDescription&
descriptionOf(const std::vector<ParameterDescription>& parameters,
              const std::string& name)
{
  for (const ParameterDescription& parameter : parameters)
    if (parameter.name == name)
      return parameter;
  throw std::out_of_range("no parameter has the name " + name);
}

bool
isInterval(const ParameterDescription& parameter)
{
  return isInRange(parameter, parameter.default_value) &&
         (!parameter.may_be_zero || isInRange(parameter, 0.0));
}

std::string
allowedValues(const ParameterDescription& parameter)
{
  const std::string in_range = valuesInRange(parameter);
  if (parameter.may_be_zero)
    return isInterval(parameter) ? in_range : in_range + ", or 0";
  return isInRange(parameter, parameter.default_value)
             ? in_range
             : in_range + ", or " + textOf(parameter.default_value);
}

std::optional<ParameterValue>
convertedValue(const ParameterDescription& parameter, const ParameterValue& value)
{
  ParameterValue converted = value;
  if (std::holds_alternative<double>(parameter.default_value))
    if (const auto* integer = std::get_if<std::int64_t>(&value))
      converted = static_cast<double>(*integer);
  // Programs that set parameters make a text of a list with whole and other numbers.
  if (std::holds_alternative<std::vector<double>>(parameter.default_value))
    if (const auto* text = std::get_if<std::string>(&value))
      if (auto numbers = numbersOf(*text))
        converted = std::move(*numbers);
  const bool is_zero =
      converted == ParameterValue(0.0) || converted == ParameterValue(std::int64_t{0});
  const bool is_allowed =
      converted.index() == parameter.default_value.index() &&
      (isInRange(parameter, converted) || converted == parameter.default_value ||
       (parameter.may_be_zero && is_zero));
  return is_allowed ? std::optional<ParameterValue>(std::move(converted))
                    : std::nullopt;
}

std::string
textOf(const ParameterValue& value)
{
  if (const auto* flag = std::get_if<bool>(&value))
    return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value))
    return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value))
    return exactText(*number);
  if (const auto* text = std::get_if<std::string>(&value))
    return quoted(*text);
  std::string elements;
  for (const double element : std::get<std::vector<double>>(value))
    elements += (elements.empty() ? "" : ", ") + exactText(element);
  return "[" + elements + "]";
}

std::string
refusalOf(const ParameterDescription& parameter, const ParameterValue& value)
{
  return parameter.name + " is " + textOf(value) + "; it must be " +
         allowedValues(parameter);
}

ParameterValues
defaultsOf(const std::vector<ParameterDescription>& parameters)
{
  ParameterValues values;
  for (const ParameterDescription& parameter : parameters)
    values[parameter.name] = parameter.default_value;
  return values;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

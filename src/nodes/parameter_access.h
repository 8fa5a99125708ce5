// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/impl/named_value.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

// Describing parameters, and reading their values.

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Largest value of a setting of type float. */
constexpr double largest_float_value = std::numeric_limits<float>::max();

/** \brief Largest intensity that a parameter sets; just below it, as decimals. */
constexpr double largest_intensity = 3.4e38;

/** \brief Largest value of an integer parameter. */
constexpr std::int32_t largest_integer = std::numeric_limits<std::int32_t>::max();

inline ParameterDescription
numberParameter(const std::string& name,
                const std::string& unit,
                double default_value,
                double lowest,
                double highest,
                const std::string& description)
{
  return {name, unit, default_value, lowest, highest, 0, {}, description};
}

inline ParameterDescription
countParameter(const std::string& name,
               const std::string& unit,
               std::uint32_t default_value,
               std::int32_t lowest,
               std::int32_t highest,
               const std::string& description)
{
  return {name,
          unit,
          std::int64_t{default_value},
          static_cast<double>(lowest),
          static_cast<double>(highest),
          0,
          {},
          description};
}

inline ParameterDescription
flagParameter(const std::string& name,
              bool default_value,
              const std::string& description)
{
  ParameterDescription parameter;
  parameter.name = name;
  parameter.default_value = default_value;
  parameter.description = description;
  return parameter;
}

inline ParameterDescription
textParameter(const std::string& name,
              const std::string& default_value,
              const std::string& description)
{
  ParameterDescription parameter;
  parameter.name = name;
  parameter.default_value = default_value;
  parameter.description = description;
  return parameter;
}

/** \brief A parameter that is the name of a value.
 * \param[in] table all values, of NamedValue
 */
template <typename TableT>
ParameterDescription
wordParameter(const std::string& name,
              const std::string& default_word,
              const TableT& table,
              const std::string& description)
{
  ParameterDescription parameter = textParameter(name, default_word, description);
  for (const auto& named : table)
    parameter.words.emplace_back(named.name);
  return parameter;
}

/** \brief The values of some parameters, where one that is missing has its default. */
class ParameterAccess {
public:
  /** \brief Both must outlive this.
   * \param[in] parameters their descriptions
   * \param[in] values each as convertedValue() returns it
   */
  ParameterAccess(const std::vector<ParameterDescription>& parameters,
                  const ParameterValues& values)
  : parameters_(parameters), values_(values)
  {}

  const ParameterValue&
  value(const std::string& name) const
  {
    const auto value = values_.find(name);
    return value != values_.end() ? value->second
                                  : descriptionOf(parameters_, name).default_value;
  }

  /** \brief The value of a parameter of type bool, std::int64_t, double, std::string or
   * std::vector<double>. */
  template <typename ValueT>
  const ValueT&
  get(const std::string& name) const
  {
    return std::get<ValueT>(value(name));
  }

  /** \brief An integer that is not negative. */
  std::uint32_t
  count(const std::string& name) const
  {
    return static_cast<std::uint32_t>(get<std::int64_t>(name));
  }

  float
  number(const std::string& name) const
  {
    return static_cast<float>(get<double>(name));
  }

  /** \brief The value that a parameter names, of a table of NamedValue.
   * \throws std::bad_optional_access if none has the name
   */
  template <typename TableT>
  auto
  named(const std::string& name, const TableT& table) const
  {
    return valueNamed(table, get<std::string>(name)).value();
  }

private:
  const std::vector<ParameterDescription>& parameters_;
  const ParameterValues& values_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <optional>
#include <string>
#include <string_view>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief A value of a setting and its name on command lines, in parameter files and in
 * Python. The values of a setting are a table of them, such as io::efforts. */
template <typename ValueT>
struct NamedValue {
  ValueT value;
  const char* name;
};

/** \brief The value that has a name in a table of NamedValue; nothing if none has. */
template <typename TableT>
auto
valueNamed(const TableT& table, std::string_view name)
    -> std::optional<decltype(table.begin()->value)>
{
  for (const auto& named : table)
    if (name == named.name)
      return named.value;
  return std::nullopt;
}

/** \brief The name of a value in a table of NamedValue; "unknown" if it has none. */
template <typename TableT, typename ValueT>
constexpr const char*
nameOf(const TableT& table, const ValueT& value)
{
  for (const auto& named : table)
    if (named.value == value)
      return named.name;
  return "unknown";
}

/** \brief All names of a table of NamedValue: "fast, balanced, small". */
template <typename TableT>
std::string
namesOf(const TableT& table)
{
  std::string names;
  for (const auto& named : table)
    names += std::string(names.empty() ? "" : ", ") + named.name;
  return names;
}

} // namespace pcl_ext::PCL_EXT_ABI

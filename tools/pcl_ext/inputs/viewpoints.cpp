// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/viewpoints.h"

#include "console/exit_status.h"
#include "options/text_values.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <sstream>
#include <vector>

namespace pcl_ext::tools {

namespace {

constexpr const char* default_viewpoint = "0,0,0,1,0,0,0";

/** \brief Seven numbers, or nothing. */
std::optional<std::vector<double>>
numbersOf(const std::string& text)
{
  try {
    std::vector<double> numbers = parseNumbers("viewpoint", text);
    return numbers.size() == 7 ? std::optional(std::move(numbers)) : std::nullopt;
  }
  catch (const UsageError&) {
    return std::nullopt;
  }
}

} // namespace

Viewpoints::Viewpoints(const StreamMetadata& metadata)
{
  const auto found = metadata.find(viewpoint_metadata);
  if (found == metadata.end())
    return;
  std::istringstream changes(found->second);
  std::string change;
  while (std::getline(changes, change, ';')) {
    const std::size_t colon = change.find(':');
    if (colon != std::string::npos && numbersOf(change.substr(colon + 1)))
      changes_[recording::Time(std::strtoll(change.c_str(), nullptr, 10))] =
          change.substr(colon + 1);
  }
}

void
Viewpoints::add(recording::Time time, const std::string& text)
{
  std::string viewpoint = text.empty() ? default_viewpoint : text;
  std::replace(viewpoint.begin(), viewpoint.end(), ' ', ',');
  if (!numbersOf(viewpoint))
    return;
  if (changes_.empty() || changes_.rbegin()->second != viewpoint)
    changes_[time] = viewpoint;
}

void
Viewpoints::append(const Viewpoints& later, recording::Time first, recording::Time last)
{
  changes_.erase(changes_.lower_bound(first), changes_.end());
  add(first, later.textAt(first));
  for (const auto& [time, viewpoint] : later.changes_)
    if (time > first && time <= last)
      add(time, viewpoint);
}

bool
Viewpoints::areDefault() const
{
  return std::all_of(changes_.begin(), changes_.end(), [](const auto& change) {
    return numbersOf(change.second) == numbersOf(default_viewpoint);
  });
}

std::string
Viewpoints::textAt(recording::Time time) const
{
  if (changes_.empty())
    return default_viewpoint;
  const auto after = changes_.upper_bound(time);
  return (after == changes_.begin() ? after : std::prev(after))->second;
}

Viewpoint
Viewpoints::at(recording::Time time) const
{
  if (changes_.empty())
    return {};
  const std::vector<double> numbers = numbersOf(textAt(time)).value();
  const Eigen::Map<const Eigen::Matrix<double, 7, 1>> values(numbers.data());
  Viewpoint viewpoint;
  viewpoint.origin.head<3>() = values.head<3>().cast<float>();
  viewpoint.orientation =
      Eigen::Quaterniond(values[3], values[4], values[5], values[6]).cast<float>();
  return viewpoint;
}

void
Viewpoints::addTo(StreamMetadata& metadata) const
{
  if (areDefault())
    return;
  std::string& text = metadata[viewpoint_metadata];
  for (const auto& [time, viewpoint] : changes_)
    text += (text.empty() ? "" : ";") + std::to_string(time.count()) + ':' + viewpoint;
}

} // namespace pcl_ext::tools

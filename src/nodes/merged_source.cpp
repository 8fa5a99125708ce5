// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/merged_source.h>

#include "nodes/latency.h"

#include <algorithm>
#include <charconv>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

const char* const all_streams = "all streams";
const char* const stamp_key = "stamp, ns";
const char* const dropped_key = "frames dropped";

void
addStamp(Time stamp, Time now, HealthReport& report)
{
  constexpr double milliseconds = 1e3; // per second
  report.add(stamp_key, stamp.count());
  if (const auto age = latencySeconds(stamp, now))
    report.add("age, ms", milliseconds * *age);
}

template <typename NumberT>
std::optional<NumberT>
numberOf(const std::string& text)
{
  NumberT number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && rest == end ? std::make_optional(number)
                                             : std::nullopt;
}

} // namespace

std::vector<std::pair<std::string, HealthReport>>
describeMerged(const std::vector<MergedSource>& sources, Time now)
{
  std::vector<std::pair<std::string, HealthReport>> reports;
  std::optional<Time> oldest;
  for (const MergedSource& source : sources) {
    HealthReport& report = reports.emplace_back(source.name, HealthReport()).second;
    if (source.stamp) {
      addStamp(*source.stamp, now, report);
      oldest = std::min(oldest.value_or(*source.stamp), *source.stamp);
    }
    else
      report.raise(HealthLevel::Stale, "Not merged: no frame within max_merge_age");
    report.add(dropped_key, source.frames_dropped);
  }
  HealthReport& all = reports.emplace_back(all_streams, HealthReport()).second;
  if (oldest)
    addStamp(*oldest, now, all);
  return reports;
}

std::vector<MergedSource>
readMergedSources(
    const std::vector<
        std::pair<std::string, std::vector<std::pair<std::string, std::string>>>>&
        reports)
{
  std::vector<MergedSource> sources;
  for (const auto& [name, values] : reports) {
    if (name == all_streams)
      continue;
    MergedSource& source = sources.emplace_back();
    source.name = name;
    for (const auto& [key, value] : values)
      if (key == stamp_key) {
        if (const auto stamp = numberOf<Time::rep>(value))
          source.stamp = Time(*stamp);
      }
      else if (key == dropped_key)
        source.frames_dropped = numberOf<std::size_t>(value).value_or(0);
  }
  return sources;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

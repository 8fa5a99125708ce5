// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "site/missing_streams.h"

#include "options/setting_options.h"

#include <algorithm>
#include <set>

namespace pcl_ext::tools {

namespace {

using link::SiteStream;

/** \brief The first ones of a list, with commas between them, and how many follow. */
std::string
listed(const std::set<std::string>& names)
{
  constexpr std::size_t most = 12;
  std::string text;
  std::size_t count = 0;
  for (const std::string& name : names) {
    if (count++ == most)
      return text + " and " + std::to_string(names.size() - most) + " more";
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

std::set<std::string>
sitesOf(const std::vector<SiteStream>& streams)
{
  std::set<std::string> sites;
  for (const SiteStream& stream : streams)
    sites.insert(stream.site);
  return sites;
}

} // namespace

std::vector<std::string>
MissingStreams::missing(const link::SubscriberStatistics& statistics) const
{
  std::vector<std::string> names;
  for (const std::string& name : settings_.streams)
    if (std::none_of(statistics.streams.begin(),
                     statistics.streams.end(),
                     [&name](const auto& stream) { return stream.name == name; }))
      names.push_back(name);
  return names;
}

std::string
MissingStreams::described(const std::vector<std::string>& names) const
{
  const std::string part = settings_.partition
                               ? " in partition " + std::to_string(*settings_.partition)
                               : std::string();
  const std::set<std::string> sorted(names.begin(), names.end());
  return (sorted.empty() ? "any stream" : "the stream " + listed(sorted)) +
         " of site " + settings_.link.site + part;
}

std::string
MissingStreams::reason(const link::SubscriberStatistics& statistics) const
{
  if (statistics.is_refused)
    return "the server does not permit this user to receive them";
  constexpr std::chrono::seconds duration{1};
  std::vector<SiteStream> found;
  const auto status = settings_.replay_from
                          ? link::keptStreams(settings_.link, found)
                          : link::liveStreams(settings_.link, duration, found);
  if (!status.ok())
    return messageOf(status);
  std::set<std::string> own;
  bool is_divided = false;
  for (const SiteStream& stream : found) {
    if (stream.site != settings_.link.site)
      continue;
    is_divided |= stream.partition.has_value();
    own.insert(settings_.partition && stream.partition
                   ? stream.name + " (partition " + std::to_string(*stream.partition) +
                         ")"
                   : stream.name);
  }
  if (!own.empty())
    return "streams on this site: " + listed(own) +
           (settings_.partition && !is_divided
                ? ". The server does not divide them: its configuration needs a mapping"
                : "");
  if (settings_.replay_from)
    return "the server keeps no frame of this site";
  const std::set<std::string> sites = sitesOf(found);
  return "nothing " +
         std::string(statistics.violations > 0 ? "that this user may receive " : "") +
         "is sent to this site at the moment; " +
         (sites.empty() ? "this user sees no other site on the server"
                        : "sites on this server: " + listed(sites));
}

void
MissingStreams::remark(const link::FrameSubscriber& receiver,
                       std::chrono::steady_clock::duration time)
{
  constexpr std::chrono::seconds patience{5};
  if (has_remarked_ || time < patience)
    return;
  has_remarked_ = true;
  const link::SubscriberStatistics statistics = receiver.statistics();
  const std::vector<std::string> names = missing(statistics);
  if (statistics.streams.empty() || !names.empty())
    console_.remark("nothing has come yet of " + described(names) + "; " +
                    reason(statistics));
}

bool
MissingStreams::report(const link::SubscriberStatistics& statistics, bool may_listen)
{
  const std::vector<std::string> names = missing(statistics);
  if (!statistics.streams.empty() && names.empty())
    return false;
  console_.error("nothing came of " + described(names) +
                 (may_listen ? "; " + reason(statistics) : ""));
  return true;
}

} // namespace pcl_ext::tools

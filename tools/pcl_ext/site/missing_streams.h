// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "console/console.h"
#include "options/setting_options.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief The first ones of a list, with commas between them, and how many follow. */
inline std::string
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

inline std::set<std::string>
sitesOf(const std::vector<link::SiteStream>& streams)
{
  std::set<std::string> sites;
  for (const link::SiteStream& stream : streams)
    sites.insert(stream.site);
  return sites;
}

/** \brief Tells why a receiver gets nothing, or not all streams that it names, by the
 * streams that the server has. */
class MissingStreams {
public:
  /** \param[in] settings those of the receiver; it and console must outlive this */
  MissingStreams(const link::SubscriberSettings& settings, Console& console)
  : settings_(settings), console_(console)
  {}

  /** \brief Prints once what may be wrong where nothing comes; listens for a second.
   * \param[in] time since the receiver began
   */
  void
  remark(const link::FrameSubscriber& receiver,
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

  /** \brief Prints what has not come by the end.
   * \param[in] may_listen to find out why, for a second
   * \return true if that is something
   */
  bool
  report(const link::SubscriberStatistics& statistics, bool may_listen)
  {
    const std::vector<std::string> names = missing(statistics);
    if (!statistics.streams.empty() && names.empty())
      return false;
    console_.error("nothing came of " + described(names) +
                   (may_listen ? "; " + reason(statistics) : ""));
    return true;
  }

private:
  /** \brief Names of streams that were asked for and have not come. */
  std::vector<std::string>
  missing(const link::SubscriberStatistics& statistics) const
  {
    std::vector<std::string> names;
    for (const std::string& name : settings_.streams)
      if (std::none_of(statistics.streams.begin(),
                       statistics.streams.end(),
                       [&name](const auto& stream) { return stream.name == name; }))
        names.push_back(name);
    return names;
  }

  /** \brief The streams that are asked for, in words. */
  std::string
  described(const std::vector<std::string>& names) const
  {
    const std::string part =
        settings_.partition ? " in partition " + std::to_string(*settings_.partition)
                            : std::string();
    const std::set<std::string> sorted(names.begin(), names.end());
    return (sorted.empty() ? "any stream" : "the stream " + listed(sorted)) +
           " of site " + settings_.link.site + part;
  }

  /** \brief What the server has in their place, or that it does not permit them. */
  std::string
  reason(const link::SubscriberStatistics& statistics) const
  {
    if (statistics.is_refused)
      return "the server does not permit this user to receive them";
    constexpr std::chrono::seconds duration{1};
    std::vector<link::SiteStream> found;
    const auto status = settings_.replay_from
                            ? link::keptStreams(settings_.link, found)
                            : link::liveStreams(settings_.link, duration, found);
    if (!status.ok())
      return messageOf(status);
    std::set<std::string> own;
    bool is_divided = false;
    for (const link::SiteStream& stream : found) {
      if (stream.site != settings_.link.site)
        continue;
      is_divided |= stream.partition.has_value();
      own.insert(settings_.partition && stream.partition
                     ? stream.name + " (partition " +
                           std::to_string(*stream.partition) + ")"
                     : stream.name);
    }
    if (!own.empty())
      return "streams on this site: " + listed(own) +
             (settings_.partition && !is_divided ? ". The server does not divide them: "
                                                   "its configuration needs a mapping"
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

  const link::SubscriberSettings& settings_;
  Console& console_;
  bool has_remarked_ = false;
};

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_publisher.h>
#include <pcl_ext/link/frame_subscriber.h>
#include <pcl_ext/nodes/impl/health_metrics.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/merge_schedule.h>
#include <pcl_ext/nodes/stream_health.h>

#include "console/console.h"
#include "live/status_line.h"
#include "site/centre.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief What a receiver of a site has done. */
struct SiteFigures {
  std::string site;
  link::SubscriberStatistics received;

  // Of a centre; else empty.
  std::vector<nodes::StreamHealth> decoded;
  std::map<std::string, Centre::Missing> missing; ///< see Centre::missing()
  double merged_resolution = 0.0;                 ///< see Centre::mergedResolution()
  bool has_slow_effort = false;                   ///< see Centre::hasSlowEffort()
  nodes::MergeCounts merged;
  nodes::MapCounts mapped;
  std::optional<link::PublisherStatistics> published; ///< of the merged stream
  std::optional<std::uint64_t> recorded; ///< frames, where recording has failed
};

/** \brief The state for the status line. */
LiveFigures
liveFiguresOf(const SiteFigures& figures);

/** \brief A sentence on merged frames that were left out, as the machine is too slow;
 * empty if none was.
 * \param[in] has_slow_effort whether a faster effort helps
 */
std::string
slownessOf(const nodes::MergeCounts& merged, bool has_slow_effort);

std::string
slownessOf(const nodes::MapCounts& mapped);

/** \brief Prints what arrived, and what did not.
 * \return false if something is missing
 */
bool
report(const SiteFigures& figures, Console& console);

} // namespace pcl_ext::tools

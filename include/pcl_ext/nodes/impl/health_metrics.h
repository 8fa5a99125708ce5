// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/merge_schedule.h>
#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Names and values of labels that all samples have, as the site and the centre.
 * Names are of [a-zA-Z_][a-zA-Z0-9_]*, other than stream and le; values are any bytes. */
using MetricLabels = std::vector<std::pair<std::string, std::string>>;

/** \brief Health of decoded streams for Prometheus: the metrics pcl_ext_stream_... of
 * doc/monitoring.md, in the text format 0.0.4. The texts of streams and of senders may
 * be put one behind the other.
 * \param[in] streams with different names, which become the label stream; as
 * CentralNode::health() has them
 * \param[in] now time of CentralNodeSettings::clock
 */
PCL_EXT_EXPORT std::string
streamMetrics(const std::vector<StreamHealth>& streams,
              Time now,
              const MetricLabels& labels = {});

/** \brief How many merged frames a centre made: the metrics pcl_ext_merged_... . */
PCL_EXT_EXPORT std::string
mergeMetrics(const MergeCounts& counts, const MetricLabels& labels = {});

/** \brief Updates of a map, one for each second of the clouds' time. */
struct MapCounts {
  std::size_t made = 0;
  std::size_t left_out = 0; ///< as others were not complete in time
};

/** \brief How often a map got the frames of its streams: the metrics pcl_ext_map_... . */
PCL_EXT_EXPORT std::string
mapMetrics(const MapCounts& counts, const MetricLabels& labels = {});

/** \brief Health of streams where they are encoded: the metrics pcl_ext_sender_... .
 * \param[in] senders by the names of their streams, all different
 * \param[in] now time of the clock of SenderHealth::last_arrival
 */
PCL_EXT_EXPORT std::string
senderMetrics(const std::vector<std::pair<std::string, SenderHealth>>& senders,
              Time now,
              const MetricLabels& labels = {});

} // namespace pcl_ext::PCL_EXT_ABI::nodes

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/link/frame_publisher.h>
#include <pcl_ext/link/frame_subscriber.h>

#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief What a subscriber received, for Prometheus: the metrics pcl_ext_link_... of
 * doc/monitoring.md, in the text format 0.0.4.
 * \param[in] labels of all samples: names of [a-zA-Z_][a-zA-Z0-9_]* other than stream,
 * and values of any bytes
 */
PCL_EXT_LINK_EXPORT std::string
linkMetrics(const SubscriberStatistics& statistics,
            const std::vector<std::pair<std::string, std::string>>& labels = {});

/** \brief What a publisher sent: the metrics pcl_ext_publisher_... . */
PCL_EXT_LINK_EXPORT std::string
linkMetrics(const PublisherStatistics& statistics,
            const std::vector<std::pair<std::string, std::string>>& labels = {});

} // namespace pcl_ext::PCL_EXT_ABI::link

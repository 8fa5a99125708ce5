// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include <string>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief A server's figures for Prometheus: the metrics pcl_ext_view_... of
 * doc/monitoring.md. */
std::string
metricsOf(const ViewServerStatistics& statistics);

} // namespace pcl_ext::PCL_EXT_ABI::view

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"
#include "site/frame_taker.h"

#include <CLI/App.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief How the streams of a site are shown. */
struct SiteViewOptions {
  bool is_on = false;
  std::uint16_t port = 0;
  std::string address;
  bool opens_browser = true;
  std::string page;
};

/** \brief Adds --view and what belongs to it. */
void
addSiteViewOptions(CLI::App& app, SiteViewOptions& options);

/** \brief Serves the streams of a site to browsers, and their health to Prometheus.
 * \param[in] name shown on the page
 * \param[in] metrics called by another thread
 * \param[in] request_i_frame called by another thread
 * \throws std::exception if it cannot be served
 */
std::unique_ptr<FrameTaker>
makeSiteView(const SiteViewOptions& options,
             const std::string& name,
             std::function<void(const std::string& stream)> request_i_frame,
             std::function<std::string()> metrics,
             Console& console);

/** \brief Where metrics alone are served. */
struct MetricsOptions {
  std::optional<std::uint16_t> port; ///< none: they are not served
  std::string address;
};

/** \brief Adds --metrics-port and --metrics-address. */
void
addMetricsOptions(CLI::App& app, MetricsOptions& options);

/** \brief Serves metrics until the result is destroyed.
 * \param[in] metrics called by another thread
 * \param[in] console is told their address
 * \return null if that is not wanted
 * \throws std::runtime_error
 */
std::shared_ptr<void>
serveMetrics(const MetricsOptions& options,
             std::function<std::string()> metrics,
             Console& console);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "options/options.h"
#include "site/centre.h"
#include "site/rotated_recording.h"
#include "site/site_view.h"

#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief What `pcl_ext receive` does with the streams of a site. */
struct ReceiveOptions {
  link::SubscriberSettings link;
  std::optional<double> seconds; ///< to receive for; none: until interrupted
  Output output;                 ///< path empty: no recording
  Rotation rotation;
  SiteViewOptions view;
  MetricsOptions metrics;
  CentreOptions centre;
  std::string
      merged_site; ///< of the merged stream; empty: that of the link with an end
  bool is_quiet = false;
};

/** \brief Adds the options of `pcl_ext receive`, which stay references to these. */
void
addReceiveOptions(CLI::App& app, ReceiveOptions& options);

/** \brief Checks options that were parsed, and sets those that follow from others.
 * \throws UsageError
 */
void
completeOptions(const CLI::App& app, ReceiveOptions& options);

} // namespace pcl_ext::tools

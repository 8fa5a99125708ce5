// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/server_metrics.h"

#include "bytes/metrics_text.h"

namespace pcl_ext::PCL_EXT_ABI::view {

std::string
metricsOf(const ViewServerStatistics& statistics)
{
  MetricsText text;
  const auto add = [&text](const std::string& name,
                           const std::string& type,
                           const std::string& help,
                           auto value) {
    text.beginFamily("pcl_ext_view_" + name, type, help);
    text.add(static_cast<double>(value));
  };
  add("connections", "gauge", "Open connections.", statistics.connections);
  add("viewers", "gauge", "Connections that take live streams.", statistics.viewers);
  add("connections_refused_total",
      "counter",
      "Connections beyond the limit.",
      statistics.refused);
  add("frames_total", "counter", "Frames of live streams.", statistics.frames);
  add("frames_sent_total",
      "counter",
      "Frames sent, summed over the viewers.",
      statistics.frames_sent);
  add("frames_skipped_total",
      "counter",
      "Frames that viewers were too slow for, summed over them.",
      statistics.frames_skipped);
  add("queued_bytes",
      "gauge",
      "Bytes that wait, summed over the viewers.",
      statistics.queued_bytes);
  add("kept_bytes",
      "gauge",
      "Bytes of the frames kept for new viewers.",
      statistics.kept_bytes);
  add("i_frame_requests_total",
      "counter",
      "Requests for I-frames that viewers needed.",
      statistics.i_frame_requests);
  return text.text();
}

} // namespace pcl_ext::PCL_EXT_ABI::view

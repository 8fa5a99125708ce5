// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/link_metrics.h"

#include "bytes/metrics_text.h"

#include <limits>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

/** \brief A counter that has one sample of each stream. */
struct StreamCounter {
  const char* name;
  const char* help;
  std::uint64_t LinkStreamStatistics::*count;
};

constexpr StreamCounter stream_counters[] = {
    {"frames",
     "Frames that arrived and can be decoded.",
     &LinkStreamStatistics::frames},
    {"bytes", "Bytes of these frames.", &LinkStreamStatistics::bytes},
    {"frames_lost",
     "Frames missing between the publisher's numbers.",
     &LinkStreamStatistics::frames_lost},
    {"frames_dropped",
     "Frames dropped, as they were not taken in time.",
     &LinkStreamStatistics::frames_dropped},
    {"frames_skipped",
     "Frames left out after a gap, until an I-frame came.",
     &LinkStreamStatistics::frames_skipped},
    {"frames_early",
     "Frames left out before the first I-frame.",
     &LinkStreamStatistics::frames_early},
    {"frames_late",
     "Frames that came late or twice.",
     &LinkStreamStatistics::frames_late},
    {"frames_damaged",
     "Frames whose checksum is wrong.",
     &LinkStreamStatistics::frames_damaged},
    {"messages_invalid",
     "Messages that are no frames.",
     &LinkStreamStatistics::messages_invalid},
    {"i_frame_requests",
     "Requests for I-frames sent.",
     &LinkStreamStatistics::i_frame_requests},
    {"publishers",
     "How often a publisher began, the first time included.",
     &LinkStreamStatistics::publishers}};

/** \brief Not a number where there is none: it has no sample then. */
double
secondsOf(const std::optional<std::chrono::nanoseconds>& age)
{
  return age ? std::chrono::duration<double>(*age).count()
             : std::numeric_limits<double>::quiet_NaN();
}

void
addConnection(const std::string& end,
              bool is_connected,
              std::uint64_t reconnections,
              MetricsText& text)
{
  text.beginFamily("pcl_ext_" + end + "_connected",
                   "gauge",
                   "1 while there is a connection to the server, else 0.");
  text.add(is_connected ? 1.0 : 0.0);
  text.beginFamily("pcl_ext_" + end + "_reconnections_total",
                   "counter",
                   "How often the connection to the server was restored.");
  text.add(static_cast<double>(reconnections));
}

} // namespace

std::string
linkMetrics(const SubscriberStatistics& statistics,
            const std::vector<std::pair<std::string, std::string>>& labels)
{
  MetricsText text(labels);
  for (const StreamCounter& counter : stream_counters) {
    text.beginFamily(std::string("pcl_ext_link_") + counter.name + "_total",
                     "counter",
                     counter.help);
    for (const LinkStreamStatistics& stream : statistics.streams)
      text.add(static_cast<double>(stream.*counter.count),
               MetricsText::labelOf("stream", stream.name));
  }
  text.beginFamily("pcl_ext_link_age_seconds",
                   "gauge",
                   "Time since a frame arrived; absent before the first.");
  for (const LinkStreamStatistics& stream : statistics.streams)
    text.add(secondsOf(stream.age), MetricsText::labelOf("stream", stream.name));
  addConnection("link", statistics.is_connected, statistics.reconnections, text);
  return text.text();
}

std::string
linkMetrics(const PublisherStatistics& statistics,
            const std::vector<std::pair<std::string, std::string>>& labels)
{
  MetricsText text(labels);
  const auto add = [&text](const char* name, const char* help, std::uint64_t count) {
    text.beginFamily(
        std::string("pcl_ext_publisher_") + name + "_total", "counter", help);
    text.add(static_cast<double>(count));
  };
  add("frames", "Frames that the server has.", statistics.frames);
  add("bytes", "Bytes of these frames.", statistics.bytes);
  add("frames_not_sent",
      "Frames lost without a connection, above max_payload, or not permitted.",
      statistics.frames_not_sent);
  add("i_frame_requests",
      "Requests for I-frames that arrived.",
      statistics.i_frame_requests);
  text.beginFamily("pcl_ext_publisher_frames_under_way",
                   "gauge",
                   "Frames of which it is not known yet whether the server has them.");
  text.add(static_cast<double>(statistics.frames_under_way));
  text.beginFamily("pcl_ext_publisher_age_seconds",
                   "gauge",
                   "Time since a frame was sent; absent before the first.");
  text.add(secondsOf(statistics.age));
  addConnection("publisher", statistics.is_connected, statistics.reconnections, text);
  return text.text();
}

} // namespace pcl_ext::PCL_EXT_ABI::link

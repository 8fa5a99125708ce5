#include <pcl_ext/link/link_metrics.h>

#include "bytes/metrics_text.h"

namespace pcl_ext {
namespace link {

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
     "Frames left out until an I-frame came.",
     &LinkStreamStatistics::frames_skipped},
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
  text.beginFamily("pcl_ext_link_reconnections_total",
                   "counter",
                   "How often the connection to the server was restored.");
  text.add(static_cast<double>(statistics.reconnections));
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
  add("frames", "Frames that were sent.", statistics.frames);
  add("bytes", "Bytes of these frames.", statistics.bytes);
  add("frames_not_sent",
      "Frames lost without a connection, or above max_payload.",
      statistics.frames_not_sent);
  add("i_frame_requests",
      "Requests for I-frames that arrived.",
      statistics.i_frame_requests);
  add("reconnections",
      "How often the connection to the server was restored.",
      statistics.reconnections);
  return text.text();
}

} // namespace link
} // namespace pcl_ext

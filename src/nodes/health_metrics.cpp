// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/health_metrics.h>

#include "bytes/metrics_text.h"
#include "nodes/latency.h"

#include <cstddef>
#include <cstdint>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief Value of what is not known: there is no sample. */
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

constexpr double rate_window =
    std::chrono::duration<double>(StreamRates::window).count(); // seconds

constexpr char counter[] = "counter";
constexpr char gauge[] = "gauge";

/** \brief A family that has one sample of each stream. */
template <typename HealthT>
struct Metric {
  const char* name; ///< behind the prefix of all
  const char* type;
  const char* help;
  double (*value)(const HealthT& health, Time now);
};

template <typename NumberT>
double
number(NumberT value)
{
  return static_cast<double>(value);
}

/** \brief From the stamp until a frame was ready; not known without stamps. */
double
latencyOf(const StreamRates& rates)
{
  return rates.mean_latency_seconds == 0.0 ? unknown : rates.mean_latency_seconds;
}

double
ageOf(const std::optional<Time>& last_arrival, Time now)
{
  return last_arrival ? secondsBetween(*last_arrival, now) : unknown;
}

// clang-format off
const Metric<StreamHealth> stream_metrics[] = {
    {"frames_received_total", counter, "Frames that arrived.",
     [](const StreamHealth& s, Time) { return number(s.frames_received); }},
    {"received_bytes_total", counter, "Bytes of the frames that arrived.",
     [](const StreamHealth& s, Time) { return number(s.bytes); }},
    {"frames_decoded_total", counter, "Frames that were decoded.",
     [](const StreamHealth& s, Time) { return number(s.frames_decoded); }},
    {"frames_failed_total", counter, "Frames that could not be decoded or denoised.",
     [](const StreamHealth& s, Time) { return number(s.frames_failed); }},
    {"frames_dropped_total", counter, "Frames that came late or twice.",
     [](const StreamHealth& s, Time) { return number(s.frames_dropped); }},
    {"frames_refused_total", counter,
     "Frames refused, as too many waited or memory ran out.",
     [](const StreamHealth& s, Time) { return number(s.frames_refused); }},
    {"frames_lost_total", counter, "Frames missing between the numbers of those decoded.",
     [](const StreamHealth& s, Time) { return number(s.frames_lost); }},
    {"i_frame_requests_total", counter, "Frames after which an I-frame was requested.",
     [](const StreamHealth& s, Time) { return number(s.i_frame_requests); }},
    {"memory_drops_total", counter, "Its voxels were dropped to keep the memory limit.",
     [](const StreamHealth& s, Time) { return number(s.memory_drops); }},
    {"in_sync", gauge, "1 if the last frame was decoded, else 0.",
     [](const StreamHealth& s, Time) { return s.in_sync ? 1.0 : 0.0; }},
    {"age_seconds", gauge, "Time since a frame was decoded; absent before the first.",
     [](const StreamHealth& s, Time now) {
       return s.frames_decoded == 0 ? unknown : secondsBetween(s.last_decoded, now); }},
    {"latency_seconds", gauge,
     "Mean time from a stamp until its frame was decoded, over 2 s; absent without "
     "stamps of this clock.",
     [](const StreamHealth& s, Time) { return latencyOf(s.rates); }},
    {"voxels", gauge, "Voxels of the last frame, before denoising.",
     [](const StreamHealth& s, Time) { return number(s.voxels); }},
    {"kept_voxels", gauge, "Voxels of the last frame, after denoising.",
     [](const StreamHealth& s, Time) { return number(s.kept_voxels); }}};

const Metric<SenderHealth> sender_metrics[] = {
    {"clouds_total", counter, "Clouds that arrived.",
     [](const SenderHealth& s, Time) { return number(s.clouds); }},
    {"clouds_missed_total", counter, "Clouds that were lost before they arrived.",
     [](const SenderHealth& s, Time) { return number(s.clouds_missed); }},
    {"clouds_refused_total", counter, "Clouds that could not be encoded.",
     [](const SenderHealth& s, Time) { return number(s.node.clouds_refused); }},
    {"clouds_without_transform_total", counter, "Clouds left out without a transform.",
     [](const SenderHealth& s, Time) { return number(s.cloudsWithoutTransform()); }},
    {"clouds_left_out_total", counter, "Clouds that max_rate had no room for.",
     [](const SenderHealth& s, Time) {
       return number(s.node.rate_control.clouds_left_out); }},
    {"cloud_bytes_total", counter, "Bytes of the clouds that became frames.",
     [](const SenderHealth& s, Time) { return number(s.node.cloud_bytes); }},
    {"frames_total", counter, "Frames that were encoded.",
     [](const SenderHealth& s, Time) { return number(s.node.frames); }},
    {"i_frames_total", counter, "I-frames among them.",
     [](const SenderHealth& s, Time) { return number(s.node.i_frames); }},
    {"frame_bytes_total", counter, "Bytes of the frames.",
     [](const SenderHealth& s, Time) { return number(s.node.frame_bytes); }},
    {"i_frame_requests_total", counter, "Requests for I-frames that arrived.",
     [](const SenderHealth& s, Time) { return number(s.i_frame_requests); }},
    {"age_seconds", gauge, "Time since a cloud arrived; absent before the first.",
     [](const SenderHealth& s, Time now) { return ageOf(s.last_arrival, now); }},
    {"latency_seconds", gauge,
     "Mean time from a stamp until its frame was encoded, over 2 s; absent without "
     "stamps of this clock.",
     [](const SenderHealth& s, Time now) {
       // Where the rates are those of the last cloud, however long ago.
       return ageOf(s.last_arrival, now) > rate_window
                  ? unknown : latencyOf(s.node.rates); }},
    {"voxels", gauge, "Voxels of the last frame.",
     [](const SenderHealth& s, Time) { return number(s.node.frame.coding.voxels); }}};
// clang-format on

void
addHistogram(const DurationHistogram& durations,
             const std::string& label,
             MetricsText& text)
{
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < DurationHistogram::upper_bounds.size(); ++i) {
    count += durations.counts[i];
    text.add(number(count),
             label + ',' +
                 MetricsText::labelOf(
                     "le", MetricsText::numberOf(DurationHistogram::upper_bounds[i])),
             "_bucket");
  }
  count += durations.counts.back();
  text.add(number(count), label + ",le=\"+Inf\"", "_bucket");
  text.add(durations.sum_seconds, label, "_sum");
  text.add(number(count), label, "_count");
}

} // namespace

std::string
streamMetrics(const std::vector<StreamHealth>& streams,
              Time now,
              const MetricLabels& labels)
{
  MetricsText text(labels);
  const auto label = [](const StreamHealth& stream) {
    return MetricsText::labelOf("stream", stream.name);
  };
  for (const Metric<StreamHealth>& metric : stream_metrics) {
    text.beginFamily(
        std::string("pcl_ext_stream_") + metric.name, metric.type, metric.help);
    for (const StreamHealth& stream : streams)
      text.add(metric.value(stream, now), label(stream));
  }
  text.beginFamily("pcl_ext_stream_decode_seconds",
                   "histogram",
                   "Computing time of a decoded frame, with denoising.");
  for (const StreamHealth& stream : streams)
    addHistogram(stream.decode_times, label(stream), text);
  return text.text();
}

std::string
mergeMetrics(const MergeCounts& counts, const MetricLabels& labels)
{
  MetricsText text(labels);
  text.beginFamily("pcl_ext_merged_frames_total", counter, "Merged frames.");
  text.add(number(counts.made));
  text.beginFamily("pcl_ext_merged_frames_left_out_total",
                   counter,
                   "Merged frames left out, as the machine was too slow.");
  text.add(number(counts.left_out));
  return text.text();
}

std::string
mapMetrics(const MapCounts& counts, const MetricLabels& labels)
{
  MetricsText text(labels);
  text.beginFamily(
      "pcl_ext_map_updates_total", counter, "How often the map got the latest frames.");
  text.add(number(counts.made));
  text.beginFamily("pcl_ext_map_updates_left_out_total",
                   counter,
                   "Updates of the map left out, as the machine was too slow.");
  text.add(number(counts.left_out));
  return text.text();
}

std::string
senderMetrics(const std::vector<std::pair<std::string, SenderHealth>>& senders,
              Time now,
              const MetricLabels& labels)
{
  MetricsText text(labels);
  for (const Metric<SenderHealth>& metric : sender_metrics) {
    text.beginFamily(
        std::string("pcl_ext_sender_") + metric.name, metric.type, metric.help);
    for (const auto& [name, sender] : senders)
      text.add(metric.value(sender, now), MetricsText::labelOf("stream", name));
  }
  text.beginFamily("pcl_ext_sender_encode_seconds",
                   "histogram",
                   "Computing time of a frame, from the cloud to its bytes.");
  for (const auto& [name, sender] : senders)
    addHistogram(sender.node.encode_times, MetricsText::labelOf("stream", name), text);
  return text.text();
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

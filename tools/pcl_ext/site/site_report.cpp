// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "site/site_report.h"

#include "live/link_output.h"
#include "measuring/markdown_table.h"
#include "options/text_values.h"

#include <algorithm>
#include <cstdint>
#include <set>

namespace pcl_ext::tools {

namespace {

std::string
faultsOf(const link::LinkStreamStatistics& stream)
{
  std::string faults;
  const auto add = [&faults](std::uint64_t count, const std::string& text) {
    if (count > 0)
      faults += ", " + std::to_string(count) + " " + text;
  };
  add(stream.frames_lost, "lost on the way");
  add(stream.frames_dropped, "dropped, as this machine is too slow");
  add(stream.frames_damaged, "with a wrong checksum");
  add(stream.messages_invalid, "left out as not a frame");
  add(stream.frames_skipped, "left out after a gap, until an I-frame came");
  if (stream.frames == 0)
    add(stream.frames_early, "left out, as no I-frame came");
  return faults;
}

/** \brief Prints which messages are not among the frames; false if there are some. */
bool
reportReceived(const SiteFigures& figures, Console& console)
{
  bool is_whole = true;
  const link::SubscriberStatistics& all = figures.received;
  for (const link::LinkStreamStatistics& stream : all.streams) {
    const std::string faults = faultsOf(stream);
    is_whole &= faults.empty();
    if (!faults.empty())
      console.error(stream.name + ": " + counted(stream.frames, "frame") + faults);
    // What they would have brought is there, or counted as lost.
    if (stream.frames_late > 0)
      console.remark(stream.name + ": " + counted(stream.frames_late, "frame") +
                     " late or repeated, which are left out");
    if (stream.publishers > 1)
      console.remark(stream.name + ": its publisher began anew " +
                     counted(stream.publishers - 1, "time") +
                     ", or there are several of them");
  }
  if (all.messages_of_no_stream > 0)
    console.error(counted(all.messages_of_no_stream, "message") +
                  " left out, whose subject names no stream");
  is_whole &= all.messages_of_too_many == 0;
  if (all.messages_of_too_many > 0)
    console.error(counted(all.messages_of_too_many, "message") +
                  " left out, of streams beyond the first " +
                  counted(all.streams.size(), "stream"));
  if (all.violations > 0 || (figures.published && figures.published->violations > 0)) {
    console.error("the server did not permit all that was asked of it");
    is_whole = false;
  }
  return is_whole;
}

/** \brief Prints which frames arrived, but could not be decoded or merged; false if there
 * are some. */
bool
reportDecoded(const SiteFigures& figures, Console& console)
{
  bool is_whole = true;
  std::set<std::string> refused; // streams of which frames were
  for (const nodes::StreamHealth& stream : figures.decoded) {
    if (stream.frames_failed > 0)
      console.error(
          stream.name + ": " + counted(stream.frames_failed, "frame") +
          " could not be decoded, the last one as: " + stream.last_failure.message());
    if (stream.frames_refused > 0) {
      refused.insert(stream.name);
      console.error(stream.name + ": " + counted(stream.frames_refused, "frame") +
                    " refused, as this machine is too slow to decode them");
    }
    if (stream.points_outside_grid > 0)
      console.error(stream.name + ": " + counted(stream.points_outside_grid, "point") +
                    " left out, as outside the grid of voxels of their frames: encode "
                    "with a larger --resolution");
    is_whole &=
        stream.frames_failed + stream.frames_refused + stream.points_outside_grid == 0;
    const auto tell = [&](const std::string& fault) {
      console.error(stream.name + ": " + fault);
      is_whole = false;
    };
    if (!stream.outlier_removal.ok())
      tell("its outliers stay: " + stream.outlier_removal.message());
    for (const std::string& fault : nodes::faultsOfMerging(
             stream, figures.merged_resolution, nodes::MergedFrames::All))
      tell(fault);
  }
  const std::string slowness = slownessOf(figures.merged, figures.has_slow_effort);
  for (const auto& [name, missing] : figures.missing) {
    const auto tell = [&, stream = name](std::size_t count, const std::string& reason) {
      if (count > 0)
        console.error(stream + ": missing in " + std::to_string(count) + " of " +
                      counted(figures.merged.made, "merged frame") + ", as " + reason);
    };
    tell(missing.undecodable, "its last frame could not be decoded");
    tell(missing.dropped, "its voxels were dropped to keep --memory-limit");
    tell(missing.old,
         slowness.empty() && refused.count(name) == 0
             ? "its last frame was older than --merge-age"
             : "this machine is too slow");
  }
  if (!slowness.empty())
    console.error(slowness);
  const std::string slowness_of_map = slownessOf(figures.mapped);
  if (!slowness_of_map.empty())
    console.error(slowness_of_map);
  return is_whole && slowness.empty() && slowness_of_map.empty();
}

} // namespace

LiveFigures
liveFiguresOf(const SiteFigures& figures)
{
  LiveFigures live;
  const link::SubscriberStatistics& all = figures.received;
  live.is_connected = all.is_connected;
  std::uint64_t lost = 0;
  std::uint64_t left_out = 0;
  for (const link::LinkStreamStatistics& stream : all.streams) {
    live.frames += stream.frames;
    live.bytes += stream.bytes;
    lost += stream.frames_lost + stream.frames_dropped + stream.frames_damaged;
    left_out += stream.frames_skipped;
    if (stream.age)
      live.age = std::max(live.age.value_or(*stream.age), *stream.age);
  }
  live.rest = " of " + counted(all.streams.size(), "stream");
  if (lost > 0)
    live.rest += ", " + std::to_string(lost) + " lost";
  if (left_out > 0)
    live.rest += ", " + std::to_string(left_out) + " left out";
  if (figures.published)
    live.rest += ", " + std::to_string(figures.merged.made) + " merged";
  if (figures.merged.left_out > 0)
    live.rest += ", " + std::to_string(figures.merged.left_out) +
                 " not: this machine is too slow";
  if (figures.mapped.left_out > 0)
    live.rest +=
        ", " + std::to_string(figures.mapped.left_out) + " updates of the map left out";
  return live;
}

std::string
slownessOf(const nodes::MergeCounts& merged, bool has_slow_effort)
{
  if (merged.left_out == 0)
    return {};
  return "this machine is too slow for these streams: " +
         std::to_string(merged.left_out) + " of " +
         counted(merged.left_out + merged.made, "merged frame") +
         " left out; take a longer --merge-period, " +
         (has_slow_effort ? "a faster --effort here or where the streams are sent, "
                          : "") +
         "a larger --resolution where they are sent, or several centres (--partition)";
}

std::string
slownessOf(const nodes::MapCounts& mapped)
{
  if (mapped.left_out == 0)
    return {};
  return "the map got " + std::to_string(mapped.made) + " of " +
         counted(mapped.made + mapped.left_out, "update") +
         ": this machine is too slow for a map of this resolution; take a larger "
         "--resolution, or fewer streams (--streams, --partition)";
}

bool
report(const SiteFigures& figures, Console& console)
{
  bool is_whole = reportReceived(figures, console);
  is_whole &= reportDecoded(figures, console);
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;
  std::uint64_t early = 0;
  for (const link::LinkStreamStatistics& stream : figures.received.streams) {
    frames += stream.frames;
    bytes += stream.bytes;
    early += stream.frames_early;
  }
  constexpr double megabyte = 1e6;
  std::string line = "site " + figures.site + ": " + counted(frames, "frame") + " of " +
                     counted(figures.received.streams.size(), "stream") + ", " +
                     measuring::formatted(static_cast<double>(bytes) / megabyte, 2) +
                     " MB";
  if (figures.recorded)
    line += "; " + std::to_string(*figures.recorded) + " of them recorded";
  if (early > 0)
    line += "; " + std::to_string(early) + " before the first I-frames left out";
  if (figures.received.replay_pending > 0)
    line +=
        "; " + counted(figures.received.replay_pending, "kept frame") + " not replayed";
  if (figures.published) {
    const link::PublisherStatistics& merged = *figures.published;
    const std::string losses = lossesOf(merged, merged.frames_under_way);
    line += "; " + counted(merged.frames, "merged frame") + losses;
    is_whole &= losses.empty();
  }
  console.summary(line);
  return is_whole;
}

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/commands.h"
#include "commands/recording_figures.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/printable_text.h"
#include "inputs/recording_input.h"
#include "inputs/several_inputs.h"
#include "inputs/standard_input.h"
#include "measuring/markdown_table.h"
#include "options/options.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <ctime>
#include <iostream>
#include <memory>

namespace pcl_ext::tools {

namespace {

using measuring::formatted;
using measuring::MarkdownTable;
using recording::Time;

struct InfoOptions {
  std::vector<std::string> inputs;
  bool is_json = false;
  bool is_quiet = false;
};

std::string
whole(double number)
{
  return formatted(number, 0);
}

/** \brief A date, or seconds for the times of clocks that begin at 0. */
std::string
describeTime(Time time)
{
  constexpr double first_date = 315532800.0; // 1980
  const double seconds = secondsOf(time);
  if (seconds < first_date)
    return formatted(seconds, 3) + " s";
  const auto whole_seconds = static_cast<std::time_t>(time.count() / 1000000000);
  const std::tm* const utc = std::gmtime(&whole_seconds);
  if (utc == nullptr) // only for years that no clock has
    return formatted(seconds, 3) + " s";
  char date[40];
  std::strftime(date, sizeof(date), "%Y-%m-%d %H:%M:%S", utc);
  char text[60];
  std::snprintf(text,
                sizeof(text),
                "%s.%03d UTC",
                date,
                static_cast<int>(time.count() / 1000000 % 1000));
  return text;
}

/** \brief What is known about a recording as a whole. */
struct RecordingSummary {
  std::uint64_t file_bytes = 0;
  std::size_t frames = 0;
  bool has_times = false;
  Time from{0};
  Time to{0};
  bool is_unfinished = false;
  std::vector<recording::RecordingDamage> damage;
  /** \brief Topics that are no streams, and what type their messages have. */
  std::vector<std::pair<std::string, std::string>> other_topics;
};

/** \brief Topics without frames, with their types. Their messages are not indexed. */
std::vector<std::pair<std::string, std::string>>
otherTopics(RecordingInput& input)
{
  std::vector<std::pair<std::string, std::string>> topics;
  recording::BagReader bag;
  const auto isWanted = [](const recording::McapChannel&) { return false; };
  if (!recording::BagReader::isBag(input.path()) ||
      !bag.open(input.path(), isWanted).ok())
    return topics;
  const std::vector<recording::RecordedStream>& streams = input.reader().streams();
  for (std::size_t i = 0; i < bag.channels().size(); ++i)
    if (std::none_of(streams.begin(), streams.end(), [i](const auto& stream) {
          return stream.channel == i;
        }))
      topics.emplace_back(bag.channels()[i].topic, bag.channels()[i].schema.name);
  return topics;
}

RecordingSummary
summarize(RecordingInput& input, const std::vector<StreamFigures>& streams)
{
  RecordingSummary summary;
  summary.file_bytes = input.reader().fileBytes();
  bool is_first = true;
  for (const StreamFigures& stream : streams) {
    summary.frames += stream.frames;
    summary.has_times |= stream.has_times;
    if (stream.frames == 0 || !stream.has_times)
      continue;
    summary.from =
        is_first ? stream.first_time : std::min(summary.from, stream.first_time);
    summary.to = is_first ? stream.last_time : std::max(summary.to, stream.last_time);
    is_first = false;
  }
  summary.is_unfinished = input.reader().isUnfinished();
  summary.damage = input.reader().damage();
  summary.other_topics = otherTopics(input);
  return summary;
}

/** \brief What voxels or points have besides their place. */
std::string
describeAttributes(const StreamFigures& stream)
{
  std::string text;
  const auto add = [&text](const std::string& part) {
    text += (text.empty() ? "" : ", ") + part;
  };
  if (stream.intensity_bits > 0)
    add("intensity " + std::to_string(stream.intensity_bits) + " bits");
  if (stream.colour_bits > 0)
    add("colours " + std::to_string(stream.colour_bits) + " bits");
  if (!stream.orders.empty())
    add("points " + stream.orders.describe());
  else if (stream.has_point_counts)
    add("numbers of points");
  for (const io::FieldDescription& field : stream.fields)
    add("field " + printable(field.name));
  return text.empty() ? "-" : text;
}

std::string
orDash(double number, int digits)
{
  return number > 0.0 ? formatted(number, digits) : "-";
}

void
printStreams(const std::vector<StreamFigures>& streams)
{
  MarkdownTable table({"stream",
                       "frames",
                       "I-frames",
                       "lost",
                       "rate Hz",
                       "voxels",
                       "points",
                       "bytes",
                       "bytes each",
                       "edge m",
                       "format",
                       "with",
                       "frame_id"});
  for (const StreamFigures& stream : streams) {
    std::string edge = "-";
    if (stream.resolution > 0.0) {
      std::ostringstream text;
      text << stream.resolution << (stream.has_one_resolution ? "" : " (varies)");
      edge = text.str();
    }
    std::string coding =
        stream.hasIFrame() ? nameOf(io::stream_formats, stream.format) : "unknown";
    if (stream.hasIFrame() && stream.format == io::StreamFormat::Version1)
      coding += std::string(" ") + nameOf(io::efforts, stream.effort);
    table.addRow({printable(stream.name),
                  whole(static_cast<double>(stream.frames)),
                  whole(static_cast<double>(stream.i_frames)),
                  whole(static_cast<double>(stream.missing + stream.unreadable)),
                  orDash(stream.rate(), 1),
                  orDash(stream.meanVoxels(), 0),
                  orDash(stream.meanPointsInOrder(), 0),
                  whole(stream.meanBytes()),
                  orDash(stream.bytesOfEach(), 3),
                  edge,
                  coding,
                  describeAttributes(stream),
                  stream.frame_id.empty() ? "-" : printable(stream.frame_id)});
  }
  table.print(std::cout);
  std::cout
      << "voxels, bytes: means of a frame; points: in order, of frames that have these "
         "and no voxels.\n-: none, or not known without decoding, as voxels of the "
         "published "
         "layout.\nbytes each: of a voxel or such a point. lost: missing by the "
         "frames' numbers, or unreadable.\n";
}

void
printTable(const std::string& name,
           const RecordingSummary& summary,
           const std::vector<StreamFigures>& streams)
{
  std::cout << printable(name) << ": " << whole(static_cast<double>(summary.file_bytes))
            << " bytes, " << counted(streams.size(), "stream") << ", "
            << counted(summary.frames, "frame");
  if (summary.has_times)
    std::cout << ", " << formatted(secondsOf(summary.to - summary.from), 3)
              << " s from " << describeTime(summary.from) << " to "
              << describeTime(summary.to);
  std::cout << '\n';
  if (summary.is_unfinished)
    std::cout << "unfinished: the recorder did not end in an orderly way; all whole "
                 "frames were found\n";
  std::cout << '\n';
  printStreams(streams);
  for (std::size_t i = 0; i < summary.other_topics.size(); ++i)
    std::cout << (i == 0 ? "other topics: " : ", ")
              << printable(summary.other_topics[i].first + " (" +
                           summary.other_topics[i].second + ')')
              << (i + 1 == summary.other_topics.size() ? "\n" : "");
  for (const recording::RecordingDamage& place : summary.damage)
    std::cout << "damage: " << printable(describe(place)) << '\n';
}

nlohmann::ordered_json
toJson(const StreamFigures& stream)
{
  const double bytes_of_each = stream.bytesOfEach();
  nlohmann::ordered_json json = {{"name", stream.name},
                                 {"frames", stream.frames},
                                 {"i_frames", stream.i_frames},
                                 {"missing_frames", stream.missing},
                                 {"unreadable_frames", stream.unreadable}};
  if (stream.has_times) {
    json["first_time_ns"] = stream.first_time.count();
    json["last_time_ns"] = stream.last_time.count();
    json["rate_hz"] = stream.rate();
  }
  json["bytes"] = stream.bytes;
  json["mean_frame_bytes"] = stream.meanBytes();
  if (stream.tellsSizes())
    json["mean_frame_voxels"] = stream.meanVoxels();
  json["mean_frame_points_in_order"] = stream.meanPointsInOrder();
  if (bytes_of_each > 0.0)
    json[stream.voxels == 0 ? "bytes_per_point" : "bytes_per_voxel"] = bytes_of_each;
  json["resolution_m"] = stream.resolution;
  json["has_one_resolution"] = stream.has_one_resolution;
  if (stream.hasIFrame())
    json["format"] = nameOf(io::stream_formats, stream.format);
  if (stream.hasIFrame() && stream.format == io::StreamFormat::Version1)
    json["effort"] = nameOf(io::efforts, stream.effort);
  json["intensity_bits"] = stream.intensity_bits;
  json["colour_bits"] = stream.colour_bits;
  json["has_point_counts"] = stream.has_point_counts;
  json["scan"] = {{"width", stream.scan.width},
                  {"height", stream.scan.height},
                  {"is_organised", stream.is_organised},
                  {"is_row_by_row", stream.is_row_by_row},
                  {"is_one_order", stream.orders.areOne()}};
  json["fields"] = nlohmann::ordered_json::array();
  for (const io::FieldDescription& field : stream.fields)
    json["fields"].push_back({{"name", printable(field.name)},
                              {"type", nameOf(io::field_types, field.type)},
                              {"count", field.count},
                              {"step", field.step}});
  json["frame_id"] = stream.frame_id;
  return json;
}

nlohmann::ordered_json
toJson(const std::string& name,
       const RecordingSummary& summary,
       const std::vector<StreamFigures>& streams)
{
  nlohmann::ordered_json json = {{"file", name},
                                 {"file_bytes", summary.file_bytes},
                                 {"frames", summary.frames},
                                 {"is_unfinished", summary.is_unfinished}};
  if (summary.has_times) {
    json["first_time_ns"] = summary.from.count();
    json["last_time_ns"] = summary.to.count();
    json["duration_s"] = secondsOf(summary.to - summary.from);
  }
  json["streams"] = nlohmann::ordered_json::array();
  for (const StreamFigures& stream : streams)
    json["streams"].push_back(toJson(stream));
  json["other_topics"] = nlohmann::ordered_json::array();
  for (const auto& [topic, type] : summary.other_topics)
    json["other_topics"].push_back({{"topic", topic}, {"type", type}});
  json["damage"] = nlohmann::ordered_json::array();
  for (const recording::RecordingDamage& place : summary.damage)
    json["damage"].push_back({{"file", shown(place.file)},
                              {"offset", place.offset},
                              {"message", place.message}});
  return json;
}

int
info(const InfoOptions& options)
{
  Console console("info", options.is_quiet);
  auto json = nlohmann::ordered_json::array();
  bool is_first = true;
  const int status =
      forEachInput(options.inputs, console, [&](const std::string& path) {
        RecordingInput input(path);
        const std::vector<StreamFigures> streams = figuresOf(input, console);
        const RecordingSummary summary = summarize(input, streams);
        if (options.is_json)
          json.push_back(toJson(path, summary, streams));
        else {
          std::cout << (is_first ? "" : "\n");
          printTable(path, summary, streams);
        }
        is_first = false;
        const bool is_damaged =
            !summary.damage.empty() ||
            std::any_of(
                streams.begin(), streams.end(), [](const StreamFigures& stream) {
                  return stream.missing + stream.unreadable > 0;
                });
        return is_damaged ? something_failed : all_done;
      });
  // Names may have any bytes.
  if (options.is_json)
    std::cout << (options.inputs.size() == 1 ? json.front() : json)
                     .dump(2, ' ', false, nlohmann::json::error_handler_t::replace)
              << '\n';
  return status;
}

} // namespace

Run
addInfo(CLI::App& app)
{
  const auto options = std::make_shared<InfoOptions>();
  addInput(app, options->inputs, "recordings; - is standard input");
  app.add_flag("--json",
               options->is_json,
               "for programs; times in nanoseconds; of several recordings a list");
  addQuiet(app, options->is_quiet);
  return [options] { return info(*options); };
}

} // namespace pcl_ext::tools

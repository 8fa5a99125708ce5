// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/recording_input.h"

#include "clouds/cloud_files.h"
#include "console/exit_status.h"
#include "inputs/other_messages.h"
#include "inputs/point_cloud_conversions.h"
#include "inputs/standard_input.h"
#include "measuring/markdown_table.h"
#include "options/options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <tuple>

namespace pcl_ext::tools {

namespace {

using recording::RecordedStream;
using recording::RecordingStatus;
using recording::Time;

/** \brief Seconds as a time, at most those of a century. */
Time
timeOfSeconds(double seconds)
{
  constexpr double most = 3e9;
  return Time(std::llround(1e9 * std::clamp(seconds, -most, most)));
}

bool
hasTimes(const std::vector<RecordedStream>& streams)
{
  return std::any_of(streams.begin(), streams.end(), [](const RecordedStream& stream) {
    return stream.has_times;
  });
}

Time
endOf(const std::vector<RecordedStream>& streams)
{
  Time end = streams.front().last_time;
  for (const RecordedStream& stream : streams)
    end = std::max(end, stream.last_time);
  return end;
}

/** \brief True if a user means a stream: by its name, or by that of its clouds' topic,
 * with the slash at its beginning or without. */
bool
isMeant(const std::string& given, const std::string& stream)
{
  const std::string slash = given.empty() || given.front() != '/' ? "/" : "";
  return given == stream || given == topicOf(stream) || slash + given == stream ||
         slash + given == topicOf(stream);
}

void
checkStreams(const Selection& selection, const RecordingInput& input, std::size_t count)
{
  for (const std::string& name : selection.streams) {
    std::string known;
    bool is_known = false;
    for (std::size_t stream = 0; stream < count; ++stream) {
      is_known |= isMeant(name, input.nameOf(stream));
      known += (known.empty() ? "" : ", ") + input.nameOf(stream);
    }
    if (!is_known)
      throw UsageError("--streams: there is no '" + name + "'; there are " + known);
  }
}

/** \brief What to do with a file that is no recording. */
std::string
adviceOn(const std::string& path, const RecordingStatus& status)
{
  if (std::filesystem::is_directory(path))
    return "; a folder is a recording if it has metadata.yaml, as rosbag2 writes it; "
           "'pcl_ext encode' makes a recording of a folder of clouds";
  if (status.code() != recording::RecordingCode::NotARecording)
    return {};
  const std::string advice = "'pcl_ext encode' makes a recording of it";
  const bool is_told = status.message().find(advice) != std::string::npos;
  return !is_told && clouds::isCloud(clouds::kindOf(path)) ? "; " + advice : "";
}

} // namespace

std::string
describe(const recording::RecordingDamage& damage)
{
  return shown(damage.file) +
         (damage.offset > 0 ? ", byte " + std::to_string(damage.offset) : "") + ": " +
         damage.message;
}

void
addSelection(CLI::App& app, Selection& selection)
{
  app.add_option_function<std::string>(
         "--frames",
         [&selection](const std::string& text) {
           selection.frames = parseFrames(text);
         },
         "frames A to B - 1 of each stream, from 0; A alone: that one")
      ->type_name("A:B");
  const auto addSeconds =
      [&app](const char* name, std::optional<double>& seconds, const char* text) {
        app.add_option_function<std::string>(
               name,
               [name, &seconds](const std::string& given) {
                 const std::vector<double> numbers =
                     parseNumbers(std::string(name).substr(2), given);
                 if (numbers.size() != 1 || numbers[0] < 0.0)
                   throw UsageError(std::string(name) +
                                    " is a number of seconds, 0 or more");
                 seconds = numbers[0];
               },
               text)
            ->type_name("SECONDS");
      };
  addSeconds("--from", selection.from, "from the start of the recording");
  addSeconds("--to", selection.to, "frames at that time are left out");
  addNames(app, "--streams", selection.streams, "only these, with commas between them");
}

RecordingInput::RecordingInput(const std::string& path) : path_(pathOfInput(path))
{
  if (const RecordingStatus status = reader_.open(path_); !status.ok())
    throw std::runtime_error(status.message() + adviceOn(path_, status));
  if (path_ != path && !recording::BagReader::isBag(path_))
    nameStream(streamNameOfInput(path));
  select(Selection());
}

std::string
RecordingInput::shownPath() const
{
  return shown(path_);
}

RecordingInput
RecordingInput::openBag(const std::string& path)
{
  RecordingInput input(path);
  if (recording::BagReader::isBag(input.path_)) {
    input.bag_.emplace();
    if (const RecordingStatus status = input.bag_->open(input.path_); !status.ok())
      throw std::runtime_error(status.message());
    input.indexBag();
    input.select(Selection());
  }
  return input;
}

void
RecordingInput::indexBag()
{
  const std::vector<RecordedStream>& streams = reader_.streams();
  stream_of_channel_.assign(bag_->channels().size(), none);
  for (std::size_t stream = 0; stream < streams.size(); ++stream)
    stream_of_channel_[streams[stream].channel] = stream;
  messages_.resize(streams.size());
  for (std::size_t i = 0; i < bag_->index().size(); ++i) {
    const std::size_t stream = stream_of_channel_[bag_->index()[i].channel];
    (stream == none ? others_ : messages_[stream]).push_back(i);
  }
  // The frames of a stream are numbered in the order of the file, see RecordingReader.
  const std::vector<recording::BagEntry>& index = bag_->index();
  for (std::vector<std::size_t>& messages : messages_)
    std::stable_sort(
        messages.begin(), messages.end(), [&index](std::size_t a, std::size_t b) {
          return std::tie(index[a].chunk, index[a].offset) <
                 std::tie(index[b].chunk, index[b].offset);
        });
}

Time
RecordingInput::start() const
{
  Time start = reader_.streams().front().first_time;
  for (const RecordedStream& stream : reader_.streams())
    if (stream.frames > 0)
      start = std::min(start, stream.first_time);
  return start;
}

RecordingInput::Range
RecordingInput::rangeOf(std::size_t stream, const Selection& selection)
{
  const RecordedStream& recorded = reader_.streams()[stream];
  const std::string& name = nameOf(stream);
  const bool is_chosen =
      selection.streams.empty() ||
      std::any_of(selection.streams.begin(),
                  selection.streams.end(),
                  [&name](const std::string& given) { return isMeant(given, name); });
  if (!is_chosen)
    return {};
  // The number of frames before a time.
  const auto framesBefore = [&](double seconds) {
    const std::optional<std::size_t> last =
        reader_.frameAt(stream, start() + timeOfSeconds(seconds) - Time(1));
    return last ? *last + 1 : 0;
  };
  Range range;
  range.is_of_named = true;
  range.wanted = std::min(selection.frames.begin, recorded.frames);
  range.end = std::min(selection.frames.end, recorded.frames);
  if (selection.from)
    range.wanted = std::max(range.wanted, framesBefore(*selection.from));
  if (selection.to)
    range.end = std::min(range.end, framesBefore(*selection.to));
  range.end = std::max(range.wanted, range.end);
  range.begin = range.wanted == 0 || range.wanted == range.end
                    ? range.wanted
                    : reader_.iFrameBefore(stream, range.wanted);
  range.next = range.begin;
  return range;
}

void
RecordingInput::select(const Selection& selection)
{
  const std::vector<RecordedStream>& streams = reader_.streams();
  checkStreams(selection, *this, streams.size());
  if ((selection.from || selection.to) && !hasTimes(streams))
    throw UsageError("--from and --to: the frames of '" + shownPath() +
                     "' have no times; choose with --frames");
  if (selection.from && selection.to && *selection.from >= *selection.to)
    throw UsageError("--from must be less than --to, and is not");
  ranges_.clear();
  for (std::size_t stream = 0; stream < streams.size(); ++stream)
    ranges_.push_back(rangeOf(stream, selection));
  if (selection.hasRange() && wantedFrames() == 0) {
    std::size_t most = 0;
    for (const RecordedStream& stream : streams)
      most = std::max(most, stream.frames);
    std::string remedy = (streams.size() > 1 ? "its longest stream has " : "it has ") +
                         counted(most, "frame");
    if (hasTimes(streams))
      remedy += " and takes " +
                measuring::formatted(secondsOf(endOf(streams) - start()), 3) + " s";
    throw UsageError("no frame of '" + shownPath() +
                     "' is in --frames, --from and --to: " + remedy);
  }
  selectOthers(selection);
}

void
RecordingInput::selectOthers(const Selection& selection)
{
  next_other_ = 0;
  chosen_others_ = others_;
  others_begin_ = Time::min();
  if (!bag_ || !selection.hasRange())
    return;
  // With a choice by numbers, from the frames that were chosen to those after them: where
  // a part ends, the next one begins.
  Time from = Time::max();
  Time to = Time::min();
  bool has_first = true; // frames of the streams
  bool has_last = true;
  for (std::size_t stream = 0; stream < ranges_.size(); ++stream) {
    const Range& range = ranges_[stream];
    if (!range.is_of_named)
      continue;
    const bool is_last = range.end == reader_.streams()[stream].frames;
    has_first &= range.wanted == 0;
    has_last &= is_last;
    if (range.wanted == range.end)
      continue;
    from = std::min(from, reader_.timeOf(stream, range.wanted));
    to = std::max(to,
                  is_last ? reader_.timeOf(stream, range.end - 1) + Time(1)
                          : reader_.timeOf(stream, range.end));
  }
  if (has_first)
    from = Time::min();
  else if (selection.from && selection.frames.begin == 0)
    from = start() + timeOfSeconds(*selection.from);
  if (has_last)
    to = Time::max();
  else if (selection.to && selection.frames.end == FrameRange().end)
    to = start() + timeOfSeconds(*selection.to);
  chosen_others_ = othersOfPart(*bag_, others_, from, to);
  others_begin_ = from;
}

std::size_t
RecordingInput::size() const
{
  std::size_t items = chosen_others_.size() - next_other_;
  for (const Range& range : ranges_)
    items += range.end - range.next;
  return items;
}

std::size_t
RecordingInput::wantedFrames() const
{
  std::size_t frames = 0;
  for (const Range& range : ranges_)
    frames += range.end - range.wanted;
  return frames;
}

bool
RecordingInput::next(Item& item)
{
  item = Item();
  std::size_t earliest = none;
  for (std::size_t stream = 0; stream < ranges_.size(); ++stream) {
    const Range& range = ranges_[stream];
    if (range.next >= range.end)
      continue;
    const Time time = reader_.timeOf(stream, range.next);
    if (earliest == none || time < item.time) {
      earliest = stream;
      item.time = time;
    }
  }
  if (next_other_ < chosen_others_.size()) {
    const std::size_t message = chosen_others_[next_other_];
    const bool is_earlier = bag_->index()[message].log_time < others_begin_;
    const Time time = is_earlier ? others_begin_ : bag_->index()[message].log_time;
    // In the order of the file.
    if (earliest == none || time < item.time || (time == item.time && is_earlier)) {
      item.message = message;
      item.time = time;
      ++next_other_;
      return true;
    }
  }
  if (earliest == none)
    return false;
  Range& range = ranges_[earliest];
  item.is_frame = true;
  item.stream = earliest;
  item.number = range.next++;
  item.is_wanted = item.number >= range.wanted;
  if (bag_ && item.number < messages_[earliest].size()) {
    item.message = messages_[earliest][item.number];
    const std::size_t channel = reader_.streams()[earliest].channel;
    item.has_message =
        messages_[earliest].size() == reader_.streams()[earliest].frames &&
        encodingOf(bag_->channels()[channel]) == recording::MessageEncoding::Cdr;
  }
  return true;
}

RecordingStatus
RecordingInput::read(const Item& item, recording::RecordedFrame& frame)
{
  return reader_.read(item.stream, item.number, frame);
}

RecordingStatus
RecordingInput::read(const Item& item, recording::McapMessage& message)
{
  RecordingStatus status = bag_->read(bag_->index()[item.message], message);
  if (!item.is_frame)
    message.log_time = item.time;
  return status;
}

std::vector<std::string>
RecordingInput::damage() const
{
  std::vector<std::string> lines;
  for (const recording::RecordingDamage& place : reader_.damage())
    lines.push_back(describe(place));
  return lines;
}

std::string
RecordingInput::unfinishedRemark() const
{
  return reader_.isUnfinished()
             ? shown(path_) + " was not finished, as after a power failure; all whole "
                              "frames were found"
             : std::string();
}

} // namespace pcl_ext::tools

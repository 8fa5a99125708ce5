// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/copied_streams.h"

#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "inputs/other_messages.h"
#include "outputs/output_path.h"

#include <algorithm>

namespace pcl_ext::tools {

using recording::McapChannel;
using recording::RecordedStream;

namespace {

bool
areSame(const McapChannel& first, const McapChannel& second)
{
  return first.topic == second.topic &&
         first.message_encoding == second.message_encoding &&
         first.schema.name == second.schema.name &&
         first.schema.encoding == second.schema.encoding &&
         first.schema.text == second.schema.text && first.metadata == second.metadata;
}

/** \brief Whether messages of a channel are the same, whenever they were recorded. */
bool
areSame(const recording::McapMessage& first, const recording::McapMessage& second)
{
  return first.sequence == second.sequence &&
         first.publish_time == second.publish_time && first.bytes == second.bytes;
}

} // namespace

std::string
topicName(const std::string& prefix, const std::string& name)
{
  return prefix + (name.empty() || name.front() != '/' ? "/" : "") + name;
}

CopiedStreams::CopiedStreams(const Output& output,
                             bool is_bag,
                             const recording::BagReader* bag,
                             Console& console)
: path_(output.path)
, console_(console)
, failures_([&console](const std::string& line) { console.error(line); })
, output_(output, is_bag, bag != nullptr ? bag->profile() : "ros2")
{}

void
CopiedStreams::addInput(RecordingInput& recording, const std::string& prefix)
{
  Input input{&recording, {}, {}};
  const std::vector<RecordedStream>& streams = recording.reader().streams();
  for (std::size_t stream = 0; stream < streams.size(); ++stream) {
    if (!recording.isChosen(stream)) {
      input.streams.push_back(std::nullopt);
      continue;
    }
    const std::string name = topicName(prefix, recording.nameOf(stream));
    const auto known =
        std::find_if(streams_.begin(), streams_.end(), [&name](const Stream& other) {
          return other.name == name;
        });
    input.streams.push_back(known != streams_.end()
                                ? static_cast<std::size_t>(known - streams_.begin())
                                : addStream(input, stream, name));
  }
  if (recording.bag() != nullptr && output_.isBag())
    for (std::size_t i = 0; i < recording.bag()->channels().size(); ++i)
      input.channels.push_back(
          recording.isStream(i)
              ? std::nullopt
              : std::optional(numberOfChannel(recording.bag()->channels()[i])));
  inputs_.push_back(std::move(input));
}

std::size_t
CopiedStreams::numberOfChannel(const McapChannel& channel)
{
  const auto known =
      std::find_if(channels_.begin(), channels_.end(), [&channel](const auto& other) {
        return areSame(other.first, channel);
      });
  if (known != channels_.end())
    return known->second;
  const std::size_t number =
      output_.addChannel(channel, recording::McapChunking::Shared);
  channels_.emplace_back(channel, number);
  latched_[number].most = latchedMessages(channel);
  return number;
}

std::size_t
CopiedStreams::addStream(const Input& input,
                         std::size_t stream,
                         const std::string& name)
{
  const RecordedStream& recorded = input.recording->reader().streams()[stream];
  Stream added;
  added.name = name;
  if (input.recording->bag() != nullptr && output_.isBag() &&
      encodingOf(input.recording->bag()->channels()[recorded.channel]) ==
          recording::MessageEncoding::Cdr) {
    McapChannel channel = input.recording->bag()->channels()[recorded.channel];
    channel.topic = name;
    channel.metadata = input.recording->metadataOf(stream);
    added.number = output_.addChannel(channel, recording::McapChunking::OwnStream);
  }
  else {
    recording::RecordedFrame first;
    input.recording->reader().read(stream, 0, first);
    added.number =
        output_.addStream({name, first.frame_id, input.recording->metadataOf(stream)});
  }
  streams_.push_back(added);
  return streams_.size() - 1;
}

void
CopiedStreams::copy(std::size_t input, const RecordingInput::Item& item)
{
  if (item.is_frame) {
    copyFrame(input, item);
    return;
  }
  left_out_ += output_.isBag() ? 0 : 1;
  if (!output_.isBag() || !inputs_[input].recording->read(item, message_).ok())
    return; // What cannot be read is part of the damage.
  message_.channel = inputs_[input].channels[message_.channel].value();
  copyMessage(input);
}

bool
CopiedStreams::repeatsLatched()
{
  auto& [most, copied] = latched_[message_.channel];
  if (most == 0)
    return false;
  for (const recording::McapMessage& other : copied)
    if (areSame(other, message_))
      return other.log_time < message_.log_time;
  if (copied.size() == most)
    copied.erase(copied.begin());
  copied.push_back(message_);
  return false;
}

void
CopiedStreams::copyMessage(std::size_t input)
{
  if (inputs_.size() > 1 && repeatsLatched()) {
    ++common_messages_;
    return;
  }
  if (!seen_.empty() && seen_.front().message.log_time != message_.log_time)
    seen_.clear();
  if (inputs_.size() > 1) {
    auto known = std::find_if(seen_.begin(), seen_.end(), [this](const auto& other) {
      return other.message.channel == message_.channel &&
             areSame(other.message, message_);
    });
    if (known == seen_.end())
      known =
          seen_.insert(known, {message_, 0, std::vector<std::size_t>(inputs_.size())});
    // One input may have several that are the same.
    if (++known->seen[input] <= known->written) {
      ++common_messages_;
      return;
    }
    ++known->written;
  }
  output_.write(message_);
  ++other_messages_;
}

void
CopiedStreams::lose(const Input& input,
                    const RecordingInput::Item& item,
                    const std::string& reason)
{
  ++lost_;
  failures_.add(input.recording->shownPath() + ", " +
                    input.recording->nameOf(item.stream),
                item.number,
                " at byte " + std::to_string(frame_.offset),
                reason);
}

void
CopiedStreams::copyFrame(std::size_t number, const RecordingInput::Item& item)
{
  const Input& input = inputs_[number];
  Stream& stream = streams_[*input.streams[item.stream]];
  const auto read = input.recording->read(item, frame_);
  if (!read.ok() || !frame_.description.status.ok()) {
    stream.chain.breakOff();
    lose(input, item, read.ok() ? frame_.description.status.message() : read.message());
    return;
  }
  if (stream.input != number)
    stream.chain.breakOff();
  stream.input = number;
  using Place = io::FrameChain::Place;
  const Place place =
      stream.chain.take(frame_.description, frame_.bytes.data(), frame_.bytes.size());
  if (place != Place::Next) {
    lose(input,
         item,
         place == Place::Damaged
             ? "its checksum is wrong"
             : "it needs a frame before it that is not in the recording");
    return;
  }
  ++frames_;
  leading_frames_ += item.is_wanted ? 0 : 1;
  if (item.has_message && output_.isBag()) {
    throwUnlessOk(input.recording->read(item, message_));
    message_.channel = stream.number;
    output_.copy(message_, frame_.description.is_i_frame);
    return;
  }
  written_.message.log_time = written_.message.publish_time = frame_.time;
  written_.message.sequence = static_cast<std::uint32_t>(item.number);
  written_.cloud.stamp = frame_.stamp;
  written_.cloud.frame_id = frame_.frame_id;
  written_.bytes.swap(frame_.bytes);
  output_.write(stream.number, written_);
}

int
CopiedStreams::finish()
{
  failures_.finish();
  console_.endProgress();
  bool is_damaged = false;
  for (const Input& input : inputs_) {
    for (const std::string& place : input.recording->damage()) {
      console_.error(place);
      is_damaged = true;
    }
    if (const std::string remark = input.recording->unfinishedRemark(); !remark.empty())
      console_.remark(remark);
    if (input.recording->bag() != nullptr)
      output_.copyExtras(*input.recording->bag());
  }
  if (frames_ == 0)
    throw std::runtime_error("no frame could be copied; '" + path_ +
                             "' was not written");
  if (common_messages_ > 0)
    console_.remark("the recordings have " +
                    counted(common_messages_, "other message") +
                    " in common, copied once");
  if (const std::string left_out = output_.describeLeftOut(left_out_);
      !left_out.empty())
    console_.remark(left_out);
  const std::string interruption = output_.finish();
  std::string line = path_ + ": " + counted(frames_, "frame") + " of " +
                     counted(streams_.size(), "stream");
  if (leading_frames_ > 0)
    line +=
        ", " + counted(leading_frames_, "frame") +
        " of these before the first ones asked for, from I-frames on, without which "
        "those cannot be decoded";
  if (other_messages_ > 0)
    line += ", " + counted(other_messages_, "other message");
  if (lost_ > 0)
    line += ", " + counted(lost_, "frame") + " lost";
  console_.summary(line + interruption);
  if (isInterrupted())
    return interrupted;
  return lost_ > 0 || is_damaged ? something_failed : all_done;
}

} // namespace pcl_ext::tools

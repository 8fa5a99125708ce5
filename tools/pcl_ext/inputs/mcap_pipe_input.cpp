// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/bag_input.h"
#include "inputs/other_messages.h"
#include "inputs/recording_input.h"
#include "inputs/standard_input.h"
#include "outputs/frame_output.h"
#include "recording/mcap_stream.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <utility>

namespace pcl_ext::tools {

namespace {

using recording::McapChannel;
using recording::McapMessage;
using recording::McapStream;

/** \brief An MCAP file that comes through a pipe: its contents as they come. */
class McapPipe : public BagInput {
public:
  McapPipe(recording::Descriptor descriptor,
           const std::string& name,
           const InputOptions& options)
  : BagInput(options)
  , descriptor_(std::move(descriptor))
  , name_(name)
  , stream_(
        [this](std::uint8_t* bytes, std::size_t count) {
          if (before_waiting_ && mustWaitFor(descriptor_.get()))
            before_waiting_();
          return readPipe(descriptor_.get(), bytes, count);
        },
        name)
  {
    // The profile is known then.
    advance();
  }

  std::size_t
  size() const override
  {
    return 0;
  }

  std::string
  profile() const override
  {
    return stream_.profile();
  }

  const std::vector<McapChannel>&
  channels() const override
  {
    return stream_.channels();
  }

  std::vector<std::string>
  damage() const override
  {
    std::vector<std::string> lines;
    if (!isInterrupted())
      for (const recording::RecordingDamage& place : stream_.damage())
        lines.push_back(describe(place));
    if (topics_.empty())
      lines.push_back(whyNoClouds(name_, channels()));
    try {
      checkTopics(options_.topics, topics_);
    }
    catch (const UsageError& error) {
      lines.push_back(error.what());
    }
    return lines;
  }

  bool
  isLive() const override
  {
    return true;
  }

  void
  setBeforeWaiting(std::function<void()> action) override
  {
    before_waiting_ = std::move(action);
  }

  Found
  next(InputCloud& cloud, McapMessage& other) override
  {
    while (wantsMore()) {
      if (!is_at_hand_)
        advance();
      is_at_hand_ = false;
      if (found_ == McapStream::Found::End)
        return Found::End;
      if (found_ != McapStream::Found::Message)
        return Found::Extra;
      const std::size_t stream = stream_of_channel_[stream_.message().channel];
      if (stream == none) {
        if (!hasBegun()) {
          hold();
          continue;
        }
        std::swap(other, stream_.message());
        return Found::OtherMessage;
      }
      if (clouds_[stream] >= options_.frames.begin && !held_.empty()) {
        std::swap(other, held_.front());
        other.log_time = stream_.message().log_time;
        held_.pop_front();
        is_at_hand_ = true;
        return Found::OtherMessage;
      }
      if (!count(stream, cloud))
        continue;
      std::swap(cloud.message, stream_.message());
      readNext(channels()[cloud.message.channel], cloud);
      return Found::Cloud;
    }
    return Found::End;
  }

  void
  copyExtra(FrameOutput& output) override
  {
    if (found_ == McapStream::Found::Metadata)
      output.write(stream_.metadata());
    else
      output.write(stream_.attachment());
  }

private:
  /** \brief Whether a first one of the wanted clouds was met. */
  bool
  hasBegun() const
  {
    const std::size_t begin = options_.frames.begin;
    return begin == 0 ||
           std::any_of(clouds_.begin(), clouds_.end(), [begin](std::size_t clouds) {
             return clouds > begin;
           });
  }

  /** \brief Keeps a message until then, if it is a latched one. */
  void
  hold()
  {
    const std::size_t channel = stream_.message().channel;
    const std::size_t most = latchedMessages(channels()[channel]);
    if (most == 0)
      return;
    const auto isOfChannel = [channel](const McapMessage& message) {
      return message.channel == channel;
    };
    const auto held = std::count_if(held_.begin(), held_.end(), isOfChannel);
    if (static_cast<std::size_t>(held) == most)
      held_.erase(std::find_if(held_.begin(), held_.end(), isOfChannel));
    held_.push_back(std::move(stream_.message()));
  }

  void
  advance()
  {
    found_ = stream_.next();
    is_at_hand_ = true;
    addChannels(stream_.channels());
  }

  recording::Descriptor descriptor_;
  std::string name_;
  std::function<void()> before_waiting_;
  McapStream stream_;
  McapStream::Found found_ = McapStream::Found::End;
  bool is_at_hand_ = false; // it was found, and not taken yet
  std::deque<McapMessage> held_;
};

} // namespace

std::unique_ptr<CloudInput>
openMcapPipe(recording::Descriptor descriptor,
             const std::string& name,
             const InputOptions& options)
{
  return std::make_unique<McapPipe>(std::move(descriptor), name, options);
}

} // namespace pcl_ext::tools

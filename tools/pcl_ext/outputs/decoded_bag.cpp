// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/decoded_bag.h"

#include <pcl_ext/nodes/impl/message_layouts.h>

#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"
#include "inputs/stream_metadata.h"
#include "outputs/frame_output.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace tools {

using recording::McapChannel;
using recording::McapChunking;

/** \brief \throws std::runtime_error after a failure, with what is left of the bag */
void
DecodedBag::check(const recording::RecordingStatus& status)
{
  if (status.ok())
    return;
  writer_ = recording::McapWriter(); // it removes a file that holds nothing
  throw std::runtime_error(status.message() + describeUnfinished(path_));
}

DecodedBag::DecodedBag(const Output& output, RecordingInput& input, bool is_packed)
: path_(output.path), existing_(output.existing()), is_packed_(is_packed)
{
  recording::BagReader* const bag = input.bag();
  throwUnlessOk(
      writer_.open(path_, bag != nullptr ? profileFor(bag->profile()) : "ros2"));
  std::set<std::string> topics;
  const std::size_t channels = bag != nullptr ? bag->channels().size() : 0;
  others_.resize(channels);
  for (std::size_t channel = 0; channel < channels; ++channel) {
    if (input.isStream(channel))
      continue;
    others_[channel].emplace();
    check(writer_.addChannel(
        bag->channels()[channel], McapChunking::Shared, *others_[channel]));
    topics.insert(bag->channels()[channel].topic);
  }
  for (std::size_t stream = 0; stream < input.reader().streams().size(); ++stream) {
    streams_.push_back(0);
    const StreamMetadata& metadata = input.reader().streams()[stream].metadata;
    if (!input.isChosen(stream))
      continue;
    std::string topic = topicOf(input.nameOf(stream));
    while (!topics.insert(topic).second)
      topic += "/decoded";
    recording::McapChannel decoded = recording::pointCloudChannel(topic);
    addOtherMetadata(metadata, decoded.metadata);
    check(writer_.addChannel(decoded, McapChunking::Shared, streams_.back()));
  }
}

void
DecodedBag::write(const RecordingInput::Item& item,
                  const recording::RecordedFrame& frame,
                  const io::MessageLayout* layout,
                  pcl::PCLPointCloud2& cloud,
                  RecordingInput& input)
{
  message_.log_time = message_.publish_time = item.time;
  message_.sequence = static_cast<std::uint32_t>(item.number);
  if (item.has_message)
    throwUnlessOk(input.read(item, message_));
  message_.channel = streams_[item.stream];
  if (layout != nullptr && !is_packed_)
    if (std::string reason = nodes::arrange(*layout, cloud); !reason.empty())
      without_layout_.emplace(item.stream, std::move(reason));
  recording::PointCloudMessage content = describeCloud(cloud, frame.stamp);
  content.frame_id = frame.frame_id;
  content.bytes.swap(cloud.data);
  recording::writePointCloud(content, false, message_.bytes);
  check(writer_.write(message_));
}

void
DecodedBag::passThrough(const RecordingInput::Item& item, RecordingInput& input)
{
  if (!input.read(item, message_).ok())
    return; // It is part of the damage.
  message_.channel = others_[message_.channel].value();
  check(writer_.write(message_));
}

std::string
DecodedBag::finish(RecordingInput& input)
{
  if (input.bag() != nullptr)
    copyExtras(*input.bag(), writer_);
  const bool keeps_earlier = keepsEarlierOutput(path_);
  if (keeps_earlier)
    writer_ = recording::McapWriter(); // it writes what it has
  else
    check(writer_.finish(existing_));
  return describeInterruption(path_, keeps_earlier);
}

} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/decoded_bag.h"

#include <pcl_ext/nodes/impl/message_layouts.h>

#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"
#include "inputs/stream_metadata.h"

#include <set>
#include <utility>

namespace pcl_ext::tools {

using recording::McapChannel;
using recording::McapChunking;

DecodedBag::DecodedBag(const Output& output, RecordingInput& input, bool is_packed)
: output_(output, true, input.bag() != nullptr ? input.bag()->profile() : "ros2")
, is_packed_(is_packed)
{
  const recording::BagReader* const bag = input.bag();
  std::set<std::string> topics;
  const std::size_t channels = bag != nullptr ? bag->channels().size() : 0;
  others_.resize(channels);
  for (std::size_t channel = 0; channel < channels; ++channel) {
    if (input.isStream(channel))
      continue;
    others_[channel] =
        output_.addChannel(bag->channels()[channel], McapChunking::Shared);
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
    streams_.back() = output_.addChannel(decoded, McapChunking::Shared);
  }
}

void
DecodedBag::write(const RecordingInput::Item& item,
                  const recording::RecordedFrame& frame,
                  const io::MessageLayout* layout,
                  pcl::PCLPointCloud2& cloud,
                  RecordingInput& input)
{
  message_.log_time = message_.publish_time = frame.time;
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
  output_.write(message_);
}

void
DecodedBag::passThrough(const RecordingInput::Item& item, RecordingInput& input)
{
  if (!input.read(item, message_).ok())
    return; // It is part of the damage.
  message_.channel = others_[message_.channel].value();
  output_.write(message_);
}

std::string
DecodedBag::finish(RecordingInput& input)
{
  if (input.bag() != nullptr)
    output_.copyExtras(*input.bag());
  return output_.finish();
}

} // namespace pcl_ext::tools

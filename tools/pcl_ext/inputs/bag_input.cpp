// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/bag_input.h"

#include "streams/stream_encoder.h"

#include <algorithm>
#include <array>

namespace pcl_ext::tools {

void
BagInput::addChannels(const std::vector<recording::McapChannel>& channels)
{
  for (std::size_t i = stream_of_channel_.size(); i < channels.size(); ++i) {
    const recording::McapChannel& channel = channels[i];
    const bool is_chosen =
        options_.topics.empty() ||
        std::find(options_.topics.begin(), options_.topics.end(), channel.topic) !=
            options_.topics.end();
    if (hasClouds(channel))
      topics_.push_back(channel.topic);
    if (!hasClouds(channel) || !is_chosen) {
      stream_of_channel_.push_back(none);
      continue;
    }
    const auto known = std::find(streams_.begin(), streams_.end(), channel.topic);
    stream_of_channel_.push_back(static_cast<std::size_t>(known - streams_.begin()));
    if (known == streams_.end())
      streams_.push_back(channel.topic);
  }
  clouds_.resize(streams_.size());
  colours_.resize(streams_.size());
}

bool
BagInput::count(std::size_t stream, InputCloud& cloud)
{
  cloud.stream = stream;
  cloud.number = clouds_[stream]++;
  cloud.source = streams_[stream] + ", frame " + std::to_string(cloud.number);
  cloud.failure.clear();
  return cloud.number >= options_.frames.begin && cloud.number < options_.frames.end;
}

void
BagInput::readNext(const recording::McapChannel& channel, InputCloud& cloud)
{
  Colours& colours = colours_[cloud.stream];
  cloud.colour_scale = colours.scale;
  readCloud(channel, options_.packs_colours, cloud, message_);
  if (colours.is_known || !cloud.failure.empty())
    return;
  colours = {cloud.colour_scale, hasPoints(cloud.cloud)};
}

bool
BagInput::wantsMore() const
{
  const auto isUnknown = [this](const std::string& topic) {
    return std::find(topics_.begin(), topics_.end(), topic) == topics_.end();
  };
  return clouds_.empty() ||
         std::any_of(options_.topics.begin(), options_.topics.end(), isUnknown) ||
         std::any_of(clouds_.begin(), clouds_.end(), [this](std::size_t clouds) {
           return clouds < options_.frames.end;
         });
}

bool
BagInput::mayBeClouds(const recording::McapChannel& channel)
{
  constexpr std::array parts = {
      "PointCloud", "CustomMsg", "VelodyneScan", "PacketMsg", "Packets"};
  return std::any_of(parts.begin(), parts.end(), [&channel](const char* part) {
    return channel.schema.name.find(part) != std::string::npos;
  });
}

std::string
BagInput::whyNoClouds(const std::string& name,
                      const std::vector<recording::McapChannel>& channels)
{
  std::string topics;
  for (const recording::McapChannel& channel : channels) {
    if (recording::isCompressedPointCloud(channel))
      return "the clouds of " + channel.topic + " in '" + name +
             "' are compressed already: see them with 'pcl_ext info'";
    if (mayBeClouds(channel))
      return "the clouds of " + channel.topic + " in '" + name + "' are " +
             channel.schema.name + " in the encoding '" + channel.message_encoding +
             "', which cannot be read: record them as sensor_msgs/msg/PointCloud2 "
             "in CDR, which the sensor's driver or a node of it converts them to";
    topics += (topics.empty() ? "" : ", ") + channel.topic;
  }
  return "'" + name + "' has no clouds (sensor_msgs/msg/PointCloud2); " +
         (topics.empty() ? "it has no topics" : "its topics are " + topics);
}

} // namespace pcl_ext::tools

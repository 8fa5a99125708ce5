// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/message_layout.h>
#include <pcl_ext/nodes/impl/message_layouts.h>

#include "console/throw_unless_ok.h"
#include "inputs/point_cloud_conversions.h"
#include "inputs/recording_input.h"
#include "inputs/stream_metadata.h"
#include "outputs/frame_output.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools {

/** \brief A bag with the decoded clouds of a recording as sensor_msgs/msg/PointCloud2,
 * and with all other messages of a bag. Failures throw std::runtime_error. */
class DecodedBag {
public:
  /** \brief Opens the bag, with a topic for each stream that was chosen: its name
   * without /pcl_ext at its end.
   * \param[in] is_packed its points have no padding; else the layout of the messages that
   * a stream was made of, if it tells
   */
  DecodedBag(const Output& output, RecordingInput& input, bool is_packed)
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
          output_.addChannel(bag->channels()[channel], recording::McapChunking::Shared);
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
      streams_.back() = output_.addChannel(decoded, recording::McapChunking::Shared);
    }
  }

  /** \brief Writes a decoded cloud.
   * \param[in,out] cloud gets the layout
   * \param[in] layout of its message; null: not known
   */
  void
  write(const RecordingInput::Item& item,
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
    if (layout != nullptr && !is_packed_) {
      std::size_t limited = 0;
      if (std::string reason = nodes::arrange(*layout, cloud, &limited);
          !reason.empty())
        without_layout_.emplace(item.stream, std::move(reason));
      if (limited > 0)
        limited_[item.stream] += limited;
    }
    recording::PointCloudMessage content = describeCloud(cloud, frame.stamp);
    content.frame_id = frame.frame_id;
    content.bytes.swap(cloud.data);
    recording::writePointCloud(content, false, message_.bytes);
    output_.write(message_);
  }

  /** \brief Writes another message of the input as it is. */
  void
  passThrough(const RecordingInput::Item& item, RecordingInput& input)
  {
    if (!input.read(item, message_).ok())
      return; // It is part of the damage.
    message_.channel = others_[message_.channel].value();
    output_.write(message_);
  }

  /** \brief Streams with messages that could not get their layout back, and why. */
  const std::map<std::size_t, std::string>&
  streamsWithoutLayout() const
  {
    return without_layout_;
  }

  /** \brief Streams with numbers that were outside of the types of their messages, and
   * how many were. */
  const std::map<std::size_t, std::size_t>&
  streamsWithLimitedNumbers() const
  {
    return limited_;
  }

  /** \brief Copies metadata and attachments, and completes the bag, as
   * FrameOutput::finish(). */
  std::string
  finish(RecordingInput& input)
  {
    if (input.bag() != nullptr)
      output_.copyExtras(*input.bag());
    return output_.finish();
  }

private:
  FrameOutput output_;
  std::vector<std::size_t> streams_; // channels of the streams
  bool is_packed_;
  std::map<std::size_t, std::string> without_layout_; // streams, and why
  std::map<std::size_t, std::size_t> limited_;        // numbers of streams
  std::vector<std::optional<std::size_t>> others_;    // of the channels of the input
  recording::McapMessage message_;
};

} // namespace pcl_ext::tools

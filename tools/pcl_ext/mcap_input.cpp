#include <pcl_ext/recording/point_cloud_messages.h>

#include "cloud_input.h"
#include "exit_status.h"
#include "point_cloud_conversions.h"

#include <algorithm>

namespace pcl_ext {
namespace tools {

namespace {

using recording::McapChannel;
using recording::McapEntry;
using recording::McapMessage;
using recording::McapReader;
using recording::RecordingStatus;

/** \brief An MCAP file or a rosbag2 folder: its clouds and all other messages. */
class McapInput : public CloudInput {
public:
  McapInput(const std::string& path, const InputOptions& options) : options_(options)
  {
    if (const RecordingStatus status = reader_.open(path); !status.ok())
      throw std::runtime_error(status.message());
    std::vector<std::string> topics;
    for (const McapChannel& channel : reader_.channels())
      if (recording::isPointCloud(channel))
        topics.push_back(channel.topic);
    if (topics.empty())
      throw std::runtime_error("'" + path +
                               "' has no clouds (sensor_msgs/msg/PointCloud2); " +
                               describeChannels());
    checkTopics(options.topics, topics);
    chooseStreams();
  }

  const std::vector<std::string>&
  streams() const override
  {
    return streams_;
  }

  std::size_t
  size() const override
  {
    return reader_.index().size();
  }

  bool
  isBag() const override
  {
    return true;
  }

  std::string
  profile() const override
  {
    return reader_.profile();
  }

  const std::vector<McapChannel>&
  channels() const override
  {
    return reader_.channels();
  }

  McapReader*
  mcap() override
  {
    return &reader_;
  }

  std::vector<std::string>
  damage() const override
  {
    std::vector<std::string> lines;
    for (const recording::RecordingDamage& place : reader_.damage())
      lines.push_back(place.file + ", byte " + std::to_string(place.offset) + ": " +
                      place.message);
    return lines;
  }

  Found
  next(InputCloud& cloud, McapMessage& other) override
  {
    while (next_ < reader_.index().size()) {
      const McapEntry& entry = reader_.index()[next_++];
      const std::size_t stream = stream_of_channel_[entry.channel];
      if (stream != none) {
        const std::size_t number = clouds_[stream]++;
        if (number < options_.frames.begin || number >= options_.frames.end)
          continue;
        readCloud(entry, stream, number, cloud);
        return Found::Cloud;
      }
      // What cannot be read is part of damage().
      if (reader_.read(entry, other).ok())
        return Found::OtherMessage;
    }
    return Found::End;
  }

private:
  static constexpr std::size_t none = ~std::size_t{0};

  std::string
  describeChannels() const
  {
    std::string topics;
    for (const McapChannel& channel : reader_.channels()) {
      if (recording::isCompressedPointCloud(channel))
        return "the clouds of " + channel.topic +
               " are compressed already: see them with 'pcl_ext info'";
      topics += (topics.empty() ? "" : ", ") + channel.topic;
    }
    return topics.empty() ? "it has no topics" : "its topics are " + topics;
  }

  /** \brief Makes a stream of each channel that was chosen. */
  void
  chooseStreams()
  {
    for (const McapChannel& channel : reader_.channels()) {
      const bool is_chosen =
          options_.topics.empty() ||
          std::find(options_.topics.begin(), options_.topics.end(), channel.topic) !=
              options_.topics.end();
      if (!recording::isPointCloud(channel) || !is_chosen) {
        stream_of_channel_.push_back(none);
        continue;
      }
      // Channels of one topic, as of two publishers, are one stream.
      const auto known = std::find(streams_.begin(), streams_.end(), channel.topic);
      stream_of_channel_.push_back(static_cast<std::size_t>(known - streams_.begin()));
      if (known == streams_.end())
        streams_.push_back(channel.topic);
    }
    clouds_.resize(streams_.size());
  }

  void
  readCloud(const McapEntry& entry,
            std::size_t stream,
            std::size_t number,
            InputCloud& cloud)
  {
    cloud.stream = stream;
    cloud.number = number;
    cloud.source = streams_[stream] + ", frame " + std::to_string(number);
    cloud.failure.clear();
    RecordingStatus status = reader_.read(entry, cloud.message);
    if (status.ok())
      status = recording::readPointCloud(
          cloud.message.bytes.data(), cloud.message.bytes.size(), false, message_);
    if (!status.ok()) {
      cloud.failure = status.message();
      return;
    }
    cloud.stamp = message_.stamp;
    try {
      toCloud(message_, cloud.cloud);
    }
    catch (const std::exception& error) {
      cloud.failure = error.what();
    }
  }

  InputOptions options_;
  McapReader reader_;
  std::vector<std::string> streams_;
  std::vector<std::size_t> stream_of_channel_; // or none
  std::vector<std::size_t> clouds_;            // of each stream that were met
  std::size_t next_ = 0;
  recording::PointCloudMessage message_; // a member so that its memory is reused
};

} // namespace

std::unique_ptr<CloudInput>
openMcap(const std::string& path, const InputOptions& options)
{
  return std::make_unique<McapInput>(path, options);
}

} // namespace tools
} // namespace pcl_ext

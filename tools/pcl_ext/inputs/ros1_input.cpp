// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/cloud_input.h"
#include "inputs/point_cloud_conversions.h"
#include "inputs/ros1_point_cloud.h"

#include <ros/serialization.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

using recording::McapChannel;
using recording::McapMessage;

recording::Time
timeOf(const ros::Time& time)
{
  return std::chrono::seconds(time.sec) + recording::Time(time.nsec);
}

/** \brief A bag of ROS 1: its clouds, and its other messages in their own encoding. */
class Ros1Input : public CloudInput {
public:
  Ros1Input(const std::string& path, const InputOptions& options)
  : options_(options), bag_(path, rosbag::bagmode::Read), view_(bag_)
  {
    std::vector<std::string> topics;
    for (const rosbag::ConnectionInfo* connection : view_.getConnections()) {
      addChannel(*connection);
      if (connection->datatype == cloud_type &&
          std::find(topics.begin(), topics.end(), connection->topic) == topics.end())
        topics.push_back(connection->topic);
    }
    if (topics.empty())
      throw std::runtime_error("'" + path +
                               "' has no clouds (sensor_msgs/PointCloud2)");
    checkTopics(options.topics, topics);
    streams_ = options.topics.empty() ? topics : options.topics;
    clouds_.resize(streams_.size());
    next_ = view_.begin();
  }

  const std::vector<std::string>&
  streams() const override
  {
    return streams_;
  }

  std::size_t
  size() const override
  {
    return const_cast<rosbag::View&>(view_).size();
  }

  bool
  isBag() const override
  {
    return true;
  }

  std::string
  profile() const override
  {
    return ""; // messages of ROS 1 and of ROS 2
  }

  const std::vector<McapChannel>&
  channels() const override
  {
    return channels_;
  }

  Found
  next(InputCloud& cloud, McapMessage& other) override
  {
    while (next_ != view_.end()) {
      const rosbag::MessageInstance message = *next_++;
      const auto stream =
          std::find(streams_.begin(), streams_.end(), message.getTopic());
      if (stream == streams_.end() || message.getDataType() != cloud_type) {
        readBytes(message, other);
        other.channel = channel_of_.at({message.getTopic(), message.getDataType()});
        return Found::OtherMessage;
      }
      const auto index = static_cast<std::size_t>(stream - streams_.begin());
      const std::size_t number = clouds_[index]++;
      if (number < options_.frames.begin || number >= options_.frames.end)
        continue;
      readCloud(message, index, number, cloud);
      return Found::Cloud;
    }
    return Found::End;
  }

private:
  static constexpr const char* cloud_type = "sensor_msgs/PointCloud2";

  void
  addChannel(const rosbag::ConnectionInfo& connection)
  {
    const auto key = std::make_pair(connection.topic, connection.datatype);
    if (!channel_of_.emplace(key, channels_.size()).second)
      return; // of another publisher
    McapChannel channel;
    channel.topic = connection.topic;
    channel.message_encoding = "ros1";
    channel.schema = {connection.datatype, "ros1msg", connection.msg_def};
    channel.metadata["md5sum"] = connection.md5sum;
    channels_.push_back(channel);
  }

  static void
  readBytes(const rosbag::MessageInstance& from, McapMessage& message)
  {
    message.log_time = message.publish_time = timeOf(from.getTime());
    message.sequence = 0;
    message.bytes.resize(from.size());
    ros::serialization::OStream stream(
        message.bytes.data(), static_cast<std::uint32_t>(message.bytes.size()));
    from.write(stream);
  }

  void
  readCloud(const rosbag::MessageInstance& from,
            std::size_t stream,
            std::size_t number,
            InputCloud& cloud)
  {
    cloud.stream = stream;
    cloud.number = number;
    cloud.source = streams_[stream] + ", frame " + std::to_string(number);
    cloud.failure.clear();
    try {
      readBytes(from, cloud.message);
      readRos1PointCloud(
          cloud.message.bytes.data(), cloud.message.bytes.size(), message_);
      cloud.stamp = message_.stamp;
      toCloud(message_, cloud.cloud);
    }
    catch (const std::exception& error) {
      cloud.failure = error.what();
    }
  }

  InputOptions options_;
  rosbag::Bag bag_;
  rosbag::View view_;
  rosbag::View::iterator next_;
  std::vector<std::string> streams_;
  std::vector<std::size_t> clouds_; // of each stream that were met
  std::vector<McapChannel> channels_;
  std::map<std::pair<std::string, std::string>, std::size_t> channel_of_;
  recording::PointCloudMessage message_;
};

} // namespace

std::unique_ptr<CloudInput>
openRos1Bag(const std::string& path, const InputOptions& options)
{
  try {
    return std::make_unique<Ros1Input>(path, options);
  }
  catch (const rosbag::BagException& error) {
    throw std::runtime_error("cannot read the bag '" + path + "': " + error.what());
  }
}

} // namespace tools
} // namespace pcl_ext

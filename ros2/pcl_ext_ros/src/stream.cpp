// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream.h"

#include <pcl_ext/nodes/impl/cloud_messages.h>

#include "weak_callback.h"

#include <pcl_ext_ros_common/message_times.hpp>
#include <pcl_ext_ros_common/transport_topic.hpp>

#include <utility>

namespace pcl_ext_ros {

using diagnostic_msgs::msg::DiagnosticArray;
using pcl_ext::nodes::ParameterValues;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::parameterPrefix;
using pcl_ext_ros_common::requestTopic;

namespace {

/** \brief The topic on which a node that merges tells of what; empty for one that cannot
 * be a merged stream. */
std::string
sourcesTopic(const std::string& topic)
{
  const std::string ending = std::string("/") + pcl_ext_ros_common::transport_name;
  if (topic.size() <= ending.size() ||
      topic.compare(topic.size() - ending.size(), ending.size(), ending) != 0)
    return {};
  return topic.substr(0, topic.size() - ending.size()) + "/streams";
}

/** \brief A topic without the namespace of a node. */
std::string
withinNamespace(rclcpp::Node& node, const std::string& topic)
{
  std::string space = node.get_namespace();
  if (space.back() != '/')
    space += '/';
  return topic.substr(topic.compare(0, space.size(), space) == 0 ? space.size() : 1);
}

} // namespace

Stream::Stream(rclcpp::Node& node,
               const std::string& name,
               const std::string& topic,
               std::shared_ptr<pcl_ext::nodes::MergingCentre> centre)
: name_(name), topic_(topic), centre_(std::move(centre))
{
  constants_.emplace(node,
                     parameterPrefix(node, name),
                     pcl_ext::nodes::streamParameters(),
                     NodeParameters::Check(),
                     NodeParameters::Listener(),
                     NodeParameters::Kind::ReadOnly);
  sensor_frame_ = pcl_ext::nodes::withoutLeadingSlash(
      pcl_ext::nodes::valueOf<std::string>(constants_->values(), "sensor_frame"));

  constexpr std::size_t voxels_queue_size = 10;
  rclcpp::PublisherOptions options;
  options.qos_overriding_options =
      rclcpp::QosOverridingOptions::with_default_policies();
  // Of this node: several may decompress the stream.
  voxels_ = node.create_publisher<sensor_msgs::msg::PointCloud2>(
      "~/" + withinNamespace(node, topic) + "/voxels",
      rclcpp::QoS(voxels_queue_size),
      options);
  i_frame_requests_ =
      node.create_publisher<std_msgs::msg::Empty>(requestTopic(topic), 10);
  group_ = node.create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
}

void
Stream::connect(rclcpp::Node& node, Receive receive)
{
  noise_.emplace(node,
                 parameterPrefix(node, name_),
                 pcl_ext::nodes::noiseParameters(),
                 NodeParameters::Check(),
                 weakCallback(weak_from_this(), &Stream::setNoise),
                 NodeParameters::Kind::Optional);
  setNoise(noise_->values());

  constexpr std::size_t frame_queue_size = 40;
  rclcpp::SubscriptionOptions options;
  options.qos_overriding_options =
      rclcpp::QosOverridingOptions::with_default_policies();
  // Frames of one stream stay in their order; those of others do not wait for them.
  options.callback_group = group_;
  frames_ = node.create_subscription<FrameMessage>(
      topic_,
      rclcpp::QoS(frame_queue_size),
      [stream = weak_from_this(),
       receive = std::move(receive)](std::unique_ptr<FrameMessage> frame) {
        if (const auto alive = stream.lock())
          receive(*alive, std::move(*frame));
      },
      options);
}

void
Stream::findSources(rclcpp::Node& node)
{
  const std::string topic = sourcesTopic(topic_);
  if (sources_ || topic.empty() || node.count_publishers(topic) == 0)
    return;
  rclcpp::SubscriptionOptions options;
  options.callback_group = group_;
  sources_ = node.create_subscription<DiagnosticArray>(
      topic, 10, weakCallback(weak_from_this(), &Stream::receiveSources), options);
}

void
Stream::setNoise(const ParameterValues& values)
{
  centre_->setNoise(topic_, values);
}

void
Stream::receiveSources(std::unique_ptr<DiagnosticArray> message)
{
  using KeysAndValues = std::vector<std::pair<std::string, std::string>>;
  std::vector<std::pair<std::string, KeysAndValues>> reports;
  for (const auto& status : message->status) {
    const std::string separator = ": "; // behind the name of the node
    const std::size_t end = status.name.find(separator);
    const std::size_t begin = end == std::string::npos ? 0 : end + separator.size();
    KeysAndValues values;
    for (const auto& pair : status.values)
      values.emplace_back(pair.key, pair.value);
    reports.emplace_back(status.name.substr(begin), std::move(values));
  }
  centre_->setSources(topic_,
                      pcl_ext_ros_common::toTime(message->header.stamp),
                      pcl_ext::nodes::readMergedSources(reports));
}

} // namespace pcl_ext_ros

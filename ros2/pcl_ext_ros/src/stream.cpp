#include "stream.h"

#include <pcl_ext/nodes/cloud_messages.h>

#include "weak_callback.h"

#include <pcl_ext_ros_common/transport_topic.hpp>

#include <utility>

namespace pcl_ext_ros {

using pcl_ext::nodes::ParameterValues;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::parameterPrefix;
using pcl_ext_ros_common::requestTopic;

Stream::Stream(rclcpp::Node& node,
               const std::string& topic,
               std::size_t number,
               std::shared_ptr<pcl_ext::nodes::CentralNode> central_node)
: topic_(topic)
, number_(number)
, central_node_(std::move(central_node))
, noise_of_all_(defaultsOf(pcl_ext::nodes::noiseParameters()))
, graph_(node.get_node_graph_interface())
{
  constants_.emplace(node,
                     parameterPrefix(node, topic),
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
  voxels_ = node.create_publisher<sensor_msgs::msg::PointCloud2>(
      topic + "/voxels", rclcpp::QoS(voxels_queue_size), options);
  i_frame_requests_ =
      node.create_publisher<std_msgs::msg::Empty>(requestTopic(topic), 10);
  group_ = node.create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
}

void
Stream::connect(rclcpp::Node& node)
{
  parameters_.emplace(node,
                      parameterPrefix(node, topic_),
                      pcl_ext::nodes::noiseParameters(),
                      NodeParameters::Check(),
                      weakCallback(weak_from_this(), &Stream::setOwnNoise),
                      NodeParameters::Kind::Optional);
  setOwnNoise(parameters_->values());
}

void
Stream::setNoiseOfAll(const ParameterValues& values)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  noise_of_all_ = values;
  updateNoise();
}

void
Stream::setOwnNoise(const ParameterValues& values)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  own_noise_ = values;
  updateNoise();
}

void
Stream::updateNoise()
{
  ParameterValues noise = own_noise_;
  noise.insert(noise_of_all_.begin(), noise_of_all_.end());
  if (noise == noise_)
    return;
  const auto settings = pcl_ext::nodes::readNoiseParameters(noise);
  central_node_->setMinIntensity(topic_, settings.min_intensity);
  central_node_->setOutlierRemoval(topic_, settings.outlier_removal);
  noise_ = std::move(noise);
}

pcl_ext::nodes::HealthReport
Stream::describeHealth(const pcl_ext::nodes::StreamHealth& health,
                       double merged_resolution)
{
  pcl_ext::nodes::ReceiverHealth now;
  now.stream = health;
  now.left_out = left_out_;
  now.merged_resolution = merged_resolution;
  if (const auto last_arrival = last_arrival_.load(); last_arrival != 0)
    now.last_arrival = pcl_ext::nodes::Time(last_arrival);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!noise_.empty())
      now.min_intensity = pcl_ext::nodes::readNoiseParameters(noise_).min_intensity;
  }
  auto report = pcl_ext::nodes::describeHealth(
      now, std::exchange(reported_, now), pcl_ext::nodes::steadyTime());
  const std::size_t publishers = frames_->get_publisher_count();
  // An error, as frames of each seem to be lost, of which warnings are.
  if (publishers > 1)
    report.raise(pcl_ext::nodes::HealthLevel::Error,
                 std::to_string(publishers) +
                     " publishers send this stream, which can have one");
  report.add("publishers", publishers);
  const std::string voxels_topic = voxels_->get_topic_name();
  if (const std::size_t nodes = graph_->count_publishers(voxels_topic); nodes > 1)
    report.raise(pcl_ext::nodes::HealthLevel::Error,
                 std::to_string(nodes) + " nodes publish " + voxels_topic +
                     ": each stream can have one central node");
  return report;
}

} // namespace pcl_ext_ros

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_point_cloud_transport/publisher.hpp"

#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>

#include "pcl_ext_ros_common/health_publisher.hpp"
#include "pcl_ext_ros_common/message_times.hpp"
#include "pcl_ext_ros_common/node_parameters.hpp"
#include "pcl_ext_ros_common/throttled_log.hpp"
#include "pcl_ext_ros_common/transport_topic.hpp"

#include <rclcpp/create_subscription.hpp>
#include <std_msgs/msg/empty.hpp>

#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

namespace pcl_ext_point_cloud_transport {

using Message = point_cloud_interfaces::msg::CompressedPointCloud2;
using pcl_ext::nodes::ParameterValues;
using pcl_ext::nodes::SenderHealth;
using pcl_ext_ros_common::HealthPublisher;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::ThrottledLog;

/** \brief The sender and what connects it with a node. */
class Publisher::Stream : public std::enable_shared_from_this<Publisher::Stream> {
public:
  /** \brief Declares the parameters of a topic, and listens to requests.
   * \param[in] node that publishes
   * \param[in] name of the topic as the program has it
   * \param[in] topic with the remappings
   */
  void
  connect(NodeInterfaces node, const std::string& name, const std::string& topic)
  {
    const auto logger = node.get_node_logging_interface()->get_logger();
    warnings_.emplace(logger);
    refusals_.emplace(logger);
    prefix_ = pcl_ext_ros_common::parameterPrefix(node, name);
    const std::weak_ptr<Stream> stream = weak_from_this();
    parameters_.emplace(node,
                        prefix_,
                        pcl_ext::nodes::encodingParameters(),
                        pcl_ext::nodes::faultOfEncodingParameters,
                        [stream](const ParameterValues& values) {
                          if (const auto alive = stream.lock())
                            alive->setParameters(values);
                        });
    setParameters(parameters_->values());
    requests_ = rclcpp::create_subscription<std_msgs::msg::Empty>(
        node,
        pcl_ext_ros_common::requestTopic(topic),
        10,
        [stream](const std_msgs::msg::Empty&) {
          if (const auto alive = stream.lock())
            alive->sender_.requestIFrame();
        });
    health_.emplace(
        node,
        [stream, topic]() -> std::vector<HealthPublisher::Entry> {
          const auto alive = stream.lock();
          if (!alive)
            return {};
          return {{topic, alive->describeHealth()}};
        },
        clockOfDiagnostics());
  }

  void
  disconnect()
  {
    health_.reset();
    requests_.reset();
    parameters_.reset();
  }

  /** \brief Some subscribers have left. Where others took their places, they are as
   * many as before but need an I-frame. */
  void
  setDeparted(std::size_t subscribers)
  {
    departed_ = subscribers;
  }

  /** \brief Encodes a cloud, or says why not. Does not throw where memory runs out. */
  Publisher::TypedEncodeResult
  encode(const sensor_msgs::msg::PointCloud2& raw, std::size_t subscribers)
  {
    try {
      return encodeOrThrow(raw, subscribers);
    }
    catch (const std::exception& failure) {
      return tl::make_unexpected(failure.what());
    }
  }

  /** \brief Logs why a cloud was refused, but not each time. */
  void
  logRefusal(const std::string& reason)
  {
    if (refusals_)
      refusals_->error("A cloud is not sent: " + reason);
  }

private:
  Publisher::TypedEncodeResult
  encodeOrThrow(const sensor_msgs::msg::PointCloud2& raw, std::size_t subscribers)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!fault_.empty())
      return tl::make_unexpected(fault_);
    pcl_ext::nodes::toPcl(raw, cloud_);
    cloud_.header.stamp = pcl_ext_ros_common::toMicroseconds(raw.header.stamp);
    Message message;
    const auto status =
        sender_.encode(cloud_,
                       pcl_ext::WorldPose(pcl_ext::WorldPose::Identity()),
                       subscribers + departed_,
                       message.compressed_data);
    if (status.code() == pcl_ext::nodes::SensorNodeCode::LeftOut)
      return std::nullopt; // as max_rate demands; said by the diagnostics
    if (!status.hasFrame())
      return tl::make_unexpected(status.message());
    if (warnings_ && status.hasWarning())
      warnings_->warn(status.message());
    pcl_ext::nodes::describeFrame(sender_.health().node, sender_.settings(), message);
    message.header = raw.header;
    return message;
  }

  void
  setParameters(const ParameterValues& values)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    fault_ = sender_.setParameters(values);
    if (!fault_.empty())
      fault_.insert(0, prefix_);
  }

  pcl_ext::nodes::HealthReport
  describeHealth()
  {
    const SenderHealth now = sender_.health();
    const auto report = pcl_ext::nodes::describeHealth(
        now, std::exchange(reported_, now), pcl_ext::nodes::steadyTime());
    return report;
  }

  // Without a node there are none.
  std::optional<ThrottledLog> warnings_;
  std::optional<ThrottledLog> refusals_;
  std::string prefix_; // of the parameters' names
  pcl_ext::nodes::CloudSender sender_;
  std::optional<NodeParameters> parameters_;
  rclcpp::Subscription<std_msgs::msg::Empty>::SharedPtr requests_;
  std::optional<HealthPublisher> health_;
  SenderHealth reported_; // by the timer of health_
  std::atomic<std::size_t> departed_{0};

  std::mutex mutex_;          // guards what follows
  std::string fault_;         // of the parameters at the start
  pcl::PCLPointCloud2 cloud_; // keeps its memory
};

Publisher::Publisher() : stream_(std::make_shared<Stream>()) {}

Publisher::~Publisher() { stream_->disconnect(); }

std::string
Publisher::getTransportName() const
{
  return pcl_ext_ros_common::transport_name;
}

std::string
Publisher::getDataType() const
{
  return "point_cloud_interfaces/msg/CompressedPointCloud2";
}

void
Publisher::declareParameters(const std::string& /*base_topic*/)
{}

void
Publisher::advertiseImpl(TransportNode node,
                         const std::string& base_topic,
                         TransportQos custom_qos,
                         const rclcpp::PublisherOptions& options)
{
  rclcpp::PublisherOptions with_event = options;
  with_event.event_callbacks.matched_callback =
      [stream = std::weak_ptr<Stream>(stream_),
       user_callback =
           options.event_callbacks.matched_callback](rclcpp::MatchedInfo& info) {
        if (const auto alive = stream.lock())
          alive->setDeparted(info.total_count - info.current_count);
        if (user_callback)
          user_callback(info);
      };
  try {
    SimplePublisherPlugin::advertiseImpl(node, base_topic, custom_qos, with_event);
  }
  catch (const rclcpp::UnsupportedEventTypeException&) {
    SimplePublisherPlugin::advertiseImpl(node, base_topic, custom_qos, options);
  }
  stream_->connect(toInterfaces(node), getTopicToAdvertise(base_topic), getTopic());
}

void
Publisher::shutdown()
{
  stream_->disconnect();
  SimplePublisherPlugin::shutdown();
}

Publisher::TypedEncodeResult
Publisher::encodeTyped(const sensor_msgs::msg::PointCloud2& raw) const
{
  return stream_->encode(raw, getNumSubscribers());
}

void
Publisher::publish(const sensor_msgs::msg::PointCloud2& message,
                   const PublishFn& publish_fn) const
{
  const TypedEncodeResult result = encodeTyped(message);
  if (!result)
    stream_->logRefusal(result.error());
  else if (result.value())
    publish_fn(*result.value());
}

} // namespace pcl_ext_point_cloud_transport

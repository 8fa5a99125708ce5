// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_point_cloud_transport/subscriber.hpp"

#include <pcl_ext/nodes/impl/cloud_messages.h>

#include "pcl_ext_ros_common/health_publisher.hpp"
#include "pcl_ext_ros_common/message_times.hpp"
#include "pcl_ext_ros_common/node_parameters.hpp"
#include "pcl_ext_ros_common/throttled_log.hpp"
#include "pcl_ext_ros_common/transport_topic.hpp"
#include "streams_of_publishers.h"

#include <rclcpp/create_publisher.hpp>
#include <rclcpp/create_subscription.hpp>
#include <std_msgs/msg/empty.hpp>

#include <exception>
#include <optional>
#include <utility>

namespace pcl_ext_point_cloud_transport {

using Message = point_cloud_interfaces::msg::CompressedPointCloud2;
using pcl_ext::nodes::ParameterValues;
using pcl_ext_ros_common::HealthPublisher;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::ThrottledLog;

/** \brief The streams of a topic and what connects them with a node. */
class Subscriber::Streams : public std::enable_shared_from_this<Subscriber::Streams> {
public:
  /** \brief Begins to receive frames, after all else is set up.
   * \param[in] node that subscribes
   * \param[in] topic as the program has it
   * \param[in] callback for the clouds
   * \param[in] qos of the frames
   * \param[in] options of the subscription
   */
  void
  connect(NodeInterfaces node,
          const std::string& topic,
          const Callback& callback,
          const rclcpp::QoS& qos,
          const rclcpp::SubscriptionOptions& options)
  {
    const std::weak_ptr<Streams> streams = weak_from_this();
    const std::string resolved =
        node.get_node_topics_interface()->resolve_topic_name(topic);
    parameters_.emplace(node,
                        pcl_ext_ros_common::parameterPrefix(node, topic),
                        pcl_ext::nodes::noiseParameters(),
                        NodeParameters::Check(),
                        [streams](const ParameterValues& values) {
                          if (const auto alive = streams.lock())
                            alive->streams_.setNoise(
                                pcl_ext::nodes::readNoiseParameters(values));
                        });
    streams_.setNoise(pcl_ext::nodes::readNoiseParameters(parameters_->values()));
    const std::shared_ptr<Connection> connection(
        new Connection{resolved,
                       callback,
                       rclcpp::create_publisher<std_msgs::msg::Empty>(
                           node, pcl_ext_ros_common::requestTopic(resolved), 10),
                       ThrottledLog(node.get_node_logging_interface()->get_logger())});
    subscription_ = rclcpp::create_subscription<Message>(
        node,
        topic,
        qos,
        [streams, connection](const std::shared_ptr<const Message>& message,
                              const rclcpp::MessageInfo& info) {
          if (const auto alive = streams.lock())
            alive->receive(*message, publisherOf(info), *connection);
        },
        options);
    const std::weak_ptr<const rclcpp::SubscriptionBase> subscription = subscription_;
    health_.emplace(
        node,
        [streams, resolved, subscription] {
          const auto alive = streams.lock();
          const auto still_subscribed = subscription.lock();
          return alive && still_subscribed
                     ? alive->describeHealth(resolved,
                                             still_subscribed->get_publisher_count())
                     : std::vector<HealthPublisher::Entry>();
        },
        clockOfDiagnostics());
  }

  void
  disconnect()
  {
    health_.reset();
    parameters_.reset();
    subscription_.reset();
  }

  rclcpp::SubscriptionBase::SharedPtr
  subscription() const
  {
    return subscription_;
  }

  /** \brief Decodes a frame, or says why not. Does not throw: frames of few bytes may
   * be of many points, for which memory may run out. */
  Subscriber::DecodeResult
  decode(const Message& message, const PublisherId& publisher, bool& wants_i_frame)
  {
    wants_i_frame = false;
    try {
      return decodeOrThrow(message, publisher, wants_i_frame);
    }
    catch (const std::exception& failure) {
      return tl::make_unexpected(failure.what());
    }
  }

private:
  Subscriber::DecodeResult
  decodeOrThrow(const Message& message,
                const PublisherId& publisher,
                bool& wants_i_frame)
  {
    const auto receiver = streams_.receiverOf(publisher);
    if (std::string fault = pcl_ext::nodes::faultOfFormat(message.format);
        !fault.empty()) {
      receiver->countLeftOut();
      return tl::make_unexpected(std::move(fault));
    }
    pcl_ext::io::VoxelFrame voxels;
    const auto status =
        receiver->receive(message.compressed_data,
                          pcl_ext_ros_common::toTime(message.header.stamp),
                          voxels);
    wants_i_frame = status.wants_i_frame;
    if (!status.ok())
      return tl::make_unexpected(status.message());
    const auto cloud = std::make_shared<sensor_msgs::msg::PointCloud2>();
    cloud->header = message.header;
    pcl_ext::nodes::writeVoxels(voxels, *cloud);
    return cloud;
  }

  /** \brief What a callback needs, which may still run while another thread
   * disconnects. */
  struct Connection {
    std::string topic;
    Callback callback;
    rclcpp::Publisher<std_msgs::msg::Empty>::SharedPtr requests;
    ThrottledLog failures;
  };

  void
  receive(const Message& message, const PublisherId& publisher, Connection& connection)
  {
    bool wants_i_frame = false;
    const DecodeResult result = decode(message, publisher, wants_i_frame);
    if (wants_i_frame)
      connection.requests->publish(std_msgs::msg::Empty());
    if (result)
      connection.callback(*result.value());
    else
      connection.failures.warn("A frame of " + connection.topic +
                               " is not decoded: " + result.error());
  }

  /** \brief One entry for each publisher; those after the first one are numbered. */
  std::vector<HealthPublisher::Entry>
  describeHealth(const std::string& topic, std::size_t publishers)
  {
    std::vector<HealthPublisher::Entry> entries;
    for (auto& report : streams_.describeHealth(publishers)) {
      const std::string number = std::to_string(entries.size() + 1);
      entries.emplace_back(entries.empty() ? topic : topic + " " + number,
                           std::move(report));
    }
    return entries;
  }

  StreamsOfPublishers streams_;
  std::optional<NodeParameters> parameters_;
  rclcpp::SubscriptionBase::SharedPtr subscription_;
  std::optional<HealthPublisher> health_;
};

Subscriber::Subscriber() : streams_(std::make_shared<Streams>()) {}

Subscriber::~Subscriber() { streams_->disconnect(); }

std::string
Subscriber::getTransportName() const
{
  return pcl_ext_ros_common::transport_name;
}

std::string
Subscriber::getDataType() const
{
  return "point_cloud_interfaces/msg/CompressedPointCloud2";
}

std::string
Subscriber::getTopic() const
{
  const auto subscription = getSubscription();
  return subscription ? subscription->get_topic_name() : "";
}

std::uint32_t
Subscriber::getNumPublishers() const
{
  const auto subscription = getSubscription();
  return subscription ? static_cast<std::uint32_t>(subscription->get_publisher_count())
                      : 0;
}

rclcpp::SubscriptionBase::SharedPtr
Subscriber::getSubscription() const
{
  return streams_->subscription();
}

void
Subscriber::shutdown()
{
  streams_->disconnect();
}

void
Subscriber::declareParameters()
{}

Subscriber::DecodeResult
Subscriber::decodeTyped(const Message& compressed) const
{
  bool wants_i_frame = false;
  return streams_->decode(compressed, PublisherId{}, wants_i_frame);
}

void
Subscriber::subscribeImpl(TransportNode node,
                          const std::string& base_topic,
                          const Callback& callback,
                          TransportQos custom_qos)
{
  subscribeImpl(node, base_topic, callback, custom_qos, rclcpp::SubscriptionOptions());
}

void
Subscriber::subscribeImpl(TransportNode node,
                          const std::string& base_topic,
                          const Callback& callback,
                          TransportQos custom_qos,
                          rclcpp::SubscriptionOptions options)
{
  streams_->connect(toInterfaces(node),
                    getTopicToSubscribe(base_topic),
                    callback,
                    toQos(custom_qos),
                    options);
}

} // namespace pcl_ext_point_cloud_transport

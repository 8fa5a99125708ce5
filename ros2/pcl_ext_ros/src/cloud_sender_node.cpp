// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_ros/cloud_sender_node.hpp"

#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>

#include "transform_lookup.h"
#include "weak_callback.h"

#include <pcl_ext_ros_common/health_publisher.hpp>
#include <pcl_ext_ros_common/message_times.hpp>
#include <pcl_ext_ros_common/node_parameters.hpp>
#include <pcl_ext_ros_common/throttled_log.hpp>
#include <pcl_ext_ros_common/transport_topic.hpp>
#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_srvs/srv/trigger.hpp>

#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace pcl_ext_ros {

using pcl_ext::nodes::ParameterValues;
using pcl_ext::nodes::SensorNodeCode;
using pcl_ext::nodes::Time;
using pcl_ext::nodes::valueOf;
using pcl_ext::nodes::withoutLeadingSlash;
using pcl_ext_ros_common::HealthPublisher;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::ThrottledLog;
using pcl_ext_ros_common::toTime;
using point_cloud_interfaces::msg::CompressedPointCloud2;
using sensor_msgs::msg::PointCloud2;
using std_srvs::srv::Trigger;

namespace {

constexpr std::size_t frame_queue_size = 40;
constexpr std::chrono::milliseconds between_lookups{2};

pcl_ext::nodes::SensorNodeSettings
settingsOf(const std::string& global_frame, const rclcpp::Clock::SharedPtr& clock)
{
  pcl_ext::nodes::SensorNodeSettings settings;
  settings.global_frame = global_frame;
  settings.clock = [clock] { return Time(clock->now().nanoseconds()); };
  return settings;
}

} // namespace

class CloudSenderNode::Implementation
: public std::enable_shared_from_this<CloudSenderNode::Implementation> {
public:
  explicit Implementation(rclcpp::Node& node)
  : logger_(node.get_logger())
  , clock_(node.get_clock())
  , constants_(node,
               "",
               pcl_ext::nodes::sensorNodeParameters(),
               NodeParameters::Check(),
               NodeParameters::Listener(),
               NodeParameters::Kind::ReadOnly)
  , global_frame_(
        withoutLeadingSlash(valueOf<std::string>(constants_.values(), "global_frame")))
  , tf_timeout_(static_cast<std::int64_t>(
        1e9 * valueOf<double>(constants_.values(), "tf_timeout")))
  , queue_size_(static_cast<std::size_t>(
        valueOf<std::int64_t>(constants_.values(), "queue_size")))
  , transforms_(node, global_frame_)
  , sender_(settingsOf(global_frame_, clock_))
  {}

  void
  connect(rclcpp::Node& node)
  {
    const std::weak_ptr<Implementation> self = weak_from_this();
    parameters_.emplace(node,
                        "",
                        pcl_ext::nodes::encodingParameters(),
                        pcl_ext::nodes::faultOfEncodingParameters,
                        weakCallback(self, &Implementation::setParameters));
    setParameters(parameters_->values());
    const std::string input =
        node.get_node_topics_interface()->resolve_topic_name("input");
    const std::string output = advertise(node, input);
    subscribe(node, input, output);
    const auto lookup = [self] {
      if (const auto alive = self.lock())
        alive->sendClouds();
    };
    lookup_timer_ = node.create_wall_timer(between_lookups, lookup, cloud_group_);
    lookup_timer_->cancel(); // no cloud waits
    health_.emplace(
        node,
        [self, input]() -> std::vector<HealthPublisher::Entry> {
          const auto alive = self.lock();
          if (!alive)
            return {};
          return {{input, alive->describeHealth()}};
        },
        clock_);
    RCLCPP_INFO(logger_, "Compressing %s to %s", input.c_str(), output.c_str());
  }

private:
  struct WaitingCloud {
    std::unique_ptr<PointCloud2> cloud;
    Time deadline; // of the steady clock, for its transform
  };

  /** \return the name of the topic */
  std::string
  advertise(rclcpp::Node& node, const std::string& input)
  {
    rclcpp::PublisherOptions options;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    frames_ = node.create_publisher<CompressedPointCloud2>(
        input + "/pcl_ext", rclcpp::QoS(frame_queue_size), options);
    return frames_->get_topic_name();
  }

  void
  subscribe(rclcpp::Node& node, const std::string& input, const std::string& output)
  {
    const std::weak_ptr<Implementation> self = weak_from_this();
    cloud_group_ =
        node.create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    rclcpp::SubscriptionOptions options;
    options.callback_group = cloud_group_;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    clouds_ = node.create_subscription<PointCloud2>(
        input,
        rclcpp::SensorDataQoS().keep_last(queue_size_),
        weakCallback(self, &Implementation::receive),
        options);
    requests_ = node.create_subscription<std_msgs::msg::Empty>(
        pcl_ext_ros_common::requestTopic(output),
        10,
        [self](const std_msgs::msg::Empty&) {
          if (const auto alive = self.lock())
            alive->sender_.requestIFrame();
        });
    request_service_ = node.create_service<Trigger>(
        "~/request_i_frame",
        [self](const Trigger::Request::SharedPtr&,
               const Trigger::Response::SharedPtr& response) {
          const auto alive = self.lock();
          if (!alive)
            return;
          alive->sender_.requestIFrame();
          response->success = true;
          response->message = "The next frame is an I-frame, unless the last one was";
        });
  }

  void
  setParameters(const ParameterValues& values)
  {
    const std::string fault = sender_.setParameters(values);
    const std::lock_guard<std::mutex> lock(mutex_);
    fault_ = fault;
    if (!fault.empty())
      RCLCPP_ERROR(logger_, "No cloud is sent: %s", fault.c_str());
  }

  void
  receive(std::unique_ptr<PointCloud2> cloud)
  {
    // The middleware does not tell of all clouds that it loses.
    sender_.countMissedBefore(toTime(cloud->header.stamp));
    if (waiting_.size() >= queue_size_) {
      waiting_.pop_front();
      sender_.countMissed(1);
    }
    const Time wait = pcl_ext::nodes::transformWait(
        tf_timeout_, toTime(cloud->header.stamp), Time(clock_->now().nanoseconds()));
    waiting_.push_back({std::move(cloud), pcl_ext::nodes::steadyTime() + wait});
    sendClouds();
  }

  /** \brief Sends the clouds that need not wait any more, in their order. */
  void
  sendClouds()
  {
    while (!waiting_.empty()) {
      const WaitingCloud& first = waiting_.front();
      if (!transforms_.isKnown(first.cloud->header) &&
          pcl_ext::nodes::steadyTime() < first.deadline) {
        lookup_timer_->reset();
        return;
      }
      const std::unique_ptr<PointCloud2> cloud = std::move(waiting_.front().cloud);
      waiting_.pop_front();
      send(*cloud);
    }
    lookup_timer_->cancel();
  }

  void
  send(PointCloud2& cloud)
  {
    if (const std::string reason = fault(); !reason.empty()) {
      drops_.warn("A cloud is dropped: " + reason);
      return;
    }
    std_msgs::msg::Header header = cloud.header;
    const pcl_ext::nodes::FoundTransform transform = transforms_.find(header);
    if (transform.is_latest) {
      sender_.countLatestTransform();
      warnings_.warn("The latest transform is used, as there is none at the stamp: " +
                     transform.failure);
    }
    pcl_ext::nodes::moveToPcl(cloud, cloud_);
    cloud_.header.stamp = pcl_ext_ros_common::toMicroseconds(header.stamp);
    auto message = std::make_unique<CompressedPointCloud2>();
    const auto status = sender_.encode(cloud_,
                                       transform.pose,
                                       frames_->get_subscription_count(),
                                       message->compressed_data);
    if (!status.hasFrame()) {
      drops_.warn("A cloud is dropped: " + status.message() +
                  (transform.pose ? "" : " (" + transform.failure + ")"));
      return;
    }
    if (status.code() == SensorNodeCode::UsedLastTransform)
      warnings_.warn("The transform of an earlier cloud is used, as TF has none: " +
                     transform.failure);
    else if (status.hasWarning())
      warnings_.warn(status.message());
    pcl_ext::nodes::describeFrame(sender_.health().node, sender_.settings(), *message);
    header.frame_id = global_frame_;
    message->header = header;
    frames_->publish(std::move(message));
  }

  std::string
  fault() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return fault_;
  }

  pcl_ext::nodes::HealthReport
  describeHealth()
  {
    if (const std::string reason = fault(); !reason.empty()) {
      pcl_ext::nodes::HealthReport report;
      report.raise(pcl_ext::nodes::HealthLevel::Error, "No cloud is sent: " + reason);
      return report;
    }
    const auto now = sender_.health();
    return pcl_ext::nodes::describeHealth(
        now, std::exchange(reported_, now), pcl_ext::nodes::steadyTime());
  }

  rclcpp::Logger logger_;
  ThrottledLog warnings_{logger_};
  ThrottledLog drops_{logger_};
  rclcpp::Clock::SharedPtr clock_;
  NodeParameters constants_;
  const std::string global_frame_;
  const Time tf_timeout_;
  const std::size_t queue_size_;
  TransformLookup transforms_;
  pcl_ext::nodes::CloudSender sender_;
  pcl_ext::nodes::SenderHealth reported_; // by the timer of health_

  mutable std::mutex mutex_; // guards fault_
  std::string fault_;        // of the parameters; empty: none

  // Of the callbacks of cloud_group_.
  std::deque<WaitingCloud> waiting_; // their order is that of the stream
  pcl::PCLPointCloud2 cloud_;

  std::optional<NodeParameters> parameters_;
  rclcpp::CallbackGroup::SharedPtr cloud_group_;
  rclcpp::Publisher<CompressedPointCloud2>::SharedPtr frames_;
  rclcpp::Subscription<PointCloud2>::SharedPtr clouds_;
  rclcpp::Subscription<std_msgs::msg::Empty>::SharedPtr requests_;
  rclcpp::Service<Trigger>::SharedPtr request_service_;
  rclcpp::TimerBase::SharedPtr lookup_timer_;
  std::optional<HealthPublisher> health_;
};

CloudSenderNode::CloudSenderNode(const rclcpp::NodeOptions& options)
: rclcpp::Node("sensor_node", options)
, implementation_(std::make_shared<Implementation>(*this))
{
  implementation_->connect(*this);
}

CloudSenderNode::~CloudSenderNode() = default;

} // namespace pcl_ext_ros

RCLCPP_COMPONENTS_REGISTER_NODE(pcl_ext_ros::CloudSenderNode)

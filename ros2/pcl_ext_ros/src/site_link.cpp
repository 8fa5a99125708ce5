// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_ros/site_link.hpp"

#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/link/frame_publisher.h>
#include <pcl_ext/link/frame_subscriber.h>
#include <pcl_ext/nodes/impl/cloud_messages.h>

#include <pcl_ext_ros_common/health_publisher.hpp>
#include <pcl_ext_ros_common/message_times.hpp>
#include <pcl_ext_ros_common/throttled_log.hpp>
#include <pcl_ext_ros_common/transport_topic.hpp>
#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <std_msgs/msg/empty.hpp>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace pcl_ext_ros {

using pcl_ext::nodes::HealthLevel;
using pcl_ext::nodes::HealthReport;
using pcl_ext_ros_common::HealthPublisher;
using pcl_ext_ros_common::requestTopic;
using point_cloud_interfaces::msg::CompressedPointCloud2;
using std_msgs::msg::Empty;
namespace link = pcl_ext::link;

namespace {

template <typename ValueT>
ValueT
readOnly(rclcpp::Node& node,
         const std::string& name,
         const ValueT& default_value,
         const std::string& description)
{
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = description;
  descriptor.read_only = true;
  return node.declare_parameter(name, default_value, descriptor);
}

/** \brief Secrets are no parameters, which anybody in the domain may read. */
std::string
environment(const char* name)
{
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

link::LinkSettings
settingsOf(rclcpp::Node& node)
{
  link::LinkSettings settings;
  settings.client_name = node.get_fully_qualified_name();
  const auto read = [&node](const char* name, std::string& value, const char* text) {
    value = readOnly(node, name, value, text);
  };
  read("servers", settings.servers, "nats:// or tls:// addresses with commas between");
  read("site", settings.site, "Name of the site.");
  read("user", settings.user, "Its password is PCL_EXT_PASSWORD of the environment.");
  read("credentials_file", settings.credentials_file, "JWT and seed; '': none.");
  read("ca_file", settings.ca_file, "Certificates to trust; '': the system's.");
  read("certificate_file", settings.certificate_file, "Of this client; '': none.");
  read("key_file", settings.key_file, "Of certificate_file.");
  settings.password = environment("PCL_EXT_PASSWORD");
  settings.token = environment("PCL_EXT_TOKEN");
  return settings;
}

} // namespace

class SiteLink::Implementation
: public std::enable_shared_from_this<SiteLink::Implementation> {
public:
  explicit Implementation(rclcpp::Node& node)
  : logger_(node.get_logger()), clock_(node.get_clock())
  {
    using Names = std::vector<std::string>;
    link::LinkSettings settings = settingsOf(node);
    settings.on_event = [this](const std::string& event) { events_.warn(event); };
    name_ = "site " + settings.site;
    frame_id_ = readOnly<std::string>(
        node, "frame_id", "world", "Of frames of the site that do not name one.");
    const auto to = readOnly(node, "to_site", Names(), "Topics that go to the site.");
    const auto from = readOnly(node, "from_site", Names(), "Streams of the site.");
    link::SubscriberSettings of_subscriber;
    of_subscriber.link = settings;
    of_subscriber.streams = from;
    const auto status = link::checkSettings(settings);
    if (!status.ok())
      throw std::invalid_argument(status.message());
    if (!to.empty())
      publisher_.emplace(settings, [this](std::size_t stream) {
        i_frame_requests_[stream]->publish(Empty());
      });
    if (!from.empty())
      subscriber_.emplace(of_subscriber);
    for (const std::string& name : to) {
      const std::string topic =
          node.get_node_topics_interface()->resolve_topic_name(name);
      outgoing_.push_back(topic);
      i_frame_requests_.push_back(
          node.create_publisher<Empty>(requestTopic(topic), 10));
    }
    for (const std::string& stream : from) {
      auto& frames = incoming_[stream].frames;
      frames = node.create_publisher<CompressedPointCloud2>(stream, queue_size);
      const std::string topic = frames->get_topic_name();
      if (std::find(outgoing_.begin(), outgoing_.end(), topic) != outgoing_.end())
        throw std::invalid_argument(topic + " is of to_site and of from_site");
    }
  }

  ~Implementation()
  {
    stops_ = true;
    if (thread_.joinable())
      thread_.join();
  }

  void
  connect(rclcpp::Node& node)
  {
    const std::weak_ptr<Implementation> self = weak_from_this();
    for (std::size_t i = 0; i < outgoing_.size(); ++i)
      subscriptions_.push_back(node.create_subscription<CompressedPointCloud2>(
          outgoing_[i], queue_size, [self, i](const CompressedPointCloud2& frame) {
            if (const auto alive = self.lock())
              alive->send(i, frame);
          }));
    for (const auto& [stream, topics] : incoming_)
      subscriptions_.push_back(
          node.create_subscription<Empty>(requestTopic(topics.frames->get_topic_name()),
                                          10,
                                          [self, name = stream](const Empty&) {
                                            if (const auto alive = self.lock())
                                              alive->subscriber_->requestIFrame(name);
                                          }));
    health_.emplace(
        node,
        [self]() -> std::vector<HealthPublisher::Entry> {
          const auto alive = self.lock();
          if (!alive)
            return {};
          return {{alive->name_, alive->describeHealth()}};
        },
        clock_);
    thread_ = std::thread([this] { run(); });
  }

private:
  static constexpr std::size_t queue_size = 40;

  /** \brief The topic of a stream of the site. */
  struct Incoming {
    rclcpp::Publisher<CompressedPointCloud2>::SharedPtr frames;
    std::string frame_id; // the last that a frame has named
  };

  void
  send(std::size_t stream, const CompressedPointCloud2& frame)
  {
    if (!sends_)
      return; // not connected yet, which is told
    const auto& bytes = frame.compressed_data;
    const auto status =
        publisher_->publish(stream,
                            pcl_ext_ros_common::toTime(frame.header.stamp),
                            bytes.data(),
                            bytes.size());
    if (!status.ok())
      failures_.warn("A frame of " + outgoing_[stream] +
                     " is not sent: " + status.message());
  }

  /** \brief Connects, however long that takes, and publishes what arrives. */
  void
  run()
  {
    constexpr std::chrono::milliseconds pause(100);
    while (publisher_ && !stops_ && !isOk(publisher_->connect()))
      std::this_thread::sleep_for(pause);
    bool is_complete = !stops_;
    std::size_t number = 0; // the index of the topic
    for (std::size_t i = 0; i < outgoing_.size() && is_complete; ++i) {
      const auto status = publisher_->addStream(outgoing_[i], {}, number);
      is_complete = isOk(status);
      if (!is_complete) {
        const std::lock_guard<std::mutex> lock(refusal_mutex_);
        refusal_ = "Nothing is sent: " + status.message();
      }
    }
    sends_ = is_complete;
    while (subscriber_ && !stops_ && !isOk(subscriber_->connect()))
      std::this_thread::sleep_for(pause);
    link::LinkFrame frame;
    while (subscriber_ && !stops_)
      if (subscriber_->next(frame, pause).ok())
        publish(frame);
  }

  bool
  isOk(const link::LinkStatus& status)
  {
    if (!status.ok())
      events_.warn(status.message());
    return status.ok();
  }

  void
  publish(link::LinkFrame& frame)
  {
    const auto topics = incoming_.find(frame.stream);
    if (topics == incoming_.end())
      return;
    const auto description =
        pcl_ext::io::describeFrame(frame.bytes.data(), frame.bytes.size());
    Incoming& stream = topics->second;
    if (description.frame_id)
      stream.frame_id = *description.frame_id;
    auto message = std::make_unique<CompressedPointCloud2>();
    message->header.stamp = rclcpp::Time(frame.time.count());
    message->header.frame_id = stream.frame_id.empty() ? frame_id_ : stream.frame_id;
    message->format = pcl_ext::nodes::messageFormat(description.format);
    message->compressed_data = std::move(frame.bytes);
    stream.frames->publish(std::move(message));
  }

  HealthReport
  describeHealth()
  {
    HealthReport report;
    const auto need = [&report](bool is_connected) {
      report.raise(is_connected ? HealthLevel::Ok : HealthLevel::Error,
                   is_connected ? "OK" : "Not connected to the site's server");
    };
    if (!publisher_ && !subscriber_)
      report.raise(HealthLevel::Warning, "to_site and from_site are empty");
    if (publisher_) {
      const auto statistics = publisher_->statistics();
      need(statistics.is_connected);
      {
        const std::lock_guard<std::mutex> lock(refusal_mutex_);
        if (!refusal_.empty())
          report.raise(HealthLevel::Error, refusal_);
      }
      report.add("frames sent", statistics.frames);
      report.add("frames not sent", statistics.frames_not_sent);
    }
    if (subscriber_) {
      const auto statistics = subscriber_->statistics();
      need(statistics.is_connected);
      for (const auto& stream : statistics.streams) {
        report.add("frames of " + stream.name, stream.frames);
        report.add("frames lost of " + stream.name, stream.frames_lost);
      }
    }
    return report;
  }

  rclcpp::Logger logger_;
  rclcpp::Clock::SharedPtr clock_;
  pcl_ext_ros_common::ThrottledLog events_{logger_};
  pcl_ext_ros_common::ThrottledLog failures_{logger_};
  std::string name_;
  std::string frame_id_;
  std::vector<std::string> outgoing_; // topics, by number of their stream
  std::vector<rclcpp::Publisher<Empty>::SharedPtr> i_frame_requests_; // likewise
  std::map<std::string, Incoming> incoming_;                          // by stream
  std::optional<link::FramePublisher> publisher_; // after what its threads use
  std::optional<link::FrameSubscriber> subscriber_;
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  std::optional<HealthPublisher> health_;
  std::atomic<bool> sends_{false}; // has the streams of outgoing_
  std::atomic<bool> stops_{false};
  std::mutex refusal_mutex_;
  std::string refusal_; // why a stream of outgoing_ cannot be; empty: it can
  std::thread thread_;
};

SiteLink::SiteLink(const rclcpp::NodeOptions& options)
: rclcpp::Node("site_link", options)
, implementation_(std::make_shared<Implementation>(*this))
{
  implementation_->connect(*this);
}

SiteLink::~SiteLink() = default;

} // namespace pcl_ext_ros

RCLCPP_COMPONENTS_REGISTER_NODE(pcl_ext_ros::SiteLink)

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_ros/merging_centre_node.hpp"

#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/health_metrics.h>
#include <pcl_ext/nodes/impl/merging_centre.h>

#include "central_map.h"
#include "merged_output.h"
#include "stream.h"
#include "stream_topics.h"
#include "stream_view.h"
#include "weak_callback.h"

#include <pcl_ext_ros_common/health_publisher.hpp>
#include <pcl_ext_ros_common/message_times.hpp>
#include <pcl_ext_ros_common/throttled_log.hpp>
#include <rclcpp_components/register_node_macro.hpp>

#include <chrono>
#include <exception>
#include <map>
#include <shared_mutex>
#include <stdexcept>
#include <utility>

namespace pcl_ext_ros {

using pcl_ext::nodes::HealthLevel;
using pcl_ext::nodes::HealthReport;
using pcl_ext::nodes::MergingCentre;
using pcl_ext::nodes::ParameterValues;
using pcl_ext::nodes::Time;
using pcl_ext::nodes::valueOf;
using pcl_ext_ros_common::HealthPublisher;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::ThrottledLog;

namespace {

constexpr std::chrono::milliseconds between_looks_for_subscribers{100};

} // namespace

class MergingCentreNode::Implementation
: public std::enable_shared_from_this<MergingCentreNode::Implementation> {
public:
  explicit Implementation(rclcpp::Node& node)
  : node_(&node)
  , logger_(node.get_logger())
  , clock_(node.get_clock())
  , constants_(node,
               "",
               pcl_ext::nodes::centralNodeParameters(),
               NodeParameters::Check(),
               NodeParameters::Listener(),
               NodeParameters::Kind::ReadOnly)
  , values_(constants_.values())
  , global_frame_(pcl_ext::nodes::withoutLeadingSlash(
        valueOf<std::string>(values_, "global_frame")))
  {
    centre_ = std::make_shared<MergingCentre>(
        pcl_ext::nodes::readCentralNodeParameters(
            values_, [clock = clock_] { return Time(clock->now().nanoseconds()); }),
        [this](const pcl_ext::nodes::ReceivedFrame& frame) { publishFrame(frame); },
        [this](const pcl_ext::nodes::MergedFrame& merged) { publishMerged(merged); });
    if (!centre_->settingsStatus().ok())
      throw std::invalid_argument(centre_->settingsStatus().message());
    if (valueOf<double>(values_, "merge_rate") > 0.0)
      merged_.emplace(node, global_frame_, valueOf<double>(values_, "resolution"));
  }

  // The centre may outlive this, but does not call its listeners any more.
  ~Implementation()
  {
    centre_->setMerging(false);
    centre_->node().waitUntilDecoded();
  }

  /** \brief The node ends: nothing is created with it any more. */
  void
  disconnect()
  {
    {
      const std::lock_guard<std::mutex> lock(node_mutex_);
      node_ = nullptr;
    }
    centre_->setMerging(false);
    centre_->node().waitUntilDecoded();
    if (map_)
      map_->finish();
  }

  /** \brief Connects with the node: what the callbacks use exists. */
  void
  connect(rclcpp::Node& node)
  {
    const std::weak_ptr<Implementation> self = weak_from_this();
    noise_.emplace(node,
                   "",
                   pcl_ext::nodes::noiseParameters(),
                   NodeParameters::Check(),
                   weakCallback(self, &Implementation::setNoise));
    setNoise(noise_->values());
    map_ = std::make_shared<CentralMap>(
        node,
        values_,
        [self] {
          const auto alive = self.lock();
          return alive ? alive->streams() : std::vector<std::shared_ptr<Stream>>();
        },
        std::shared_ptr<const pcl_ext::nodes::CentralNode>(centre_, &centre_->node()));
    report(map_->fault());
    map_->connect(node);
    showStreams();
    topics_.emplace(node, [self](StreamTopics::Topics topics) {
      if (const auto alive = self.lock())
        alive->setTopics(std::move(topics));
    });
    report(topics_->fault());
    // Parameters cannot be declared while others are being set.
    update_timer_ =
        node.create_wall_timer(std::chrono::milliseconds(1),
                               weakCallback(self, &Implementation::updateStreams));
    update_timer_->cancel();
    wanted_ = topics_->initial();
    updateStreams();
    if (merged_)
      subscribers_timer_ = node.create_wall_timer(
          between_looks_for_subscribers,
          weakCallback(self, &Implementation::lookForSubscribers));
    health_.emplace(
        node,
        [self] {
          const auto alive = self.lock();
          return alive ? alive->describeHealth()
                       : std::vector<HealthPublisher::Entry>();
        },
        clock_);
  }

private:
  using Streams = std::map<std::string, std::shared_ptr<Stream>>; // by topic

  std::vector<std::shared_ptr<Stream>>
  streams() const
  {
    std::vector<std::shared_ptr<Stream>> streams;
    const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
    for (const auto& [topic, stream] : streams_)
      streams.push_back(stream);
    return streams;
  }

  std::shared_ptr<Stream>
  find(const std::string& topic) const
  {
    const std::shared_lock<std::shared_mutex> lock(streams_mutex_);
    const auto found = streams_.find(topic);
    return found == streams_.end() ? nullptr : found->second;
  }

  void
  setTopics(StreamTopics::Topics topics)
  {
    {
      const std::lock_guard<std::mutex> lock(node_mutex_);
      wanted_ = std::move(topics);
    }
    update_timer_->reset();
  }

  /** \brief Adds and removes streams until there are those of `streams`. */
  void
  updateStreams()
  {
    update_timer_->cancel();
    const std::lock_guard<std::mutex> lock(node_mutex_);
    if (node_ == nullptr)
      return;
    for (const auto& stream : streams())
      if (wanted_.count(stream->topic()) == 0) {
        RCLCPP_INFO(logger_, "No longer decompressing %s", stream->topic().c_str());
        removeStream(stream->topic());
      }
    for (const auto& [topic, name] : wanted_)
      if (!find(topic))
        addStream(*node_, name, topic);
  }

  void
  addStream(rclcpp::Node& node, const std::string& name, const std::string& topic)
  {
    if (const auto status = centre_->addStream(topic); !status.ok())
      return report("streams: " + status.message());
    const auto stream = std::make_shared<Stream>(node, name, topic, centre_);
    map_->prepareFor(node, *stream);
    {
      const std::unique_lock<std::shared_mutex> lock(streams_mutex_);
      streams_[topic] = stream;
    }
    stream->connect(node,
                    [self = weak_from_this()](Stream& of, Stream::FrameMessage frame) {
                      if (const auto alive = self.lock())
                        alive->receive(of, std::move(frame));
                    });
    RCLCPP_INFO(logger_, "Decompressing %s", topic.c_str());
  }

  void
  removeStream(const std::string& topic)
  {
    {
      const std::unique_lock<std::shared_mutex> lock(streams_mutex_);
      streams_.erase(topic);
    }
    centre_->removeStream(topic);
  }

  /** \brief Logs what is wrong with a parameter, for which the node does without. */
  void
  report(const std::string& fault)
  {
    if (fault.empty())
      return;
    RCLCPP_ERROR(logger_, "%s", fault.c_str());
    faults_ += (faults_.empty() ? "" : "; ") + fault;
  }

  void
  showStreams()
  {
    if (valueOf<std::int64_t>(values_, "view_port") == 0)
      return;
    try {
      view_.emplace(
          values_,
          [this](const std::string& topic) {
            if (const auto stream = find(topic))
              stream->requestIFrame();
          },
          [this] {
            return pcl_ext::nodes::streamMetrics(centre_->node().health(),
                                                 Time(clock_->now().nanoseconds())) +
                   pcl_ext::nodes::mergeMetrics(centre_->mergeCounts());
          });
      RCLCPP_INFO(logger_, "The streams are shown at %s", view_->url().c_str());
      if (!view_->isLoopback())
        RCLCPP_WARN(logger_,
                    "Anyone who can reach this machine can look at the streams");
    }
    catch (const std::exception& failure) {
      report(failure.what());
    }
  }

  void
  lookForSubscribers()
  {
    const std::lock_guard<std::mutex> lock(node_mutex_);
    if (node_ != nullptr)
      centre_->setMerging(merged_->hasSubscribers());
  }

  void
  setNoise(const ParameterValues& values)
  {
    centre_->setNoise(values);
  }

  /** \brief Passes a frame to the centre if it is in the global frame. */
  void
  receive(Stream& stream, Stream::FrameMessage message)
  {
    if (const std::string fault =
            pcl_ext::nodes::faultOfMessage(message, global_frame_);
        !fault.empty()) {
      centre_->countLeftOut(stream.topic());
      left_out_.warn("A frame of " + stream.topic() + " is dropped: " + fault);
      return;
    }
    const Time stamp = pcl_ext_ros_common::toTime(message.header.stamp);
    if (view_)
      view_->show(stream.topic(), stamp, message.compressed_data);
    const auto status =
        centre_->receive(stream.topic(), std::move(message.compressed_data), stamp);
    if (!status.ok())
      failures_.warn(status.message());
  }

  /** \brief The centre's listener. Threads of the centre call it. */
  void
  publishFrame(const pcl_ext::nodes::ReceivedFrame& frame)
  {
    const auto stream = find(frame.stream);
    if (!stream)
      return; // it was removed
    if (frame.wants_i_frame)
      stream->requestIFrame();
    if (frame.status.hasWarning())
      failures_.warn("A frame of " + stream->topic() + ": " + frame.status.message());
    if (!frame.status.ok())
      failures_.warn("A frame of " + stream->topic() +
                     " is not decoded: " + frame.status.message());
    else if (stream->voxels().get_subscription_count() != 0) {
      auto message = std::make_unique<sensor_msgs::msg::PointCloud2>();
      message->header.stamp = rclcpp::Time(frame.stamp.count());
      message->header.frame_id = global_frame_;
      pcl_ext::nodes::writeVoxels(frame.voxels(), *message);
      stream->voxels().publish(std::move(message));
    }
  }

  /** \brief The centre's listener. The thread of the centre calls it. */
  void
  publishMerged(const pcl_ext::nodes::MergedFrame& merged)
  {
    if (merged.status.ok())
      merged_->publish(merged);
    else
      failures_.warn("The streams are not merged: " + merged.status.message());
  }

  void
  describeStream(const std::string& topic, HealthReport& report)
  {
    const auto stream = find(topic);
    if (!stream)
      return;
    const std::size_t publishers = stream->publishers();
    // An error, as frames of each seem to be lost, of which warnings are.
    if (publishers > 1)
      report.raise(HealthLevel::Error,
                   std::to_string(publishers) +
                       " publishers send this stream, which can have one");
    report.add("publishers", publishers);
    const std::lock_guard<std::mutex> lock(node_mutex_);
    if (node_ != nullptr)
      stream->findSources(*node_);
  }

  std::vector<HealthPublisher::Entry>
  describeHealth()
  {
    auto entries = centre_->describeHealth(
        map_->nodes(), [this](const std::string& topic, HealthReport& report) {
          describeStream(topic, report);
        });
    if (!faults_.empty())
      entries.back().second.raise(HealthLevel::Error, faults_);
    return entries;
  }

  std::mutex node_mutex_;       // guards what follows
  rclcpp::Node* node_;          // null when it ends
  StreamTopics::Topics wanted_; // of `streams`

  rclcpp::Logger logger_;
  ThrottledLog left_out_{logger_};
  ThrottledLog failures_{logger_};
  rclcpp::Clock::SharedPtr clock_;
  NodeParameters constants_;
  const ParameterValues values_; // of centralNodeParameters()
  const std::string global_frame_;
  std::string faults_; // of parameters at the start
  std::optional<NodeParameters> noise_;
  std::optional<StreamTopics> topics_;
  rclcpp::TimerBase::SharedPtr update_timer_;
  rclcpp::TimerBase::SharedPtr subscribers_timer_;
  std::optional<HealthPublisher> health_;
  std::optional<MergedOutput> merged_; // none: nothing is merged

  mutable std::shared_mutex streams_mutex_; // guards the map, not its streams
  Streams streams_;

  std::shared_ptr<MergingCentre> centre_;
  std::shared_ptr<CentralMap> map_;
  // Last member, as its thread requests I-frames of the streams and reads their health.
  std::optional<StreamView> view_;
};

MergingCentreNode::MergingCentreNode(const rclcpp::NodeOptions& options)
: rclcpp::Node("central_node", options)
, implementation_(std::make_shared<Implementation>(*this))
{
  implementation_->connect(*this);
}

MergingCentreNode::~MergingCentreNode() { implementation_->disconnect(); }

} // namespace pcl_ext_ros

RCLCPP_COMPONENTS_REGISTER_NODE(pcl_ext_ros::MergingCentreNode)

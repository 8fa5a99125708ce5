#include "pcl_ext_ros/central_node.hpp"

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/cloud_messages.h>
#include <pcl_ext/nodes/health_metrics.h>

#include "central_map.h"
#include "stream.h"
#include "stream_view.h"
#include "weak_callback.h"

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <pcl_ext_ros_common/health_publisher.hpp>
#include <pcl_ext_ros_common/message_times.hpp>
#include <pcl_ext_ros_common/throttled_log.hpp>
#include <rclcpp_components/register_node_macro.hpp>

#include <chrono>
#include <exception>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ext_ros {

using diagnostic_msgs::msg::DiagnosticArray;
using pcl_ext::nodes::HealthLevel;
using pcl_ext::nodes::HealthReport;
using pcl_ext::nodes::ParameterValues;
using pcl_ext::nodes::Time;
using pcl_ext::nodes::valueOf;
using pcl_ext::nodes::withoutLeadingSlash;
using pcl_ext_ros_common::HealthPublisher;
using pcl_ext_ros_common::NodeParameters;
using pcl_ext_ros_common::ThrottledLog;
using sensor_msgs::msg::PointCloud2;

namespace {

/** \brief Resolves the topics of `streams`.
 * \param[in] node whose topics they are
 * \param[in] value of the parameter, of any type
 * \return the topics, each once
 * \throws std::invalid_argument that says what is wrong with the value
 */
std::vector<std::string>
resolveStreams(rclcpp::Node& node, const rclcpp::ParameterValue& value)
{
  const auto refuse = [&](const std::string& reason) {
    throw std::invalid_argument("streams is " + rclcpp::to_string(value) + "; " +
                                reason + ". No stream is decompressed");
  };
  std::vector<std::string> topics;
  if (value.get_type() == rclcpp::ParameterType::PARAMETER_STRING_ARRAY)
    topics = value.get<std::vector<std::string>>();
  if (topics.empty())
    refuse("it must be a list of topics");
  std::set<std::string> known;
  for (std::string& topic : topics) {
    try {
      topic = node.get_node_topics_interface()->resolve_topic_name(topic);
    }
    catch (const std::exception& failure) {
      refuse("'" + topic + "' is no topic: " + failure.what());
    }
    if (!known.insert(topic).second)
      refuse(topic + " is twice in it");
  }
  return topics;
}

/** \brief Declares `streams`. Of any type, as rclcpp ends the program where a value has
 * another type than a parameter. */
rclcpp::ParameterValue
declareStreams(rclcpp::Node& node)
{
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = "Topics of the streams.";
  descriptor.read_only = true;
  descriptor.dynamic_typing = true;
  const std::vector<std::string> by_default{"input"};
  return node.declare_parameter(
      "streams", rclcpp::ParameterValue(by_default), descriptor);
}

void
publish(rclcpp::Publisher<PointCloud2>& publisher,
        const std::string& frame_id,
        const builtin_interfaces::msg::Time& stamp,
        const pcl_ext::io::VoxelFrame& voxels)
{
  auto message = std::make_unique<PointCloud2>();
  message->header.stamp = stamp;
  message->header.frame_id = frame_id;
  pcl_ext::nodes::writeVoxels(voxels, *message);
  publisher.publish(std::move(message));
}

} // namespace

class CentralNode::Implementation
: public std::enable_shared_from_this<CentralNode::Implementation> {
public:
  explicit Implementation(rclcpp::Node& node)
  : logger_(node.get_logger())
  , name_(std::string(node.get_fully_qualified_name()).substr(1))
  , clock_(node.get_clock())
  , constants_(node,
               "",
               pcl_ext::nodes::centralNodeParameters(),
               NodeParameters::Check(),
               NodeParameters::Listener(),
               NodeParameters::Kind::ReadOnly)
  , values_(constants_.values())
  , global_frame_(withoutLeadingSlash(valueOf<std::string>(values_, "global_frame")))
  {
    central_node_ = std::make_shared<pcl_ext::nodes::CentralNode>(
        pcl_ext::nodes::readCentralNodeParameters(
            values_, [clock = clock_] { return Time(clock->now().nanoseconds()); }),
        [this](const pcl_ext::nodes::ReceivedFrame& frame) { publishFrame(frame); });
    if (!central_node_->settingsStatus().ok())
      throw std::invalid_argument(central_node_->settingsStatus().message());
    addStreams(node);
  }

  ~Implementation()
  {
    central_node_->waitUntilDecoded(); // publishFrame() is not called any more
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
    for (const auto& stream : streams_)
      stream->connect(node);
    setNoise(noise_->values());
    map_ = std::make_shared<CentralMap>(node, values_, streams_, central_node_);
    report(map_->fault());
    map_->connect(node);
    showStreams();
    mergePeriodically(node);
    for (const auto& stream : streams_) {
      // The stream is that of an implementation that is alive.
      stream->subscribe(node,
                        [self, number = stream->number()](
                            std::unique_ptr<Stream::FrameMessage> frame) {
                          if (const auto alive = self.lock())
                            alive->receive(*alive->streams_[number], std::move(*frame));
                        });
      RCLCPP_INFO(logger_, "Decompressing %s", stream->topic().c_str());
    }
    health_.emplace(node, [self] {
      const auto alive = self.lock();
      return alive ? alive->describeHealth() : std::vector<HealthPublisher::Entry>();
    });
  }

private:
  /** \brief Adds the streams, or none and reports what is wrong with their parameter. */
  void
  addStreams(rclcpp::Node& node)
  {
    std::vector<std::string> topics;
    try {
      topics = resolveStreams(node, declareStreams(node));
    }
    catch (const std::invalid_argument& fault) {
      return report(fault.what());
    }
    for (const std::string& topic : topics) {
      if (const auto status = central_node_->addStream(topic); !status.ok())
        return report("streams: " + status.message());
      streams_.push_back(
          std::make_shared<Stream>(node, topic, streams_.size(), central_node_));
      streams_by_topic_[topic] = streams_.back();
    }
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
    std::vector<std::string> topics;
    for (const auto& stream : streams_)
      topics.push_back(stream->topic());
    try {
      view_.emplace(
          values_,
          topics,
          [this](std::size_t number) { streams_[number]->requestIFrame(); },
          [this] {
            return pcl_ext::nodes::streamMetrics(central_node_->health(),
                                                 Time(clock_->now().nanoseconds()));
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
  mergePeriodically(rclcpp::Node& node)
  {
    const double rate = valueOf<double>(values_, "merge_rate");
    if (rate <= 0.0)
      return;
    constexpr std::size_t merged_queue_size = 10;
    rclcpp::PublisherOptions options;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    merged_ = node.create_publisher<PointCloud2>(
        "~/merged", rclcpp::QoS(merged_queue_size), options);
    merged_streams_ =
        node.create_publisher<DiagnosticArray>("~/merged/streams", merged_queue_size);
    merge_group_ =
        node.create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    constexpr double longest = 1e6; // seconds, so that a timer can count them
    merge_timer_ = node.create_wall_timer(
        std::chrono::duration<double>(std::min(1.0 / rate, longest)),
        weakCallback(weak_from_this(), &Implementation::publishMerged),
        merge_group_);
  }

  void
  setNoise(const ParameterValues& values)
  {
    for (const auto& stream : streams_)
      stream->setNoiseOfAll(values);
  }

  /** \brief Passes a frame to the central node if it is in the global frame. */
  void
  receive(Stream& stream, Stream::FrameMessage message)
  {
    stream.countArrival();
    if (const std::string fault =
            pcl_ext::nodes::faultOfMessage(message, global_frame_);
        !fault.empty()) {
      stream.countLeftOut();
      left_out_.warn("A frame of " + stream.topic() + " is dropped: " + fault);
      return;
    }
    const Time stamp = pcl_ext_ros_common::toTime(message.header.stamp);
    if (view_)
      view_->show(stream.number(), stamp, message.compressed_data);
    const auto status = central_node_->receive(
        stream.topic(), std::move(message.compressed_data), stamp);
    if (!status.ok())
      failures_.warn(status.message());
  }

  /** \brief The central node's listener. Threads of the central node call it. */
  void
  publishFrame(const pcl_ext::nodes::ReceivedFrame& frame)
  {
    Stream& stream = *streams_by_topic_.at(frame.stream);
    if (frame.wants_i_frame)
      stream.requestIFrame();
    if (!frame.status.ok())
      failures_.warn("A frame of " + stream.topic() +
                     " is not decoded: " + frame.status.message());
    else if (stream.voxels().get_subscription_count() != 0)
      publish(stream.voxels(),
              global_frame_,
              rclcpp::Time(frame.stamp.count()),
              frame.voxels);
  }

  void
  publishMerged()
  {
    if (merged_->get_subscription_count() == 0)
      return;
    const auto status = central_node_->merge(merged_voxels_);
    if (!status.ok()) {
      failures_.warn("The streams are not merged: " + status.message());
      return;
    }
    const Time now(clock_->now().nanoseconds());
    DiagnosticArray merged_streams;
    // Not a stamp of the sources: TF drops the clouds of one whose clock is wrong.
    merged_streams.header.stamp = rclcpp::Time(now.count());
    for (const auto& [stream, report] : pcl_ext::nodes::describeMerged(status, now))
      merged_streams.status.push_back(
          pcl_ext_ros_common::toMessage(name_, stream, report));
    merged_streams_->publish(merged_streams);
    publish(*merged_, global_frame_, merged_streams.header.stamp, merged_voxels_);
  }

  /** \brief Voxel edge of the merged grid, metres; 0: nothing is merged. */
  double
  mergedResolution() const
  {
    return merged_ ? valueOf<double>(values_, "resolution") : 0.0;
  }

  std::vector<HealthPublisher::Entry>
  describeHealth()
  {
    std::vector<HealthPublisher::Entry> entries;
    const std::vector<pcl_ext::nodes::StreamHealth> streams = central_node_->health();
    bool are_ok = true;
    for (const pcl_ext::nodes::StreamHealth& health : streams) {
      HealthReport report =
          streams_by_topic_.at(health.name)->describeHealth(health, mergedResolution());
      are_ok &= report.level() == HealthLevel::Ok;
      entries.emplace_back(health.name, std::move(report));
    }
    HealthReport all = pcl_ext::nodes::describeTogether(streams, are_ok, map_->nodes());
    if (!faults_.empty())
      all.raise(HealthLevel::Error, faults_);
    entries.emplace_back("all streams", std::move(all));
    return entries;
  }

  rclcpp::Logger logger_;
  const std::string name_; // without the first slash
  ThrottledLog left_out_{logger_};
  ThrottledLog failures_{logger_};
  rclcpp::Clock::SharedPtr clock_;
  NodeParameters constants_;
  const ParameterValues values_; // of centralNodeParameters()
  const std::string global_frame_;
  std::string faults_; // of values_
  CentralMap::Streams streams_;
  std::map<std::string, std::shared_ptr<Stream>> streams_by_topic_;
  std::optional<NodeParameters> noise_;
  std::shared_ptr<CentralMap> map_;
  std::optional<HealthPublisher> health_;

  rclcpp::CallbackGroup::SharedPtr merge_group_;
  rclcpp::Publisher<PointCloud2>::SharedPtr merged_; // null: nothing is merged
  rclcpp::Publisher<DiagnosticArray>::SharedPtr merged_streams_;
  rclcpp::TimerBase::SharedPtr merge_timer_;
  pcl_ext::io::VoxelFrame merged_voxels_; // keeps its memory

  std::shared_ptr<pcl_ext::nodes::CentralNode> central_node_;
  // Last member, as its thread requests I-frames of the streams and reads their health.
  std::optional<StreamView> view_;
};

CentralNode::CentralNode(const rclcpp::NodeOptions& options)
: rclcpp::Node("central_node", options)
, implementation_(std::make_shared<Implementation>(*this))
{
  implementation_->connect(*this);
}

CentralNode::~CentralNode() = default;

} // namespace pcl_ext_ros

RCLCPP_COMPONENTS_REGISTER_NODE(pcl_ext_ros::CentralNode)

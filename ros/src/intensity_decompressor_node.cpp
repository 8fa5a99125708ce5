/** \file
 * \brief The central node: compressed frames of many streams in; denoised voxels of each
 * stream, merged voxels and a map out.
 */
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/cloud_messages.h>
#include <pcl_ext/nodes/health_metrics.h>
#include <pcl_ext/nodes/health_report.h>

#include "central_map.h"
#include "health_messages.h"
#include "message_conversions.h"
#include "node_main.h"
#include "node_parameters.h"
#include "parameter_reader.h"
#include "stream_noise.h"
#include "stream_view.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <pcl_ext_ros1/CompressedPointCloud2.h>
#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace pcl_ext_ros1 {

namespace {

using pcl_ext::nodes::HealthLevel;
using pcl_ext::nodes::HealthReport;
using pcl_ext::nodes::ReceiverHealth;
using pcl_ext::nodes::StreamHealth;
using pcl_ext::nodes::valueOf;

constexpr double seconds_between_noise_updates = 0.2;
constexpr std::uint32_t frame_queue_size = 40;
constexpr std::uint32_t voxels_queue_size = 10;
constexpr std::uint32_t message_threads = 2; // merging does not delay frames

/** \brief One stream. Its address does not change. */
struct Stream {
  Stream(std::string resolved_topic,
         const StreamParameters& stream_parameters,
         const pcl_ext::nodes::ParameterValues& noise_of_all)
  : topic(std::move(resolved_topic))
  , noise(topic, stream_parameters.noise, noise_of_all)
  {}

  const std::string topic; ///< resolved; the stream's name in the central node
  std::size_t number = 0;  ///< in the order of ~streams
  StreamNoise noise;
  pcl_ext::nodes::NoiseSettings noise_in_force; ///< of the timer of noise
  ros::Publisher voxels;
  ros::Publisher i_frame_requests;
  ros::Subscriber frames;

  // Written when frames arrive, read by timers.
  std::atomic<pcl_ext::nodes::Time> last_arrival{pcl_ext::nodes::Time(0)}; ///< 0: never
  std::atomic<std::uint64_t> left_out{0}; ///< frames of another frame id or format

  // As of the last report.
  ReceiverHealth reported;
};

} // namespace

/** \brief Decompresses, denoises, merges and maps streams. doc/nodes.md has the topics,
 * services and parameters. */
class IntensityDecompressor {
public:
  /** \brief Reads the parameters and connects.
   * \throws WrongParameter
   */
  IntensityDecompressor()
  {
    central_node_.emplace(
        pcl_ext::nodes::readCentralNodeParameters(parameters_.node, rosTimeNow),
        [this](const pcl_ext::nodes::ReceivedFrame& frame) { publishFrame(frame); });
    if (!central_node_->settingsStatus().ok())
      throw WrongParameter("Parameters contradict each other: " +
                           central_node_->settingsStatus().message());
    map_.emplace(private_node_, parameters_, *central_node_);
    diagnostics_ =
        node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
    if (merge_rate_ > 0) {
      merged_ = private_node_.advertise<sensor_msgs::PointCloud2>("merged",
                                                                  voxels_queue_size);
      merged_streams_ = private_node_.advertise<diagnostic_msgs::DiagnosticArray>(
          "merged/streams", voxels_queue_size);
    }
    for (const StreamParameters& stream : parameters_.streams)
      addStream(stream);
    if (valueOf<std::int64_t>(parameters_.node, "view_port") != 0)
      showStreams();
    // Frames arrive from here on. The members above do not change any more.
    for (const auto& stream : streams_)
      subscribe(*stream);
    createTimers();
  }

  /** \brief Runs until ROS shuts down, then writes the map, if there is one. */
  int
  run()
  {
    map_->start();
    ros::MultiThreadedSpinner(message_threads).spin();
    central_node_->waitUntilDecoded();
    return map_->finish();
  }

private:
  void
  addStream(const StreamParameters& parameters)
  {
    const std::string topic = node_.resolveName(parameters.topic);
    streams_.push_back(std::make_unique<Stream>(topic, parameters, parameters_.noise));
    Stream& stream = *streams_.back();
    stream.number = streams_.size() - 1;
    stream.noise_in_force = stream.noise.settings();
    if (!central_node_->addStream(topic, stream.noise_in_force.min_intensity).ok())
      ParameterReader::refuse(
          "streams", "a list with " + topic + " twice", "a list of different topics");
    central_node_->setOutlierRemoval(topic, stream.noise_in_force.outlier_removal);
    streams_by_topic_[topic] = &stream;
    map_->addStream(topic, parameters.sensor_frame);
    stream.voxels =
        node_.advertise<sensor_msgs::PointCloud2>(topic + "/voxels", voxels_queue_size);
    stream.i_frame_requests =
        node_.advertise<std_msgs::Empty>(topic + "/request_i_frame", 10);
  }

  void
  showStreams()
  {
    std::vector<std::string> topics;
    for (const auto& stream : streams_)
      topics.push_back(stream->topic);
    view_.emplace(
        parameters_.node,
        topics,
        [this](std::size_t number) {
          streams_[number]->i_frame_requests.publish(std_msgs::Empty());
        },
        [this] {
          return pcl_ext::nodes::streamMetrics(central_node_->health(), rosTimeNow());
        });
  }

  void
  subscribe(Stream& stream)
  {
    const boost::function<void(const CompressedPointCloud2::ConstPtr&)> callback =
        [this, &stream](const CompressedPointCloud2::ConstPtr& message) {
          receive(stream, *message);
        };
    stream.frames =
        node_.subscribe<CompressedPointCloud2>(stream.topic,
                                               frame_queue_size,
                                               callback,
                                               ros::VoidConstPtr(),
                                               ros::TransportHints().tcpNoDelay());
    ROS_INFO("Decompressing %s", stream.topic.c_str());
  }

  void
  createTimers()
  {
    // Wall timers run while simulated time or a replay stands still, too.
    noise_timer_ =
        node_.createWallTimer(ros::WallDuration(seconds_between_noise_updates),
                              &IntensityDecompressor::updateNoise,
                              this);
    report_timer_ = node_.createWallTimer(
        ros::WallDuration(1.0), &IntensityDecompressor::reportHealth, this);
    constexpr double longest = 1e6; // seconds, so that a timer can count them
    if (merge_rate_ > 0)
      merge_timer_ =
          node_.createWallTimer(ros::WallDuration(std::min(1.0 / merge_rate_, longest)),
                                &IntensityDecompressor::publishMerged,
                                this);
  }

  /** \brief Passes a frame to the central node if it is in the global frame. */
  void
  receive(Stream& stream, const CompressedPointCloud2& message)
  {
    stream.last_arrival = pcl_ext::nodes::steadyTime();
    if (const std::string fault =
            pcl_ext::nodes::faultOfMessage(message, parameters_.global_frame);
        !fault.empty()) {
      ++stream.left_out;
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A frame of %s is dropped: %s",
                        stream.topic.c_str(),
                        fault.c_str());
      return;
    }
    if (view_)
      view_->show(stream.number, message.header.stamp, message.compressed_data);
    const auto status = central_node_->receive(
        stream.topic, message.compressed_data, toNodeTime(message.header.stamp));
    if (!status.ok())
      ROS_WARN_THROTTLE(seconds_between_warnings, "%s", status.message().c_str());
  }

  /** \brief The central node's listener. Threads of the central node call it. */
  void
  publishFrame(const pcl_ext::nodes::ReceivedFrame& frame)
  {
    Stream& stream = *streams_by_topic_.at(frame.stream);
    if (frame.wants_i_frame)
      stream.i_frame_requests.publish(std_msgs::Empty());
    if (!frame.status.ok())
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A frame of %s is not decoded: %s",
                        stream.topic.c_str(),
                        frame.status.message().c_str());
    else if (stream.voxels.getNumSubscribers() != 0)
      publish(stream.voxels, toRosTime(frame.stamp), frame.voxels);
  }

  void
  publish(const ros::Publisher& publisher,
          const ros::Time& stamp,
          const pcl_ext::io::VoxelFrame& voxels) const
  {
    std_msgs::Header header;
    header.stamp = stamp;
    header.frame_id = parameters_.global_frame;
    publisher.publish(toMessage(header, voxels));
  }

  void
  updateNoise(const ros::WallTimerEvent&)
  {
    for (const auto& stream : streams_) {
      stream->noise.update();
      setNoise(*stream, stream->noise.settings());
    }
  }

  void
  setNoise(Stream& stream, const pcl_ext::nodes::NoiseSettings& noise)
  {
    const pcl_ext::nodes::NoiseSettings before =
        std::exchange(stream.noise_in_force, noise);
    const char* const topic = stream.topic.c_str();
    if (noise.min_intensity != before.min_intensity) {
      central_node_->setMinIntensity(stream.topic, noise.min_intensity);
      ROS_INFO("%s: min_intensity is now %g", topic, double{noise.min_intensity});
    }
    const auto& removal = noise.outlier_removal;
    if (removal.has_value() == before.outlier_removal.has_value() &&
        (!removal || removal->min_log_odds == before.outlier_removal->min_log_odds))
      return;
    central_node_->setOutlierRemoval(stream.topic, removal);
    if (removal)
      ROS_INFO("%s: outliers below log-odds %g are removed from now on",
               topic,
               double{removal->min_log_odds});
    else
      ROS_INFO("%s: outliers are not removed from now on", topic);
  }

  void
  publishMerged(const ros::WallTimerEvent&)
  {
    if (merged_.getNumSubscribers() == 0)
      return;
    const ros::Time now = ros::Time::now();
    const auto status = central_node_->merge(merged_voxels_);
    if (!status.ok()) {
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "The streams are not merged: %s",
                        status.message().c_str());
      return;
    }
    diagnostic_msgs::DiagnosticArray merged_streams;
    // Not a stamp of the sources: TF drops the clouds of one whose clock is wrong.
    merged_streams.header.stamp = now;
    for (const auto& [stream, report] :
         pcl_ext::nodes::describeMerged(status, toNodeTime(now)))
      merged_streams.status.push_back(toMessage(stream, report));
    merged_streams_.publish(merged_streams);
    publish(merged_, now, merged_voxels_);
  }

  void
  reportHealth(const ros::WallTimerEvent&)
  {
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = ros::Time::now();
    const std::vector<StreamHealth> streams = central_node_->health();
    bool are_ok = true;
    for (const StreamHealth& health : streams) {
      Stream& stream = *streams_by_topic_.at(health.name);
      const ReceiverHealth now = healthOf(stream, health);
      const HealthReport report = pcl_ext::nodes::describeHealth(
          now, std::exchange(stream.reported, now), pcl_ext::nodes::steadyTime());
      are_ok &= report.level() == HealthLevel::Ok;
      message.status.push_back(toMessage(stream.topic, report));
    }
    const HealthReport all =
        pcl_ext::nodes::describeTogether(streams, are_ok, map_->nodes());
    message.status.push_back(toMessage("all streams", all));
    diagnostics_.publish(message);
  }

  ReceiverHealth
  healthOf(const Stream& stream, const StreamHealth& health) const
  {
    const bool is_merged = merge_rate_ > 0 || map_->exists();
    const pcl_ext::nodes::Time last_arrival = stream.last_arrival;
    return {health,
            stream.left_out,
            stream.noise.settings().min_intensity,
            last_arrival == pcl_ext::nodes::Time(0) ? std::nullopt
                                                    : std::optional(last_arrival),
            is_merged ? valueOf<double>(parameters_.node, "resolution") : 0.0};
  }

  ros::NodeHandle node_;
  ros::NodeHandle private_node_{"~"};
  const DecompressorParameters parameters_ = readDecompressorParameters();
  const double merge_rate_ =
      valueOf<double>(parameters_.node, "merge_rate"); // 0: no merging
  std::vector<std::unique_ptr<Stream>> streams_;
  std::unordered_map<std::string, Stream*> streams_by_topic_;
  std::optional<CentralMap> map_; // none only before the constructor makes it

  ros::Publisher merged_;
  ros::Publisher merged_streams_;
  ros::Publisher diagnostics_;
  ros::WallTimer noise_timer_;
  ros::WallTimer merge_timer_;
  ros::WallTimer report_timer_;
  pcl_ext::io::VoxelFrame merged_voxels_; // keeps its memory

  // Behind the other members, as its threads call publishFrame() until it is destroyed.
  std::optional<pcl_ext::nodes::CentralNode> central_node_;

  // Last member, as its thread requests I-frames of the streams and reads their health.
  std::optional<StreamView> view_;
};

} // namespace pcl_ext_ros1

int
main(int argc, char** argv)
{
  return pcl_ext_ros1::runNode<pcl_ext_ros1::IntensityDecompressor>(
      argc, argv, "intensity_decompressor");
}

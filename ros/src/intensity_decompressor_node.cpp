/** \file
 * \brief The central node: compressed frames of many streams in; denoised voxels of each
 * stream, merged voxels and a map out.
 */
#include <pcl_ext/nodes/cloud_messages.h>
#include <pcl_ext/nodes/health_metrics.h>
#include <pcl_ext/nodes/merging_centre.h>

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
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace pcl_ext_ros1 {

namespace {

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

  const std::string topic; ///< resolved; the stream's name in the centre
  std::size_t number = 0;  ///< in the order of ~streams
  StreamNoise noise;
  ros::Publisher voxels;
  ros::Publisher i_frame_requests;
  ros::Subscriber frames;
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
    auto settings =
        pcl_ext::nodes::readCentralNodeParameters(parameters_.node, rosTimeNow);
    settings.reports_resolution |=
        !valueOf<std::string>(parameters_.node, "map_path").empty();
    centre_.emplace(
        settings,
        [this](const pcl_ext::nodes::ReceivedFrame& frame) { publishFrame(frame); },
        pcl_ext::nodes::MergeListener());
    if (!centre_->settingsStatus().ok())
      throw WrongParameter("Parameters contradict each other: " +
                           centre_->settingsStatus().message());
    map_.emplace(private_node_, parameters_, centre_->node());
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
    centre_->node().waitUntilDecoded();
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
    if (!centre_->addStream(topic).ok())
      ParameterReader::refuse(
          "streams", "a list with " + topic + " twice", "a list of different topics");
    centre_->setNoise(topic, stream.noise.values());
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
          using namespace pcl_ext::nodes;
          return streamMetrics(centre_->node().health(), rosTimeNow()) +
                 mergeMetrics(centre_->mergeCounts());
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
    if (const std::string fault =
            pcl_ext::nodes::faultOfMessage(message, parameters_.global_frame);
        !fault.empty()) {
      centre_->countLeftOut(stream.topic);
      ROS_WARN_THROTTLE(seconds_between_warnings,
                        "A frame of %s is dropped: %s",
                        stream.topic.c_str(),
                        fault.c_str());
      return;
    }
    if (view_)
      view_->show(stream.number, message.header.stamp, message.compressed_data);
    const auto status = centre_->receive(
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
      centre_->setNoise(stream->topic, stream->noise.values());
    }
  }

  void
  publishMerged(const ros::WallTimerEvent&)
  {
    if (merged_.getNumSubscribers() == 0)
      return;
    const ros::Time now = ros::Time::now();
    const auto status = centre_->node().merge(merged_voxels_);
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
         pcl_ext::nodes::describeMerged(centre_->sourcesOf(status), toNodeTime(now)))
      merged_streams.status.push_back(toMessage(stream, report));
    merged_streams_.publish(merged_streams);
    publish(merged_, now, merged_voxels_);
  }

  void
  reportHealth(const ros::WallTimerEvent&)
  {
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = ros::Time::now();
    for (const auto& [name, report] : centre_->describeHealth(map_->nodes()))
      message.status.push_back(toMessage(name, report));
    diagnostics_.publish(message);
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
  std::optional<pcl_ext::nodes::MergingCentre> centre_;

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

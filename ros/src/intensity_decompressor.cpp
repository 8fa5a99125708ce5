#include "intensity_decompressor.h"

#include "message_conversions.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_msgs/Empty.h>

#include <iostream>
#include <utility>

namespace pcl_ext_ros {

namespace {

using diagnostic_msgs::DiagnosticStatus;
using pcl_ext::nodes::CentralNodeStatus;
using pcl_ext::nodes::StreamHealth;

constexpr double seconds_between_warnings = 5.0;
constexpr double seconds_between_noise_updates = 0.2;
constexpr std::uint32_t frame_queue_size = 40;
constexpr std::uint32_t voxels_queue_size = 10;
constexpr std::uint32_t threads_for_messages = 2; // so that merging delays no frame

std::int64_t
wallClock()
{
  return static_cast<std::int64_t>(ros::WallTime::now().toNSec());
}

DecompressorParameters
readParameters()
{
  ParameterReader reader;
  DecompressorParameters parameters = readDecompressorParameters(reader);
  parameters.node.clock = rosTimeNow;
  return parameters;
}

} // namespace

IntensityDecompressor::Stream::Stream(std::string resolved_topic,
                                      const StreamParameters& stream_parameters,
                                      const NoiseParameters& noise_of_all)
: topic(std::move(resolved_topic))
, parameters(stream_parameters)
, noise(topic, stream_parameters, noise_of_all)
{}

IntensityDecompressor::IntensityDecompressor() : parameters_(readParameters())
{
  central_node_.emplace(
      parameters_.node,
      [this](const pcl_ext::nodes::ReceivedFrame& frame) { showFrame(frame); });
  if (!central_node_->settingsStatus().ok())
    throw WrongParameter("Parameters contradict each other: " +
                         central_node_->settingsStatus().message());
  if (!parameters_.map.path.empty())
    map_.emplace(parameters_.node.resolution,
                 parameters_.map.full_intensity,
                 parameters_.map.path);
  diagnostics_ = node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  if (parameters_.merge_rate > 0)
    merged_ =
        private_node_.advertise<sensor_msgs::PointCloud2>("merged", voxels_queue_size);
  for (const StreamParameters& stream : parameters_.streams)
    addStream(stream);
  // Frames come from here on, when nothing of the above changes any more.
  for (const auto& stream : streams_)
    subscribe(*stream);
  createTimers();
}

void
IntensityDecompressor::addStream(const StreamParameters& parameters)
{
  const std::string topic = node_.resolveName(parameters.topic);
  streams_.push_back(std::make_unique<Stream>(topic, parameters, parameters_.noise));
  Stream& stream = *streams_.back();
  if (!central_node_->addStream(topic, stream.noise.minIntensity()).ok())
    ParameterReader::refuse(
        "streams", "a list with " + topic + " twice", "a list of different topics");
  central_node_->setOutlierRemoval(topic, stream.noise.outlierRemoval());
  streams_by_topic_[topic] = &stream;
  stream.voxels =
      node_.advertise<sensor_msgs::PointCloud2>(topic + "/voxels", voxels_queue_size);
  stream.i_frame_requests =
      node_.advertise<std_msgs::Empty>(topic + "/request_i_frame", 10);
  if (map_ && !parameters.sensor_frame.empty() && !transforms_)
    transforms_.emplace(parameters_.global_frame, parameters_.map.tf_timeout);
}

void
IntensityDecompressor::subscribe(Stream& stream)
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
IntensityDecompressor::createTimers()
{
  // By the wall clock, so that they go on when a simulation or a replay pauses.
  noise_timer_ = node_.createWallTimer(ros::WallDuration(seconds_between_noise_updates),
                                       &IntensityDecompressor::updateNoise,
                                       this);
  report_timer_ = node_.createWallTimer(
      ros::WallDuration(1.0), &IntensityDecompressor::reportHealth, this);
  if (parameters_.merge_rate > 0)
    merge_timer_ =
        node_.createWallTimer(ros::WallDuration(1.0 / parameters_.merge_rate),
                              &IntensityDecompressor::publishMerged,
                              this);
  ros::NodeHandle map_node(private_node_);
  map_node.setCallbackQueue(&map_queue_);
  map_service_ =
      map_node.advertiseService("write_map", &IntensityDecompressor::writeMap, this);
  if (map_)
    map_timer_ = map_node.createWallTimer(
        ros::WallDuration(1.0 / parameters_.map.rate),
        boost::function<void(const ros::WallTimerEvent&)>(
            [this](const ros::WallTimerEvent&) { updateMap(Rays::Yes); }));
}

int
IntensityDecompressor::run()
{
  ros::AsyncSpinner map_spinner(1, &map_queue_);
  map_spinner.start();
  ros::MultiThreadedSpinner(threads_for_messages).spin();
  map_spinner.stop();
  central_node_->waitUntilDecoded();
  if (!map_)
    return 0;
  // Without rays, which may take longer than whoever told us to stop is going to wait.
  updateMap(Rays::No);
  // ROS's console is gone.
  if (map_->size() == 0) {
    std::cout << "The map is empty and was not written\n";
    return 0;
  }
  const FusedMap::Written written = map_->write();
  (written.ok ? std::cout : std::cerr) << written.message << '\n';
  return written.ok ? 0 : 1;
}

void
IntensityDecompressor::receive(Stream& stream, const CompressedPointCloud2& message)
{
  stream.last_arrival = wallClock();
  if (withoutLeadingSlash(message.header.frame_id) != parameters_.global_frame) {
    ++stream.left_out;
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "Leaving out a frame of %s, which is in '%s', not in '%s'",
                      stream.topic.c_str(),
                      message.header.frame_id.c_str(),
                      parameters_.global_frame.c_str());
    return;
  }
  if (!hasKnownFormat(message)) {
    ++stream.left_out;
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "Leaving out a frame of %s, whose format is '%s'",
                      stream.topic.c_str(),
                      message.format.c_str());
    return;
  }
  const CentralNodeStatus status = central_node_->receive(
      stream.topic, message.compressed_data, toNodeTime(message.header.stamp));
  if (!status.ok())
    ROS_WARN_THROTTLE(seconds_between_warnings, "%s", status.message().c_str());
}

void
IntensityDecompressor::showFrame(const pcl_ext::nodes::ReceivedFrame& frame)
{
  Stream& stream = *streams_by_topic_.at(frame.stream);
  if (frame.wants_i_frame)
    stream.i_frame_requests.publish(std_msgs::Empty());
  if (!frame.status.ok()) {
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "A frame of %s is not shown: %s",
                      stream.topic.c_str(),
                      frame.status.message().c_str());
    return;
  }
  if (stream.voxels.getNumSubscribers() == 0)
    return;
  std_msgs::Header header;
  header.stamp = toRosTime(frame.stamp);
  header.frame_id = parameters_.global_frame;
  stream.voxels.publish(toMessage(header, frame.voxels));
}

void
IntensityDecompressor::updateNoise(const ros::WallTimerEvent&)
{
  for (const auto& stream : streams_) {
    const char* const topic = stream->topic.c_str();
    if (stream->noise.updateMinIntensity()) {
      const float min_intensity = stream->noise.minIntensity();
      central_node_->setMinIntensity(stream->topic, min_intensity);
      ROS_INFO("%s: min_intensity is %g now", topic, double{min_intensity});
    }
    if (stream->noise.updateOutlierRemoval()) {
      const auto removal = stream->noise.outlierRemoval();
      central_node_->setOutlierRemoval(stream->topic, removal);
      if (removal)
        ROS_INFO("%s: outliers below log-odds of %g are removed now",
                 topic,
                 double{removal->min_log_odds});
      else
        ROS_INFO("%s: outliers are not removed any more", topic);
    }
  }
}

void
IntensityDecompressor::publishMerged(const ros::WallTimerEvent&)
{
  if (merged_.getNumSubscribers() == 0)
    return;
  central_node_->merge(merged_voxels_);
  std_msgs::Header header;
  header.stamp = ros::Time::now();
  header.frame_id = parameters_.global_frame;
  merged_.publish(toMessage(header, merged_voxels_));
}

void
IntensityDecompressor::updateMap(Rays rays)
{
  for (const auto& stream : streams_) {
    if (rays == Rays::Yes && !ros::ok())
      break; // run() adds the rest
    const auto frame = central_node_->latestVoxels(stream->topic, map_voxels_);
    // The same frame again would count as further evidence.
    if (!frame || frame->number == stream->mapped)
      continue;
    stream->mapped = frame->number;
    std::optional<octomap::point3d> origin;
    if (rays == Rays::Yes && transforms_ && !stream->parameters.sensor_frame.empty()) {
      std_msgs::Header header;
      header.stamp = toRosTime(frame->stamp);
      header.frame_id = stream->parameters.sensor_frame;
      const FoundTransform transform = transforms_->toGlobalFrame(header);
      if (transform.pose) {
        const Eigen::Vector3f position = transform.pose->translation().cast<float>();
        origin.emplace(position.x(), position.y(), position.z());
      }
      else
        ROS_WARN_THROTTLE(seconds_between_warnings,
                          "No rays for the map from %s: %s",
                          stream->topic.c_str(),
                          transform.failure.c_str());
    }
    map_->insert(map_voxels_, origin);
  }
  map_->completeRound();
  map_nodes_ = map_->size();
}

bool
IntensityDecompressor::writeMap(std_srvs::Trigger::Request&,
                                std_srvs::Trigger::Response& response)
{
  response.success = 0;
  if (!map_) {
    response.message = "There is no map, as ~map_path is not set";
    return true;
  }
  updateMap(Rays::Yes);
  const FusedMap::Written written = map_->write();
  response.success = written.ok ? 1 : 0;
  response.message = written.message;
  return true;
}

void
IntensityDecompressor::reportHealth(const ros::WallTimerEvent&)
{
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  HealthReport all("all streams");
  double frames_per_second = 0.0;
  double bytes_per_second = 0.0;
  std::uint64_t in_sync = 0;
  for (const StreamHealth& health : central_node_->health()) {
    Stream& stream = *streams_by_topic_.at(health.name);
    const HealthReport report = describeHealth(stream, health);
    stream.reported = health;
    stream.reported_left_out = stream.left_out;
    frames_per_second += health.rates.frames_per_second;
    bytes_per_second += health.rates.bytes_per_second;
    in_sync += health.in_sync ? 1 : 0;
    if (report.status().level != DiagnosticStatus::OK)
      all.raise(DiagnosticStatus::WARN, "Not all streams are well");
    message.status.push_back(report.status());
  }
  all.add("streams", std::uint64_t{streams_.size()});
  all.add("streams in sync", in_sync);
  all.add("frames per second", frames_per_second);
  all.add("bytes per second", bytes_per_second);
  all.add("map nodes", map_nodes_.load());
  message.status.push_back(all.status());
  diagnostics_.publish(message);
}

HealthReport
IntensityDecompressor::describeHealth(const Stream& stream, const StreamHealth& now)
{
  HealthReport report(stream.topic);
  const StreamHealth& before = stream.reported;
  const std::uint64_t left_out = stream.left_out;
  const std::int64_t last_arrival = stream.last_arrival;
  if (last_arrival == 0)
    report.raise(DiagnosticStatus::STALE, "No frame has arrived yet");
  else if (wallClock() - last_arrival > silence.toNSec())
    report.raise(DiagnosticStatus::ERROR, "No frames arrive");
  if (left_out > stream.reported_left_out)
    report.raise(DiagnosticStatus::ERROR, "Frames are of another frame id or format");
  if (now.frames_failed > before.frames_failed)
    report.raise(DiagnosticStatus::WARN, "Frames fail: " + now.last_failure.message());
  if (now.frames_refused > before.frames_refused)
    report.raise(DiagnosticStatus::WARN, "Frames arrive faster than they are decoded");
  if (now.frames_lost > before.frames_lost)
    report.raise(DiagnosticStatus::WARN, "Frames are lost on the way");
  if (now.voxels > 0 && now.kept_voxels == 0)
    report.raise(DiagnosticStatus::WARN, "All voxels are taken for noise");

  report.add(now.rates);
  constexpr double bytes_per_point = 16.0; // of the published clouds
  const double bytes_per_frame =
      now.frames_received == 0
          ? 0.0
          : static_cast<double>(now.bytes) / static_cast<double>(now.frames_received);
  report.add("compression ratio",
             bytes_per_frame > 0.0
                 ? bytes_per_point * static_cast<double>(now.voxels) / bytes_per_frame
                 : 0.0);
  report.add("frames received", std::uint64_t{now.frames_received});
  report.add("frames decoded", std::uint64_t{now.frames_decoded});
  report.add("frames failed", std::uint64_t{now.frames_failed});
  report.add("frames dropped", std::uint64_t{now.frames_dropped});
  report.add("frames refused", std::uint64_t{now.frames_refused});
  report.add("frames lost", std::uint64_t{now.frames_lost});
  report.add("frames of other frame id or format", left_out);
  report.add("I-frame requests", std::uint64_t{now.i_frame_requests});
  report.add("voxels", std::uint64_t{now.voxels});
  report.add("kept voxels", std::uint64_t{now.kept_voxels});
  report.add("outliers removed", std::uint64_t{now.outliers_removed});
  report.add("min_intensity", double{stream.noise.minIntensity()});
  report.add("in sync", std::string(now.in_sync ? "yes" : "no"));
  return report;
}

} // namespace pcl_ext_ros

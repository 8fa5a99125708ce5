#include "intensity_compressor.h"

#include "message_conversions.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <pcl_conversions/pcl_conversions.h>
#include <pcl_ext_ros/CompressedPointCloud2.h>

#include <utility>
#include <vector>

namespace pcl_ext_ros {

namespace {

using diagnostic_msgs::DiagnosticStatus;
using pcl_ext::nodes::SensorNodeCode;
using pcl_ext::nodes::SensorNodeStatistics;
using pcl_ext::nodes::SensorNodeStatus;

constexpr double seconds_between_warnings = 5.0;
constexpr std::uint32_t frame_queue_size = 40;

CompressorParameters
readParameters()
{
  ParameterReader reader;
  CompressorParameters parameters = readCompressorParameters(reader);
  parameters.node.clock = rosTimeNow;
  return parameters;
}

} // namespace

IntensityCompressor::IntensityCompressor()
: parameters_(readParameters())
, sensor_node_(parameters_.node)
, transforms_(parameters_.node.global_frame, parameters_.tf_timeout)
{
  if (!sensor_node_.settingsStatus().ok())
    throw WrongParameter("Parameters contradict each other: " +
                         sensor_node_.settingsStatus().message());
  input_topic_ = node_.resolveName("input");
  const std::string output_topic = node_.resolveName(input_topic_ + "/pcl_ext");
  // Who joins would else see nothing until it has asked.
  const auto welcome = [this](const ros::SingleSubscriberPublisher&) {
    i_frame_is_wanted_ = true;
  };
  frames_ =
      node_.advertise<CompressedPointCloud2>(output_topic, frame_queue_size, welcome);
  diagnostics_ = node_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  requests_ = node_.subscribe(output_topic + "/request_i_frame",
                              10,
                              &IntensityCompressor::receiveRequest,
                              this);
  clouds_ = node_.subscribe(input_topic_,
                            parameters_.queue_size,
                            &IntensityCompressor::compress,
                            this,
                            ros::TransportHints().tcpNoDelay());
  // By the wall clock, so that a silent simulation is reported, too.
  report_timer_ = node_.createWallTimer(
      ros::WallDuration(1.0), &IntensityCompressor::reportHealth, this);
  ROS_INFO("Compressing %s to %s", input_topic_.c_str(), output_topic.c_str());
}

int
IntensityCompressor::run()
{
  ros::spin();
  return 0;
}

void
IntensityCompressor::compress(const sensor_msgs::PointCloud2::Ptr& cloud)
{
  countMissed(cloud->header.seq);
  ++counts_.clouds;
  last_arrival_ = ros::WallTime::now();
  std_msgs::Header header = cloud->header;
  const FoundTransform transform = transforms_.toGlobalFrame(header);
  if (transform.is_latest) {
    ++counts_.latest_transforms;
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "Using the latest transform, as there is none at the stamp: %s",
                      transform.failure.c_str());
  }
  if (!transform.pose && header.frame_id != frame_of_last_transform_) {
    // The sensor node would take the last transform, which is another frame's.
    ++counts_.clouds_of_other_frame;
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "Leaving out a cloud, as there is no transform: %s",
                      transform.failure.c_str());
    return;
  }

  pcl::PCLPointCloud2 input;
  pcl_conversions::moveToPCL(*cloud, input);
  passOnIFrameRequest();
  std::vector<std::uint8_t> bytes;
  const SensorNodeStatus status = sensor_node_.encode(input, transform.pose, bytes);
  if (transform.pose && status.code() != SensorNodeCode::InvalidTransform)
    frame_of_last_transform_ = header.frame_id;
  if (status.code() == SensorNodeCode::UsedLastTransform)
    ROS_WARN_THROTTLE(seconds_between_warnings,
                      "Using the last transform, as TF knows none any more: %s",
                      transform.failure.c_str());
  if (!status.hasFrame()) {
    ROS_WARN_THROTTLE(
        seconds_between_warnings, "Leaving out a cloud: %s", status.message().c_str());
    return;
  }
  ++frames_since_request_;
  header.frame_id = parameters_.node.global_frame;
  frames_.publish(toMessage(header,
                            parameters_.node.compression.format,
                            sensor_node_.statistics().frame.coding.voxels,
                            std::move(bytes)));
}

void
IntensityCompressor::countMissed(std::uint32_t number)
{
  // Numbers that go far ahead or back are those of a sender that began again, or of two.
  constexpr std::uint32_t most = 1000;
  const std::uint32_t gap = number - last_number_ - 1;
  if (counts_.clouds != 0 && gap < most)
    counts_.clouds_missed += gap;
  last_number_ = number;
}

void
IntensityCompressor::passOnIFrameRequest()
{
  if (!i_frame_is_wanted_ || frames_since_request_ < 2)
    return;
  sensor_node_.requestIFrame();
  i_frame_is_wanted_ = false;
  frames_since_request_ = 0;
}

void
IntensityCompressor::receiveRequest(const std_msgs::Empty&)
{
  ++counts_.i_frame_requests;
  i_frame_is_wanted_ = true;
}

void
IntensityCompressor::reportHealth(const ros::WallTimerEvent&)
{
  const SensorNodeStatistics now = sensor_node_.statistics();
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  message.status.push_back(describeHealth(now).status());
  diagnostics_.publish(message);
  if (parameters_.statistics)
    ROS_INFO("%.1f frames/s, %.1f kB/s, ratio %.1f, %.1f ms, %zu voxels, %.3f bytes "
             "per voxel",
             now.rates.frames_per_second,
             1e-3 * now.rates.bytes_per_second,
             now.compressionRatio(),
             1e3 * now.rates.mean_cycle_seconds,
             now.frame.coding.voxels,
             now.frame.bytesPerVoxel());
  reported_counts_ = counts_;
  reported_statistics_ = now;
}

HealthReport
IntensityCompressor::describeHealth(const SensorNodeStatistics& now) const
{
  HealthReport report(input_topic_);
  const std::size_t without_transform =
      now.clouds_without_transform + counts_.clouds_of_other_frame;
  const std::size_t last_transforms =
      now.frames_with_last_transform + counts_.latest_transforms;
  const SensorNodeStatistics& before = reported_statistics_;
  if (counts_.clouds == 0)
    report.raise(DiagnosticStatus::STALE, "No cloud has arrived yet");
  else if (ros::WallTime::now() - last_arrival_ > silence)
    report.raise(DiagnosticStatus::ERROR, "No clouds arrive");
  if (without_transform >
      before.clouds_without_transform + reported_counts_.clouds_of_other_frame)
    report.raise(DiagnosticStatus::ERROR,
                 "Clouds are left out for want of a transform");
  if (counts_.clouds_missed > reported_counts_.clouds_missed)
    report.raise(DiagnosticStatus::WARN,
                 "Clouds arrive faster than they are compressed");
  if (now.clouds_refused > before.clouds_refused)
    report.raise(DiagnosticStatus::ERROR, "Clouds are refused");
  if (last_transforms >
      before.frames_with_last_transform + reported_counts_.latest_transforms)
    report.raise(DiagnosticStatus::WARN, "The last known transform is used");

  report.add(now.rates);
  report.add("compression ratio", now.compressionRatio());
  report.add("clouds", std::uint64_t{counts_.clouds});
  report.add("clouds missed", std::uint64_t{counts_.clouds_missed});
  report.add("frames", std::uint64_t{now.frames});
  report.add("I-frames", std::uint64_t{now.i_frames});
  report.add("I-frame requests", std::uint64_t{counts_.i_frame_requests});
  report.add("frames with last transform", std::uint64_t{last_transforms});
  report.add("clouds without transform", std::uint64_t{without_transform});
  report.add("clouds refused", std::uint64_t{now.clouds_refused});
  report.add("points", std::uint64_t{now.preprocessing.points});
  report.add("points cropped", std::uint64_t{now.preprocessing.points_cropped});
  report.add("points not finite", std::uint64_t{now.preprocessing.points_not_finite});
  report.add("outliers removed", std::uint64_t{now.outliers_removed});
  report.add("voxels", std::uint64_t{now.frame.coding.voxels});
  report.add("bytes per voxel", now.frame.bytesPerVoxel());
  return report;
}

} // namespace pcl_ext_ros
